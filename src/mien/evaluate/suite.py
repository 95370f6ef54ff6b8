"""Running a method on a case, and what came of it in figures."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from mien.core import Clip, InputError
from mien.core.arrays import Floats
from mien.evaluate.cases import Case
from mien.evaluate.gaps import gap_figures, gaps
from mien.evaluate.metrics import WeightFigures, active_per_frame, jerk_ratio, shape_error, vertex_error, weight_figures
from mien.retargeting import make_method
from mien.retargeting.energy import SolveSettings
from mien.retargeting.method import Method
from mien.retargeting.prepare import Prepared
from mien.retargeting.shape_retargeter import ShapeRetargeter, shape_retargeter

TRUTHS = ("absolute", "range")
FLOOR = "floor"
"""The actor's true shapes, solved like any method's: what no better shapes could improve on."""

Shapes = Floats | Callable[[Prepared], Floats]
Figures = dict[str, Any]


def run_case(case: Case, method: str | Method | Shapes, settings: Mapping[str, Any] | None = None) -> Figures:
    """Fit on a case's training take, retarget its test, and compare with both truths.

    Args:
        case: the case.
        method: a method's name, `floor`, `copy` (which is given the recorded weights), a
            method with its parameters, or the actor's shapes `(K, M, 3)` in human
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
        if truth == TRUTHS[0] or method == FLOOR:
            clip, shapes = _result(case, method, dict(settings or {}), truth)
        figures[truth] = compare(case, clip, truth, shapes)
    figures["active"] = active_per_frame(clip.values)
    figures["seconds"] = time.perf_counter() - start
    return figures


def run_suite(
    cases: Iterable[Case],
    methods: Sequence[str | Method],
    settings: Mapping[str, Any] | None = None,
    progress: Callable[[Figures], None] = lambda figures: None,
) -> list[Figures]:
    """Run every method on every case; a method that cannot play a case has no row."""
    rows = []
    for case in cases:
        for method in methods:
            try:
                rows.append(run_case(case, method, settings))
            except InputError:
                continue
            progress(rows[-1])
    return rows


def compare(case: Case, clip: Clip, truth: str, shapes: Floats | None = None) -> Figures:
    """Return the figures of a result against one truth.

    Args:
        case: the case.
        clip: weights of the character's shapes for the test take.
        truth: `absolute` or `range`.
        shapes: the shapes the result was found with, `(K, M, 3)` in human centimetres.
    """
    right, counted = (case.truth, case.seen) if truth == "absolute" else (case.truth_range, case.shown)
    result, wanted = clip.channels(case.character.blendshapes.names), np.asarray(right.values)
    weights = weight_figures(result, wanted, counted)
    surface = vertex_error(case.character, result, wanted, case.millimetre)
    figures: Figures = {
        "rmse": weights.rmse,
        "correlation": weights.correlation,
        "gain": weights.gain,
        "vertex_mm": surface.mean_mm,
        "vertex_p95_mm": surface.p95_mm,
        "jerk": jerk_ratio(result[:, weights.moving], wanted[:, weights.moving]),
    }
    measured = gaps(case.character, result, case.millimetre)
    meant = gaps(case.character, wanted, case.millimetre)
    if measured is not None and meant is not None:
        figures |= asdict(gap_figures(measured, meant))
    if shapes is not None:
        figures["shapes"] = shape_error(shapes, _true_shapes(case, truth), weights.moving)
    figures["per_shape"] = _per_shape(case.character.blendshapes.names, weights)
    return figures


def _result(case: Case, method: str | Method | Shapes, settings: dict[str, Any], truth: str) -> tuple[Clip, Floats | None]:
    if method == FLOOR:
        method = _true_shapes(case, truth)
    if isinstance(method, str) and method == "copy":
        return make_method(method, settings).fit(case.character, case.recording).retarget(case.recording)[0], None
    if isinstance(method, str):
        method = make_method(method, settings)
    if isinstance(method, np.ndarray) or callable(method):
        shapes = method(case.prepared) if callable(method) else method
        fitted: Any = shape_retargeter("shapes", case.character, case.prepared, shapes, _solve(settings))
    else:
        fitted = method.fit(case.character, case.training, case.pairs, neutral=case.neutral, head_moves=case.head_moves)
    clip, _ = fitted.retarget(case.test)
    return clip, fitted.shapes if isinstance(fitted, ShapeRetargeter) else None


def _true_shapes(case: Case, truth: str) -> Floats:
    shapes = case.true_shapes if truth == "absolute" else case.range_shapes
    return np.asarray(shapes / case.prepared.terms.centimetre)


def _solve(settings: Mapping[str, Any]) -> SolveSettings:
    known = {f.name for f in fields(SolveSettings)}
    return SolveSettings(**{key: value for key, value in settings.items() if key in known})


def _named(method: str | Method | Shapes) -> str:
    if isinstance(method, str):
        return method
    return str(getattr(method, "name", None) or getattr(method, "__name__", "shapes"))


def _per_shape(names: Sequence[str], weights: WeightFigures) -> Figures:
    columns = (weights.per_shape_rmse, weights.per_shape_correlation, weights.per_shape_gain)
    return {
        name: {"rmse": float(r), "correlation": float(c), "gain": float(g)}
        for name, moving, r, c, g in zip(names, weights.moving, *columns, strict=True)
        if moving
    }
