"""The compiled inside of the layered problem: downhill from the frame before, frame after frame.

A round of alternation says which of the many minima it is to be, and Newton steps on all unknowns
together go there.  Alternation alone is monotone but crawls where weights and coefficients trade off;
Newton steps are taken only as far as they lower the objective.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints
from mien.solve.layered_steps import improve_coefficients, improve_weights, newton, wake
from mien.solve.layered_terms import Parts, Pull, Shape, correlate, gradient, objective, parts_for
from mien.solve.simplex_kernels import kkt

ROUNDING = 1e-14
"""Rises of the objective below this share of its parts are rounding."""


@njit(cache=True, nogil=True)
def note(history: Floats, count: Ints, value: float) -> None:
    """Add a value to the history, while there is room."""
    if count[0] < len(history):
        history[count[0]] = value
        count[0] += 1


@njit(cache=True, nogil=True)
def descend(
    gram: Floats,
    c: Floats,
    energy: float,
    shape: Shape,
    pull: Pull,
    before: Floats,
    z: Floats,
    tolerance: float,
    max_rounds: int,
    parts: Parts,
    history: Floats,
    count: Ints,
) -> tuple[float, float, int]:
    """Improve `z` to a point of the joint problem that no first-order move improves.

    Returns:
        The objective (with its constant), the KKT residual, and the rounds made.
    """
    starts, g = shape[0], parts.g
    slack = ROUNDING * max(pull[0] * energy, pull[1], 1e-300)
    correlate(gram, c, shape, z, parts)
    value = objective(shape, pull, before, z, parts)
    note(history, count, value)
    left, rounds, woken = np.inf, 0, False
    while True:
        gradient(c, shape, pull, before, z, parts)
        left = kkt(starts, z, g)
        if left <= tolerance:
            if woken:
                break
            woken = True
            reached = wake(gram, c, shape, pull, before, z, value, slack, parts)
            if reached == value:
                gradient(c, shape, pull, before, z, parts)
                break
            value = reached
            note(history, count, value)
        if rounds == max_rounds:
            break
        rounds += 1
        improve_weights(shape, pull, before, z, parts)
        note(history, count, objective(shape, pull, before, z, parts))
        improve_coefficients(gram, c, shape, pull, before, z, parts, tolerance)
        correlate(gram, c, shape, z, parts)
        value = objective(shape, pull, before, z, parts)
        note(history, count, value)
        value = newton(gram, c, shape, pull, before, z, value, slack, tolerance, parts)
        note(history, count, value)
    return value + pull[0] * energy, left, rounds


@njit(cache=True, nogil=True)
def descend_frames(
    gram: Floats,
    data: Floats,
    energy: Floats,
    gamma: Floats,
    smooth: float,
    shape: Shape,
    z: Floats,
    tolerances: Floats,
    max_rounds: int,
    found: Floats,
    objectives: Floats,
    left: Floats,
    rounds: Ints,
) -> None:
    """Solve frame after frame, each from the one before; `z` holds the frame before the first."""
    layers = len(shape[1]) - 1
    parts = parts_for(gram.shape[0], layers, gram.shape[1])
    history, count = np.empty(0), np.zeros(1, np.int64)
    before = np.empty_like(z)
    for f in range(len(data)):
        before[:] = z
        pull = (1.0 - gamma[f], gamma[f], smooth)
        objectives[f], left[f], rounds[f] = descend(
            gram, data[f], energy[f], shape, pull, before, z, tolerances[f], max_rounds, parts, history, count
        )
        found[f] = z
