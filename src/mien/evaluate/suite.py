"""Running a method on a case, and what came of it in figures."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from mien.core import Clip, InputError
from mien.core.arrays import Floats
from mien.evaluate.cases import Case
from mien.evaluate.metrics import active_per_frame, shape_error
from mien.evaluate.played import FLOOR, REFERENCES, Shapes, play
from mien.evaluate.yardstick import Figures
from mien.retargeting import make_method, parameters
from mien.retargeting.method import Method
from mien.retargeting.settings import SolveSettings
from mien.vocabularies import match

TRUTHS = ("absolute", "range")
COPY = "copy"
AVERAGED = (
    "rmse",
    "correlation",
    "correlation_each",
    "gain",
    "vertex_mm",
    "vertex_p95_mm",
    "lid_mm",
    "lip_mm",
    "jerk",
    "other_side",
    "shapes",
)
"""The figures that a summary averages."""
SAME = 0.005
"""Errors that differ by less than this share are the same."""


def run_case(case: Case, method: str | Method | Shapes, settings: Mapping[str, Any] | None = None) -> Figures:
    """Fit on a case's training take, retarget its test, and compare with both truths.

    Args:
        case: the case.
        method: a method's name, `floor`, `deformation-transfer` (which is given the actor's mesh),
            `copy` (which is given the recorded weights), a method with its parameters, or the actor's shapes `(K, M, 3)` in human
            centimetres (or a function that makes them from the prepared case).
        settings: parameters of the method and of its solve, by name.

    Returns:
        `case`, `method`, `seconds`, `active`, and for each truth (`absolute`, `range`) a
        dictionary of `rmse`, `correlation`, `gain`, `vertex_mm`, `vertex_p95_mm`,
        `lid_mm`, `lip_mm`, `jerk`, … and `shapes` (the error of the actor's shapes).

    Raises:
        InputError: the method cannot play this case, or a parameter is unknown.
    """
    start = time.perf_counter()
    figures: Figures = {"case": case.name, "method": _named(method)}
    for truth in TRUTHS:
        if truth == TRUTHS[0] or (isinstance(method, str) and method == FLOOR):
            found = play(case, method, settings, truth)
        figures[truth] = compare(case, found.clip, truth, found.shapes)
    figures["active"] = active_per_frame(found.clip.values)
    figures["seconds"] = time.perf_counter() - start
    return figures


def run_suite(
    cases: Iterable[Case],
    methods: Sequence[str | Method],
    settings: Mapping[str, Any] | None = None,
    progress: Callable[[Figures], None] = lambda _: None,
) -> list[Figures]:
    """Run every method on every case.

    Args:
        cases: the cases.
        methods: names or methods; `copy` has no row for a case without shared names.
        settings: parameters; each method takes those it has.
        progress: called with each row as it is made.

    Raises:
        InputError: no method has a parameter of that name.
    """
    given = {index: _applicable(method, settings or {}) for index, method in enumerate(methods)}
    for key in settings or {}:
        if not any(key in taken for taken in given.values()):
            raise InputError(f"none of the methods {', '.join(map(_named, methods))} has a parameter {key!r}.")
    rows = []
    for case in cases:
        for index, method in enumerate(methods):
            if method == COPY and not match(case.recording.names, case.character.blendshapes.names).matrix.any():
                continue
            rows.append(run_case(case, method, given[index]))
            progress(rows[-1])
    return rows


def summary(rows: Sequence[Figures], truth: str = "range") -> list[Figures]:
    """Return each method's figures averaged over the cases, and how it stands between `rbf` and the floor.

    Args:
        rows: as `run_suite` returns them.
        truth: `absolute` or `range`.

    Returns:
        One row per method: means of the figures; `closed`, the share of the gap in vertex error
        between `rbf` and the floor that it closes, the median over cases; and `worse`, in how
        many cases its vertex error exceeds that of the better of `rbf` and `direct`.
    """
    errors: dict[str, dict[str, float]] = {}
    for row in rows:
        errors.setdefault(row["method"], {})[row["case"]] = row[truth].get("vertex_mm", np.nan)
    result = []
    for method, by_case in errors.items():
        mine = [row for row in rows if row["method"] == method]
        means = {key: _mean([row[truth].get(key) for row in mine]) for key in AVERAGED}
        result.append({"method": method, "truth": truth, "cases": len(mine), **means, **_standing(by_case, errors)})
    return result


def compare(case: Case, clip: Clip, truth: str, shapes: Floats | None = None) -> Figures:
    """Return the figures of a result against one truth.

    Args:
        case: the case.
        clip: weights of the character's shapes for the test take.
        truth: `absolute` or `range`.
        shapes: the shapes the result was found with, `(K, M, 3)` in human centimetres.
    """
    against = case.yardsticks[truth]
    figures = against.measure(clip.channels(against.names))
    if shapes is not None and shapes.shape == case.true_shapes.shape:
        figures["shapes"] = shape_error(shapes, case.shapes(truth), against.moving)
    return figures


def _standing(mine: Mapping[str, float], errors: Mapping[str, Mapping[str, float]]) -> Figures:
    """Compare a method's vertex errors by case with those of `rbf`, `direct` and the floor."""
    rbf, direct, floor = (errors.get(name, {}) for name in ("rbf", "direct", FLOOR))
    closed = [
        (rbf[c] - e) / (rbf[c] - floor[c]) for c, e in mine.items() if c in rbf and c in floor and rbf[c] > floor[c]
    ]
    worse = [e > min(rbf[c], direct[c]) * (1 + SAME) for c, e in mine.items() if c in rbf and c in direct]
    return {"closed": float(np.median(closed)) if closed else float("nan"), "worse": sum(worse)}


def _mean(values: Sequence[float | None]) -> float:
    known = [v for v in values if v is not None and np.isfinite(v)]
    return float(np.mean(known)) if known else float("nan")


def _applicable(method: str | Method, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return those settings that a method has."""
    if isinstance(method, str) and method in REFERENCES:
        known = {f.name for f in fields(SolveSettings)}
    elif isinstance(method, str):
        made = make_method(method)
        known = {*parameters(made), *(["preset"] if hasattr(made, "presets") else [])}
    else:
        known = set()
    return {key: value for key, value in settings.items() if key in known}


def _named(method: str | Method | Shapes) -> str:
    if isinstance(method, str):
        return method
    return str(getattr(method, "name", None) or getattr(method, "__name__", "shapes"))
