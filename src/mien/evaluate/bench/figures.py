"""The figures of the benchmark: what each is called, which way is better, and how much worse is a regression."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

Sense = Literal["low", "high", "one"]


class Figure(NamedTuple):
    """One column.

    Attributes:
        key: its name in files.
        title: its name in tables.
        sense: `low` is better, `high` is better, or `one` is right.
        slack: how much worse, beyond a share of the figure, is no regression; None where it is not gated.
        meaning: how to read it.
    """

    key: str
    title: str
    sense: Sense
    slack: float | None
    meaning: str


FIGURES = (
    Figure("rmse", "RMSE", "low", 0.002, "of the weights, over frames and the shapes that move"),
    Figure("correlation", "corr", "high", 0.003, "of the weights with the truth; 1 is right"),
    Figure("gain", "gain", "one", 0.005, "slope of the weights on the truth; 1 is right, less is too weak"),
    Figure("vertex_mm", "mm", "low", 0.01, "mean distance of the moving vertices from the truth, on a 23 cm head"),
    Figure("lid_mm", "lids", "low", 0.05, "gap of the lids off the truth's while its eyes are closed, mm"),
    Figure("lip_mm", "lips", "low", 0.05, "gap of the lips off the truth's while its lips meet, mm"),
    Figure("jerk", "jerk", "one", 0.03, "third difference of the weights over the truth's; 1 is as smooth"),
    Figure("fit_mm", "fit", "low", 0.01, "mean residual at the markers, by the method's own account, mm"),
    Figure(
        "crossings", "cross", "low", 1.0, "pairs of triangles that cross and do not at rest, at the strongest frames"
    ),
    Figure("frame_ms", "ms", "low", None, "time per frame of the test take"),
    Figure("fit_s", "set-up", "low", None, "time to fit, s"),
    Figure("memory_mb", "MB", "low", None, "most memory taken beyond what was in use before"),
)
BY_KEY: Mapping[str, Figure] = {figure.key: figure for figure in FIGURES}
ACCURACY = tuple(figure.key for figure in FIGURES[:7])
"""Figures against a truth."""


class Spread(NamedTuple):
    """A figure over identities; NaN where none has it."""

    mean: float
    std: float
    worst: float


def badness(figure: Figure, value: float) -> float:
    """Return how bad a value is: less is better."""
    if figure.sense == "one":
        return abs(value - 1)
    return -value if figure.sense == "high" else value


def spread_of(figure: Figure, values: Sequence[float | None]) -> Spread:
    """Return mean, standard deviation and the worst of a figure over identities."""
    known = [float(v) for v in values if v is not None and np.isfinite(v)]
    if not known:
        return Spread(*[float("nan")] * 3)
    return Spread(float(np.mean(known)), float(np.std(known)), max(known, key=lambda v: badness(figure, v)))
