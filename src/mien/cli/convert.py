"""`mien convert`: one clip, another file or vocabulary."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Optional

import typer


def convert(
    source: Annotated[Path, typer.Argument(help="Weights or animation: .csv, .npz, .glb.")],
    output: Annotated[Path, typer.Argument(help="Where to write: .csv or .npz.")],
    to: Annotated[Optional[str], typer.Option(help="Vocabulary of the names: arkit.")] = None,
    csv_format: Annotated[str, typer.Option(help="weights, or livelink for the Live Link Face layout.")] = "weights",
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Convert animation between files, and shape names between vocabularies.

    Examples:

      mien convert phone.csv weights.npz

      mien convert studio.csv phone.csv --to arkit --csv-format livelink
    """
    from mien.cli.say import console, print_notes
    from mien.io.formats import read_clip, write_clip
    from mien.job.convert import renamed

    clip, notes = renamed(read_clip(source), to)
    write_clip(output, clip, to=csv_format if output.suffix.lower() == ".csv" else None)
    if not quiet:
        console().print(f"{len(clip)} frames, {len(clip.names)} channels\nwrote {output}")
        print_notes((*clip.notes, *notes))
