"""`mien inspect`: what a file holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer


def inspect(
    file: Annotated[Path, typer.Argument(help="Any file or folder mien reads.")],
    json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Say what a FILE holds: meshes, shapes (empty ones named), channels, markers, gaps, frame rate, units.

    Examples:
      mien inspect hero.glb

      mien inspect take.c3d --json
    """
    from mien.cli.say import print_json
    from mien.job.describe import describe

    found = describe(file)
    if json:
        print_json(found)
    else:
        _print(found)


def _print(found: dict[str, Any]) -> None:
    from rich.text import Text

    from mien.cli.say import console

    out = console()
    out.print(Text.assemble((found["file"], "bold"), f" ({found['format']})"))
    if rig := found.get("rig"):
        size = " × ".join(f"{x * 100:.1f}" for x in rig["size_m"])
        out.print(
            f"  face: {rig['vertices']} vertices, {rig['triangles']} triangles, {size} cm, {rig['joints']} joints"
        )
        out.print(f"  parts: {', '.join(f'{name} ({n})' for name, n in rig['parts'].items()) or 'one'}")
        _columns("shapes, and how far each moves the skin", {n: f"{mm:.1f} mm" for n, mm in rig["shapes"].items()})
        if rig["empty_shapes"]:
            out.print(Text.assemble(("  empty shapes", "yellow"), f": {', '.join(rig['empty_shapes'])}"))
        if rig["landmarks"]:
            out.print(f"  landmarks beside it: {rig['landmarks']}")
    if clip := found.get("clip"):
        extra = [name for name in ("head", "eyes", "joints") if clip[name]]
        lost = f", {clip['lost_frames']} frames lost" if clip["lost_frames"] else ""
        out.print(
            Text.assemble(
                f"  animation: {clip['frames']} frames at {clip['fps']:g} fps ({clip['seconds']:.2f} s)",
                f", with {', '.join(extra)}" if extra else "",
                (lost, "yellow"),
            )
        )
        ranges = {name: "lost" if a is None else f"{a:.2f} … {b:.2f}" for name, (a, b) in clip["channels"].items()}
        _columns("channels, lowest … highest", ranges)
        if clip["still_channels"]:
            out.print(Text.assemble(("  never move", "yellow"), f": {', '.join(clip['still_channels'])}"))
    if markers := found.get("markers"):
        size = " × ".join(f"{x * 100:.1f}" for x in markers["size_m"] or [])
        out.print(
            f"  {len(markers['markers'])} markers, {markers['frames']} frames at {markers['fps']:g} fps "
            f"({markers['seconds']:.2f} s), reaching over {size} cm"
        )
        out.print(f"  {', '.join(markers['markers'])}")
        gaps = ", ".join(f"{name} ({n})" for name, n in markers["missing"].items())
        out.print(Text.assemble(("  missing samples", "yellow"), f": {gaps}") if gaps else "  no gaps")
    if landmarks := found.get("landmarks"):
        out.print(f"  {len(landmarks)} landmarks: {', '.join(landmarks)}")
    for note in found.get("warnings", []):
        out.print(Text.assemble(("  · ", "yellow"), note["message"]))


def _columns(title: str, values: dict[str, str]) -> None:
    from rich.columns import Columns
    from rich.text import Text

    from mien.cli.say import console

    out = console()
    out.print(f"  {len(values)} {title}:")
    out.print(Columns([Text.assemble(name, (f" {value}", "dim")) for name, value in values.items()], padding=(0, 3)))
