"""The compiled inside of the layered problem: downhill from the frame before, frame after frame.

A round of alternation says which of the many minima it is to be, and Newton steps on all unknowns
together go there.  Alternation alone is monotone but crawls where weights and coefficients trade off;
Newton steps are taken only as far as they lower the objective.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints
from mien.solve.layered_frame import Frame, Parts, Problem, parts_for
from mien.solve.layered_steps import improve_coefficients, improve_weights, newton, wake
from mien.solve.layered_terms import correlate, gradient, objective
from mien.solve.simplex_kernels import kkt


class Frames(NamedTuple):
    """Frames in order, and what is found for them.

    Attributes:
        c: `(F, m, N)` `c_l`.
        energy: `(F,)` `‖x̂‖²`.
        gamma: `(F,)` γ.
        tolerance: `(F,)` the KKT residual to reach.
        z: `(F, n)` the unknowns, filled.
        objective: `(F,)` with its constant, filled.
        left: `(F,)` the KKT residual, filled.
        rounds: `(F,)` rounds made, filled.
    """

    c: Floats
    energy: Floats
    gamma: Floats
    tolerance: Floats
    z: Floats
    objective: Floats
    left: Floats
    rounds: Ints


class History(NamedTuple):
    """The objective along the way, without its constant.

    Attributes:
        values: `(H,)` as many as there is room for.
        length: `(1,)` how many there are.
    """

    values: Floats
    length: Ints


@njit(cache=True, nogil=True)
def note(history: History, value: float) -> None:
    """Add a value to the history, while there is room."""
    length = history.length[0]
    if length < len(history.values):
        history.values[length] = value
        history.length[0] += 1


@njit(cache=True, nogil=True)
def descend(
    frame: Frame, z: Floats, tolerance: float, max_rounds: int, parts: Parts, history: History
) -> tuple[float, float, int]:
    """Improve `z` to a point of the joint problem that no first-order move improves.

    Returns:
        The objective (with its constant), the KKT residual, and the rounds made.
    """
    correlate(frame, z, parts)
    value = objective(frame, z, parts)
    note(history, value)
    left, rounds, woken = np.inf, 0, False
    while True:
        gradient(frame, z, parts)
        left = kkt(frame.problem.blocks, z, parts.g)
        if left <= tolerance:
            if woken:
                break
            woken = True
            reached = wake(frame, z, value, parts)
            if reached == value:
                gradient(frame, z, parts)
                break
            value = reached
            note(history, value)
        if rounds == max_rounds:
            break
        rounds += 1
        improve_weights(frame, z, parts)
        note(history, objective(frame, z, parts))
        improve_coefficients(frame, z, tolerance, parts)
        correlate(frame, z, parts)
        value = objective(frame, z, parts)
        note(history, value)
        value = newton(frame, z, value, tolerance, parts)
        note(history, value)
    return value + (1.0 - frame.gamma) * frame.energy, left, rounds


@njit(cache=True, nogil=True)
def descend_frames(
    shared: tuple[Any, ...], smooth: float, taken: tuple[Any, ...], begin: int, before: Floats, max_rounds: int
) -> None:
    """Solve frames from `begin` on, each from the one before.

    Args:
        shared: a `Problem` as a plain tuple: numba takes a microsecond longer to let a named one in.
        smooth: λ.
        taken: `Frames` as a plain tuple.
        begin: the first frame to solve.
        before: `(n,)` the unknowns of the frame before that.
        max_rounds: rounds after which a frame is given up.
    """
    problem, frames = Problem(*shared), Frames(*taken)
    parts, nothing = parts_for(problem), History(np.empty(0), np.zeros(1, np.int64))
    for f in range(begin, len(frames.c)):
        frame = Frame(problem, frames.c[f], frames.energy[f], frames.gamma[f], smooth, before)
        z = frames.z[f]
        z[:] = before
        frames.objective[f], frames.left[f], frames.rounds[f] = descend(
            frame, z, frames.tolerance[f], max_rounds, parts, nothing
        )
        before = z
