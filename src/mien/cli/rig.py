"""`mien rig`: a whole rig onto any face."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mien.cli import options


def rig(
    generic: Annotated[
        str, typer.Argument(help="The rig to move: `builtin`, a .glb, .gltf, .mhskel or folder of .obj.")
    ],
    face: Annotated[Path, typer.Argument(help="The bare face: .glb, .gltf, .obj.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Where to write the rigged face: .glb or .gltf.")],
    landmarks: Annotated[
        tuple[Path, Path] | None,
        typer.Option(
            help="Landmarks of both; - for a side's own, files beside them if not given.", metavar="GENERIC FACE"
        ),
    ] = None,
    method: Annotated[
        str, typer.Option(help="warp-and-stick, deformation-transfer or rbf; the last two move blendshapes only.")
    ] = "warp-and-stick",
    shapes: Annotated[
        str, typer.Option(help="Templates to make blendshapes of: arkit,emotions,visemes,blinks, or none.")
    ] = "arkit,emotions,visemes,blinks",
    influences: Annotated[int, typer.Option(help="The most joints a vertex follows: 4 or 8.")] = 4,
    parts: Annotated[
        str, typer.Option(help="auto: bring the eyes, teeth and tongue that the face lacks; none: bring nothing.")
    ] = "auto",
    report: Annotated[Path | None, typer.Option(help="An account of the result to read by script (.json).")] = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Move a rig (bones, skin, muscles, expressions) onto a FACE of any triangulation.

    Examples:
      mien rig builtin scan.glb --landmarks - scan.landmarks.json -o scan_rigged.glb

      mien rig hero.glb villain.glb --landmarks hero.json villain.json -o villain_rigged.glb

      mien rig hero.glb villain.glb --method deformation-transfer -o villain_shapes.glb
    """
    from mien.cli.say import console, print_json, print_notes, stages
    from mien.job.outputs import check_place
    from mien.job.pairs import OWN
    from mien.job.rig import SUFFIXES, RigRequest, run, write

    wanted = () if shapes.strip() in ("", "none") else tuple(part.strip() for part in shapes.split(",") if part.strip())
    given = [Path(generic), face, *(path for path in landmarks or () if path != OWN)]
    check_place(output, given, SUFFIXES, "a rigged face")
    if report is not None:
        check_place(report, [*given, output], (".json",), "the report")
    with stages(quiet) as stage:
        rigged = run(RigRequest(generic, face, landmarks, method, influences, parts, wanted), stage)
        stage("write")
        rigged = write(rigged, output, influences, report)
    account = rigged.as_json()
    if json:
        print_json(account)
    if json or quiet:
        return
    out = console()
    out.print(
        f"{account['landmarks']} landmarks, {len(account['joints'])} joints, {len(account['blendshapes'])} blendshapes, "
        f"{len(account['animations'])} animations"
    )
    out.print(
        f"folds {account['folds_before']} before repair, {account['folds_after']} after; the skin was moved "
        f"{account['stuck_rms_mm']:.1f} mm onto the face, on a human-sized head"
    )
    print_notes(rigged.notes)
    for path in (output, report):
        if path is not None:
            out.print(f"wrote {path}")
