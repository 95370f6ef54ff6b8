"""A method plays a case: what it gives, what the fit says of itself, and how long both took."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mien.core import Clip, Report
from mien.core.arrays import Floats
from mien.evaluate.cases import Case
from mien.evaluate.deformation import transferred_shapes
from mien.evaluate.given import given
from mien.retargeting import make_method
from mien.retargeting.method import Method
from mien.retargeting.prepare import Prepared
from mien.retargeting.settings import SolveSettings
from mien.retargeting.shape_retargeter import ShapeRetargeter, shape_retargeter

FLOOR = "floor"
"""The actor's true shapes, solved like any method's: what no better shapes could improve on."""
DEFORMATION_TRANSFER = "deformation-transfer"
"""The character's shapes moved onto the actor's mesh, which no method sees, solved like any method's."""
REFERENCES = {FLOOR: "the true shapes", DEFORMATION_TRANSFER: "the actor's mesh"}
"""What stands beside the methods, and what each is given."""
LEAST, MOST, ENOUGH_S = 2, 5, 0.3
"""A take is mapped at least and at most so often, until so much time is spent, and the shortest time counts."""

Shapes = Floats | Callable[[Prepared], Floats]


@dataclass(frozen=True, eq=False)
class Played:
    """What came of it.

    Attributes:
        clip: weights of the character for the test take.
        report: the method's own account.
        shapes: `(K, M, 3)` the actor's shapes it was found with [cm]; None if there are none.
        given: what the method got besides the take, in words.
        fit_s: how long the fit took [s].
        play_s: how long the test take took [s].
        busy_s: for how long of it processors were busy [s]: what others do on the machine adds nothing.
    """

    clip: Clip
    report: Report
    shapes: Floats | None
    given: str
    fit_s: float
    play_s: float
    busy_s: float


def play(
    case: Case, method: str | Method | Shapes, settings: Mapping[str, Any] | None = None, truth: str = "range"
) -> Played:
    """Fit a method on a case's training take and map its test.

    Args:
        case: the case.
        method: a method's name, one of `REFERENCES`, a method with its parameters, or the actor's shapes
            `(K, M, 3)` in human centimetres (or a function that makes them from the prepared case).
        settings: parameters of the method and of its solve, by name.
        truth: whose shapes the floor has, `absolute` or `range`.

    Raises:
        InputError: the method cannot play this case, or a parameter is unknown.
    """
    words, test, fit = _ready(case, method, dict(settings or {}), truth)
    fit_s, _, fitted = _timed(fit)
    takes = [_timed(lambda: fitted.retarget(test)) for _ in range(LEAST)]
    while len(takes) < MOST and sum(seconds for seconds, *_ in takes) < ENOUGH_S:
        takes.append(_timed(lambda: fitted.retarget(test)))
    clip, report = takes[0][2]
    play_s, busy_s = (min(take[i] for take in takes) for i in (0, 1))
    shapes = fitted.shapes if isinstance(fitted, ShapeRetargeter) else None
    return Played(clip, report, shapes, words, fit_s, play_s, busy_s)


def _timed(run: Callable[[], Any]) -> tuple[float, float, Any]:
    """Return how long a call takes and for how long it keeps processors busy [s], and what it returns."""
    start, busy = time.perf_counter(), time.process_time()
    result = run()
    return time.perf_counter() - start, time.process_time() - busy, result


def _ready(
    case: Case, method: str | Method | Shapes, settings: dict[str, Any], truth: str
) -> tuple[str, Any, Callable[[], Any]]:
    """Return what is given in words, the test take, and what then fits the method."""
    words = ""
    if isinstance(method, str) and method in REFERENCES:
        words = REFERENCES[method]
        method = case.shapes(truth) if method == FLOOR else transferred_shapes(case)
    elif isinstance(method, str):
        method = make_method(method, settings)
    if isinstance(method, np.ndarray) or callable(method):
        shapes = method(case.prepared) if callable(method) else method
        known = {f.name for f in fields(SolveSettings)}
        solve = SolveSettings(**{key: value for key, value in settings.items() if key in known})
        prepared = case.prepared
        return words, case.test, lambda: shape_retargeter("shapes", case.character, prepared, shapes, solve)
    got = given(case, method)
    return (
        got.what,
        got.test,
        lambda: method.fit(
            case.character,
            got.training,
            got.pairs,
            neutral=got.neutral,
            head_moves=case.head_moves,
            examples=got.examples,
        ),
    )
