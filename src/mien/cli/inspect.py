"""`mien inspect`: what a file holds, and what a take shows of a character."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:  # loading the methods takes longer than most inspections
    from mien.job.coverage import Coverage

COLOURS = {"shown well": "green", "shown weakly": "yellow", "not shown": "red"}


def inspect(
    file: Annotated[Path, typer.Argument(help="Any file or folder mien reads.")],
    character: Annotated[
        Path | None, typer.Argument(help="For --coverage: the rig whose shapes are asked about.")
    ] = None,
    coverage: Annotated[
        bool, typer.Option("--coverage", help="Say which shapes the take FILE shows, how strongly, and which not.")
    ] = False,
    actor: Annotated[Path | None, typer.Option(help="For --coverage: the actor's rig, when FILE is weights.")] = None,
    pairs: Annotated[Path | None, typer.Option(help="For --coverage: which point is which (.pairs.json).")] = None,
    landmarks: Annotated[
        tuple[Path, Path] | None,
        typer.Option(help="For --coverage: landmarks of take and character.", metavar="SOURCE TARGET"),
    ] = None,
    neutral: Annotated[
        str | None,
        typer.Option(help="For --coverage: the actor's neutral, a frame number or a file; found if not given."),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """Say what a FILE holds, or what a take shows of a character.

    A file: meshes, shapes (empty ones named), channels, markers, gaps, frame rate, units.
    A take, with --coverage: which of the CHARACTER's shapes it shows well, weakly or not at all.

    Examples:
      mien inspect hero.glb

      mien inspect take.c3d --json

      mien inspect rom.c3d --coverage hero.glb --landmarks rom.json hero.json

      mien inspect phone.csv --coverage
    """
    from mien.cli.say import print_json

    if coverage:
        from mien.job.coverage import coverage as covered

        shown = covered(file, character, actor=actor, pairs=pairs, landmarks=landmarks, neutral=neutral)
        if json:
            print_json(shown.as_json())
        else:
            _print_coverage(shown)
        return
    if any(option is not None for option in (character, actor, pairs, landmarks, neutral)):
        raise typer.BadParameter("a character and its options go with --coverage.")
    from mien.job.describe import describe

    found = describe(file)
    if json:
        print_json(found)
    else:
        _print(found)


def _print_coverage(shown: Coverage) -> None:
    from rich.table import Table
    from rich.text import Text

    from mien.cli.say import console, print_notes

    table = Table("shape", "reached", "likeness", "at", "verdict", box=None, header_style="bold")
    for shape in shown.shapes:
        likeness = "" if shape.correlation is None else f"{shape.correlation:.2f}"
        verdict = Text(shape.verdict, COLOURS.get(shape.verdict, "dim"))
        table.add_row(Text(shape.name), f"{shape.reached:.2f}", likeness, f"{shape.second:.1f} s", verdict)
    out = console()
    out.print(table)
    counts = ", ".join(f"{n} {verdict}" for verdict, n in shown.as_json()["verdicts"].items() if n)
    out.print(f"{len(shown.shapes)} shapes: {counts}")
    print_notes(shown.notes)


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
