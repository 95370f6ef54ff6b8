"""`mien label`: frames to label, as pictures and a table to fill in."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mien.cli import options


def label(
    performance: options.PerformanceFile,
    side: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL|CHARACTER", help="A model to improve (.mien); or the character, or its .csv of parameters."
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the pictures and labels.csv.")],
    count: Annotated[int, typer.Option(min=1, max=1000, help="How many frames.")] = 10,
    actor: options.Actor = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Choose the most telling frames of a PERFORMANCE: a picture of each, and labels.csv to fill in.

    With a model of any method that follows points or learns from labels, its predictions stand in the new rows, to
    be corrected, and beside the actor in the pictures. Rows that are in the folder's labels.csv
    already are kept as they are.

    Examples:
      mien label take.c3d hero.glb -o labels --count 10

      mien fit take.c3d hero.glb --method latent --examples labels/labels.csv -o hero.mien

      mien label take.c3d hero.mien -o labels --count 5

      mien retarget take.c3d hero.glb --examples labels/labels.csv -o out.glb
    """
    from mien.cli.say import console, print_json, print_notes, stages
    from mien.job import label as job

    with stages(quiet) as stage:
        stage("choose")
        choice = job.choose(performance, side, output, count=count, actor=actor)
        stage("write")
        written = job.write(choice, output)
    if json:
        print_json(
            {
                "frames": choice.frames.tolist(),
                "predicted": choice.filled,
                "written": [str(path) for path in written],
                "warnings": [vars(note) for note in choice.notes],
            }
        )
    elif not quiet:
        out = console()
        out.print(f"{len(choice.frames)} frames to label: {', '.join(map(str, choice.frames))}")
        print_notes(choice.notes)
        todo = "correct the new rows" if choice.filled else "fill in the rows"
        out.print(
            f"{todo} of {written[0]} (a blank cell says nothing, 0 says at rest), delete those you leave out, then fit"
        )
