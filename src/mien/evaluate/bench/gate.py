"""What got worse since a baseline: accuracy tightly, time loosely."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any, NamedTuple

from mien.evaluate.bench.document import Document, row_key
from mien.evaluate.bench.figures import FIGURES, Figure, badness

SHARE = 0.01
"""A figure may be worse by this share and its slack: they repeat exactly on one machine, and nearly on another."""
FACTOR = 2.0
"""A method may take so many times as long, relative to the reference in the same run …"""
TRIFLE = 0.25
"""… and a quarter of the reference's time more, which is noise."""


class Regression(NamedTuple):
    """Something that is worse than it was.

    Attributes:
        where: the scene, or `all scenes`.
        method: the entrant.
        figure: what.
        was: in the baseline.
        now: in this run; None if it is missing.
        allowed: the worst that would pass.
    """

    where: str
    method: str
    figure: str
    was: float | None
    now: float | None
    allowed: float | None


class Verdict(NamedTuple):
    """What a gate found: regressions, and how many rows and figures were compared."""

    regressions: tuple[Regression, ...]
    rows: int
    figures: int
    timed: bool


def gate(now: Document, baseline: Document, *, whole: bool = True, factor: float = FACTOR) -> Verdict:
    """Compare a run with a baseline.

    Args:
        now: the run.
        baseline: what it is held against.
        whole: whether a row of the baseline that was not run is a regression.
        factor: how many times as long a method may take, relative to the reference.
    """
    rows = {row_key(row): row for row in now["rows"]}
    found: list[Regression] = []
    compared = figures = 0
    for old in baseline["rows"]:
        new = rows.get(row_key(old))
        if new is None:
            found += [Regression(_where(old), old["method"], "row", None, None, None)] * whole
            continue
        compared += 1
        count, worse = _rows_compared(old, new)
        figures += count
        found += worse
    timed = _times(now["rows"], baseline["rows"], factor)
    return Verdict((*found, *timed[1]), compared, figures, timed[0])


def limit(figure: Figure, was: float) -> float:
    """Return how bad a figure may be, as `badness` tells it, if it was this."""
    assert figure.slack is not None
    bad = badness(figure, was)
    return bad + SHARE * abs(bad) + figure.slack


def _rows_compared(old: Mapping[str, Any], new: Mapping[str, Any]) -> tuple[int, list[Regression]]:
    if "failed" in new and "failed" not in old:
        return 0, [Regression(_where(old), old["method"], f"fails: {new['failed']}", None, None, None)]
    count, found = 0, []
    for truth, suffix in (("figures", ""), ("absolute", " (absolute)")):
        for figure in FIGURES:
            was = old[truth].get(figure.key)
            if was is None or figure.slack is None:
                continue
            is_ = new[truth].get(figure.key, {})
            for part in ("mean", "worst"):
                count += 1
                name = f"{figure.title}{suffix}, {part}"
                before, after, most = was[part], is_.get(part), limit(figure, was[part])
                if after is None or badness(figure, after) > most:
                    found.append(Regression(_where(old), old["method"], name, before, after, _value(figure, most)))
    return count, found


def _times(
    now: Sequence[Mapping[str, Any]], baseline: Sequence[Mapping[str, Any]], factor: float
) -> tuple[bool, list[Regression]]:
    """Compare each method's time per frame over the reference's, the median over scenes that both runs have."""
    both = {row_key(row) for row in now} & {row_key(row) for row in baseline}
    ratios = [_ratios(rows, both) for rows in (baseline, now)]
    methods = [method for method in ratios[0] if method in ratios[1]]
    found = []
    for method in methods:
        was, is_ = (median(side[method]) for side in ratios)
        if is_ > factor * was + TRIFLE:
            found.append(Regression("all scenes", method, "time over the reference's", was, is_, factor * was + TRIFLE))
    return bool(methods), found


def _ratios(rows: Sequence[Mapping[str, Any]], among: set[tuple[Any, ...]]) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for row in rows:
        if row_key(row) in among and row.get("time_ratio") is not None:
            found.setdefault(row["method"], []).append(float(row["time_ratio"]))
    return found


def _value(figure: Figure, bad: float) -> float:
    """Return the value of a figure that is as bad as this; of two, the one above."""
    if figure.sense == "one":
        return 1 + bad
    return -bad if figure.sense == "high" else bad


def _where(row: Mapping[str, Any]) -> str:
    return f"{row['performance']} > {row['character']}, {row['conditions']}"
