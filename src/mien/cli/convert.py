"""`mien convert`: one clip, another file or vocabulary."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def convert(
    source: Annotated[Path, typer.Argument(help="Weights or animation: .csv, .npz, .glb.")],
    output: Annotated[Path, typer.Argument(help="Where to write: .csv or .npz.")],
    to: Annotated[str | None, typer.Option(help="Vocabulary of the names: arkit.")] = None,
    csv_format: Annotated[str, typer.Option(help="weights, or livelink for the Live Link Face layout.")] = "weights",
    json: Annotated[bool, typer.Option("--json", help="Print what was written as JSON.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Convert animation between files, and shape names between vocabularies.

    Examples:
      mien convert phone.csv weights.npz

      mien convert studio.csv phone.csv --to arkit --csv-format livelink
    """
    from mien.cli.say import console, print_json, print_notes
    from mien.io.formats import read_clip, write_clip
    from mien.job.convert import renamed
    from mien.job.outputs import check_outputs, losses

    check_outputs([output], [source], csv_format=csv_format)
    clip, notes = renamed(read_clip(source), to)
    write_clip(output, clip, to=csv_format if output.suffix.lower() == ".csv" else None)
    notes = (*clip.notes, *notes, *losses(clip, [output], csv_format))
    if json:
        print_json({"frames": len(clip), "channels": list(clip.names), "warnings": [vars(note) for note in notes]})
    elif not quiet:
        console().print(f"{len(clip)} frames, {len(clip.names)} channels\nwrote {output}")
        print_notes(notes)
