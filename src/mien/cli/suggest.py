"""`mien suggest`: which frames to label next."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mien.cli import options


def suggest(
    performance: options.PerformanceFile,
    model: Annotated[Path, typer.Argument(help="What `mien fit` made of the labels so far (.mien).")],
    count: Annotated[int, typer.Option(min=1, max=1000, help="How many frames.")] = 5,
    actor: options.Actor = None,
    onto: Annotated[
        Path | None, typer.Option("--character", help="Where the model's character is now, if it has moved.")
    ] = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Say which frames of a PERFORMANCE to label next, and how much each would tell a MODEL.

    The gain is the share of today's doubt over all frames that a label takes away, those before it made.

    Examples:
      mien suggest take.c3d hero.mien

      mien suggest take.c3d hero.mien --count 10 --json
    """
    from mien.cli.say import console, print_json, stages
    from mien.job.suggest import ask, suggest_frames

    with stages(quiet) as stage:
        stage("suggest")
        found = suggest_frames(ask(performance, model, actor, onto), count)
    if json:
        print_json(found.as_json())
        return
    out = console()
    for frame, gain in zip(found.frames, found.gain, strict=True):
        out.print(f"frame {frame:6d}   {frame / found.fps:8.2f} s   gain {gain:6.1%}")
    if not quiet:
        out.print(f"all of them: {found.gain.sum():.0%} of today's doubt")
