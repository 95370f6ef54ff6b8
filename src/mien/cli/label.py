"""`mien label`: frames to label, as pictures and a table to fill in."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mien.cli import options

if TYPE_CHECKING:
    from mien.job.label import Choice


def label(
    performance: options.PerformanceFile,
    side: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL|CHARACTER", help="A model to improve (.mien); or the character, or its .csv of parameters."
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the pictures and labels.csv.")],
    count: Annotated[int, typer.Option(min=1, max=1000, help="How many frames; with --list, all that are found.")] = 10,
    listed: Annotated[
        bool,
        typer.Option(
            "--list", help="The actor did the list of docs/calibration-take.md, in its order: label all of it."
        ),
    ] = False,
    actor: options.Actor = None,
    pairs: options.Pairs = None,
    landmarks: options.Landmarks = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Choose the most telling frames of a PERFORMANCE: a picture of each, and labels.csv to fill in.

    With a model of any method that follows points or learns from labels, its predictions stand in the new rows, to
    be corrected, and beside the actor in the pictures. Rows that are in the folder's labels.csv
    already are kept as they are.

    With --list no row has to be filled in: each expression of the list is found in the take and labelled with the
    CHARACTER's shapes of Apple's names, to be checked in the pictures. That needs --pairs or --landmarks as
    `mien retarget` does, unless they lie beside the files.

    Examples:
      mien label take.c3d hero.glb -o labels --count 10

      mien fit take.c3d hero.glb --method latent --examples labels/labels.csv -o hero.mien

      mien label take.c3d hero.mien -o labels --count 5

      mien retarget take.c3d hero.glb --examples labels/labels.csv -o out.glb

      mien label rom.c3d hero.glb --list -o labels

      mien retarget take.c3d hero.glb --training rom.c3d --examples labels/labels.csv --set full_range=false -o out.glb
    """
    from mien.cli.say import print_json, stages
    from mien.core import InputError
    from mien.job import label as job
    from mien.job.label_list import choose_listed

    if not listed and (pairs is not None or landmarks is not None):
        raise InputError("--pairs and --landmarks are for --list, which compares the actor with the character.")

    with stages(quiet) as stage:
        stage("choose")
        if listed:
            choice = choose_listed(performance, side, output, actor=actor, pairs=pairs, landmarks=landmarks)
        else:
            choice = job.choose(performance, side, output, count=count, actor=actor)
        stage("write")
        written = job.write(choice, output)
    if json:
        print_json(
            {
                "frames": choice.frames.tolist(),
                "predicted": choice.filled,
                "captions": list(choice.captions),
                "written": [str(path) for path in written],
                "warnings": [vars(note) for note in choice.notes],
            }
        )
    elif not quiet:
        _say(choice, written[0], listed=listed)


def _say(choice: Choice, table: Path, *, listed: bool) -> None:
    """Print which frames were chosen, and what is to be done with the table."""
    from mien.cli.say import console, print_notes

    out = console()
    captions = choice.captions or ("",) * len(choice.frames)
    each = ", ".join(f"{frame} {caption}".rstrip() for frame, caption in zip(choice.frames, captions, strict=True))
    out.print(f"{len(choice.frames)} frames {'recognised' if listed else 'to label'}: {each}")
    print_notes(choice.notes)
    todo = "check and correct" if listed else "correct" if choice.filled else "fill in"
    out.print(
        f"{todo} the new rows of {table} (a blank cell says nothing, 0 says at rest), delete those you leave out, then fit"
    )
