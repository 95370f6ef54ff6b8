"""`mien pose`: a whole pose from a few values."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mien.cli import options


def pose(
    character: Annotated[
        Path, typer.Argument(help="The rig: .glb, .gltf, a folder of .obj; or its .csv of parameters.")
    ],
    model: Annotated[Path, typer.Argument(help="What `mien fit --method latent` made of it (.mien).")],
    set_: Annotated[list[str], typer.Option("--set", help="NAME=VALUE: a parameter of the pose; repeat for several.")],
    output: Annotated[
        list[Path] | None,
        typer.Option("-o", "--output", help="Where to write: .csv, .glb, .gltf, .npz or .png; repeat for several."),
    ] = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Complete a pose of a CHARACTER from a few values, by the poses a MODEL has seen.

    Examples:
      mien pose hero.glb hero.mien --set jawOpen=.6 --set browInnerUp=.8

      mien pose hero.glb hero.mien --set jawOpen=.6 -o pose.glb -o pose.png
    """
    from mien.cli.parse import numbers
    from mien.cli.say import console, print_json, stages
    from mien.job import pose as job
    from mien.job.outputs import ANIMATED, check_place

    given = numbers(set_, "--set")
    for path in output or []:
        check_place(path, [character, model], (*ANIMATED, job.PICTURE), "a pose")
    with stages(quiet) as stage:
        stage("pose")
        posed = job.pose(character, model, given)
        for path in output or []:
            stage("write")
            job.write(posed, path)
    if json:
        print_json({"given": given, "parameters": {name: round(v, 6) for name, v in posed.values().items()}})
    elif not quiet:
        out = console()
        for name, value in sorted(posed.values().items(), key=lambda item: -abs(item[1])):
            mark = "given" if name in given else ""
            if mark or abs(value) >= job.SHOWN:
                out.print(f"{name:28}{value:8.3f}   {mark}".rstrip())
        for path in output or []:
            out.print(f"wrote {path}")
