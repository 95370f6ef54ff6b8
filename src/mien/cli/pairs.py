"""`mien pairs`: from a few landmarks to many correspondences."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def pairs(
    source: Annotated[Path, typer.Argument(help="The actor: markers (.c3d, .trc) or a mesh (.glb, .obj folder).")],
    target: Annotated[Path, typer.Argument(help="The character.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Where to write (.pairs.json).")],
    landmarks: Annotated[
        tuple[Path, Path] | None,
        typer.Option(help="Landmarks of both sides; files beside them if not given.", metavar="SOURCE TARGET"),
    ] = None,
    count: Annotated[int, typer.Option(min=4, help="How many pairs to make between meshes.")] = 99,
    neutral: Annotated[
        int | None, typer.Option(min=0, help="Frame number of the actor's neutral, for markers.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print what was made as JSON.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Find which point of SOURCE is which point of TARGET, from landmarks on both.

    Examples:
      mien pairs actor.glb hero.glb --landmarks actor.json hero.json -o actor_hero.pairs.json

      mien pairs take.c3d hero.glb --landmarks take.json hero.json -o take_hero.pairs.json
    """
    from mien.cli.say import console, print_json, print_notes, stages
    from mien.io.documents import write_pairs
    from mien.io.formats import read_rig
    from mien.job.outputs import check_place
    from mien.job.pairs import OWN, find_pairs
    from mien.job.performance import load_source

    check_place(
        output, [source, target, *(path for path in landmarks or () if path != OWN)], (".json",), "a pairs file"
    )
    with stages(quiet) as stage:
        stage("read")
        side, character = load_source(source), read_rig(target)
        stage("pair")
        found, notes = find_pairs(
            side, character, landmarks=landmarks, count=count, neutral=None if neutral is None else str(neutral)
        )
        write_pairs(output, found, character.neutral, side.actor.neutral if side.actor else None)
    if json:
        print_json({"pairs": len(found), "warnings": [vars(note) for note in notes]})
    elif not quiet:
        console().print(f"{len(found)} pairs\nwrote {output}")
        print_notes(notes)
