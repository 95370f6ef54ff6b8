"""`mien evaluate`: a result against the truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

LINES = (
    ("weight RMSE", "rmse", "over the shapes that move"),
    ("correlation", "correlation", "1 is right"),
    ("gain", "gain", "1 is right, less is too weak"),
    ("jerk", "jerk", "1 is as smooth as the truth, more is jitter"),
    ("active weights", "active", "per frame"),
    ("other side", "other_side", "of one-sided expressions; 0 is right"),
    ("vertex error, mm", "vertex_mm", "mean over moving vertices, on a 23 cm head"),
    ("  95th percentile", "vertex_p95_mm", ""),
    ("lids at blinks, mm", "lid_mm", "off the truth's gap"),
    ("lips at closures, mm", "lip_mm", "off the truth's gap"),
)
"""What is printed: title, figure, and how to read it."""


def evaluate(
    result: Annotated[Path, typer.Argument(help="Weights to judge: .csv, .npz or an animated .glb.")],
    truth: Annotated[Path, typer.Argument(help="The true weights of the same performance.")],
    character: Annotated[
        Path | None,
        typer.Option(help="The rig both play on, for errors in millimetres (landmarks beside it are used)."),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print as JSON, shape by shape.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print the figures, but no remarks.")] = False,
) -> None:
    """Compare RESULT with TRUTH: weight RMSE, correlation, gain, jerk, and vertex error in mm.

    Examples:
      mien evaluate out.csv truth.csv

      mien evaluate out.csv truth.csv --character hero.glb --json
    """
    from mien.cli.say import print_json, print_notes
    from mien.evaluate.files import evaluate as compare

    found = compare(result, truth, character)
    if json:
        notes = [vars(note) for note in found.notes]
        print_json({"frames": found.frames, **_plain(found.figures), "warnings": notes})
        return
    _print(found.frames, found.figures)
    if not quiet:
        print_notes(found.notes)


def _print(frames: int, figures: dict[str, Any]) -> None:
    from mien.cli.say import console

    out = console()
    out.print(f"{frames} frames, {len(figures['per_shape'])} shapes that move")
    for title, key, remark in LINES:
        value = figures.get(key)
        if value is not None and value == value:
            out.print(f"  {title:22}{value:8.3f}   {remark}".rstrip())


def _plain(value: Any) -> Any:
    """Return figures as JSON has them: no NaN."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    return None if isinstance(value, float) and value != value else value
