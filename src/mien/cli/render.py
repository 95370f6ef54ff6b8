"""`mien render`: pictures of an animated face, without a display, and a page that plays it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def render(
    file: Annotated[Path, typer.Argument(help="A face: .glb, .gltf or a folder of .obj.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Where to write: .png (a sheet), .mp4 (a film) or .html (a player).")
    ],
    clip: Annotated[Path | None, typer.Option(help="Weights to play, if not the file's own animation.")] = None,
    view: Annotated[str, typer.Option(help="front, three-quarter or side.")] = "front",
    size: Annotated[int, typer.Option(min=32, max=4096, help="Width and height of a picture [pixels].")] = 480,
    frames: Annotated[
        str | None, typer.Option(help="Frames of the sheet, e.g. 0,120,300; telling ones if not given.")
    ] = None,
    count: Annotated[int, typer.Option(min=1, max=200, help="How many frames to pick for a sheet.")] = 12,
    fps: Annotated[float | None, typer.Option(help="Frames per second of the film; at most 30 if not given.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print what was written as JSON.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Picture a FILE: a sheet of telling frames, a film, or a page that plays in any browser.

    Examples:
      mien render out.glb -o sheet.png

      mien render out.glb -o film.mp4 --size 720

      mien render out.glb -o player.html

      mien render hero.glb --clip weights.csv -o film.mp4 --view three-quarter
    """
    from mien.cli.say import console, counted, print_json
    from mien.job.outputs import check_place
    from mien.job.picture import PICTURES, picture

    check_place(output, [file, *([clip] if clip else [])], PICTURES, "a picture")
    chosen = None
    if frames is not None:
        try:
            chosen = [int(part) for part in frames.split(",")]
        except ValueError:
            raise typer.BadParameter(f"{frames!r} is not a list of frame numbers.", param_hint="--frames") from None
    with counted(quiet, "rendering") as progress:
        picture(file, output, clip=clip, view=view, size=size, frames=chosen, count=count, fps=fps, progress=progress)
    if json:
        print_json({"written": [str(output)]})
    elif not quiet:
        console().print(f"wrote {output}")
