"""The steps that lower the layered objective, compiled.

Given `α` the weights of each region are a tiny quadratic problem, solved by its faces; given
`W` the coefficients are one convex quadratic problem, solved by exchange or active sets.  Newton
steps go to the minimum, over the shares, of the quadratic that fits the objective best where they
start; where that has none, on the positive unknowns only.  `wake` leaves the one kind of point
where none of these moves and a better one is near.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.solve.layered_terms import Parts, Pull, Shape, coefficient_rows, correlate, gradient, hessian, objective
from mien.solve.simplex_exchange import minimise_exchanging
from mien.solve.simplex_kernels import (
    Work,
    close_blocks,
    face_step,
    kkt,
    minimise_faces,
    minimise_simplices,
    move,
    quadratic_gradient,
    room,
)

FACES = 4
"""Up to so many layers the weights of a region are found by trying all faces."""
NEWTON = 12
"""Newton steps at most after each round of alternation."""
SHIFTS = (1e-6, 1e-4, 1e-2, 1.0)
"""Tried in turn where the joint problem is not convex, relative to the largest curvature."""
HALVINGS = 8
"""Times that a Newton step is halved before it is given up."""
ASLEEP = 1e-9
"""A layer with less weight than this everywhere is asleep: its coefficients cannot be told from the data."""


@njit(cache=True, nogil=True)
def improve_weights(shape: Shape, pull: Pull, before: Floats, z: Floats, parts: Parts) -> None:
    """Set each region's weights to their best values for these coefficients, after `correlate`."""
    products, match, matrix = parts.products, parts.match, parts.small
    fit, gamma, smooth = pull
    bias, one = shape[2], parts.pair
    regions, layers = match.shape
    q = parts.q[:layers]
    one[1] = layers
    for r in range(regions):
        w = z[r * layers : (r + 1) * layers]
        pulled = gamma if r == bias[0] else 0.0
        for i in range(layers):
            for j in range(layers):
                matrix[i, j] = 2 * fit * products[r, i, j]
            matrix[i, i] += 2 * (smooth + pulled)
            q[i] = 2 * fit * match[r, i] + (2 * pulled if i == bias[1] else 0.0)
            if smooth > 0:
                q[i] += 2 * smooth * before[r * layers + i]
        if layers <= FACES:
            minimise_faces(matrix, q, w, parts.work)
        else:
            g, free = parts.g[:layers], parts.free[:layers]
            minimise_simplices(matrix, q, one, w, g, free, parts.work, 1e-12, 50 * layers)


@njit(cache=True, nogil=True)
def improve_coefficients(
    gram: Floats, c: Floats, shape: Shape, pull: Pull, before: Floats, z: Floats, parts: Parts, tolerance: float
) -> None:
    """Set the coefficients to their best values for these weights."""
    _, layer_starts, bias, target = shape
    fit, gamma, smooth = pull
    regions, layers = parts.match.shape
    size = gram.shape[1]
    first = regions * layers
    coefficient_rows(gram, shape, pull, z, 0, parts, parts.block)
    q = parts.q[:size]
    for k in range(size):
        q[k] = 2 * smooth * before[first + k] if smooth > 0 else 0.0
    for r in range(regions):
        for k in range(size):
            q[k] += 2 * fit * parts.shares[r, k] * c[r, k]
    if bias[0] >= 0:
        begin = layer_starts[bias[1]]
        for k in range(len(target)):
            q[begin + k] += 2 * gamma * target[k]
    x, goal, g, free = z[first:], parts.goal[:size], parts.g[:size], parts.free[:size]
    goal[:] = x
    quadratic_gradient(parts.block, q, x, g)
    if minimise_exchanging(parts.block, g, layer_starts, goal, free, parts.work, 0.1 * tolerance):
        x[:] = goal
    else:
        minimise_simplices(parts.block, q, layer_starts, x, g, free, parts.work, 0.1 * tolerance, 20 * size)


@njit(cache=True, nogil=True)
def bent_step(matrix: Floats, g: Floats, starts: Ints, z: Floats, free: Flags, work: Work) -> bool:
    """Take Newton's step where the curvature is positive, else that of the least shift tried that makes it so."""
    if face_step(matrix, g, starts, z, free, work, 0.0):
        return True
    for shift in SHIFTS:  # noqa: SIM110 (compiled: a loop, not a generator)
        if face_step(matrix, g, starts, z, free, work, shift):
            return True
    return False


@njit(cache=True, nogil=True)
def aim_over_all(starts: Ints, z: Floats, tolerance: float, parts: Parts) -> bool:
    """Set the goal to the minimum over all shares of the quadratic that fits here; False if none is found."""
    parts.goal[:] = z
    parts.slope[:] = parts.g
    return minimise_exchanging(parts.matrix, parts.slope, starts, parts.goal, parts.free, parts.work, tolerance)


@njit(cache=True, nogil=True)
def aim_on_face(starts: Ints, z: Floats, parts: Parts) -> bool:
    """Set the goal to Newton's step on the positive unknowns, as far as they stay so; False if there is none."""
    goal, free, work = parts.goal, parts.free, parts.work
    for i in range(len(z)):
        free[i] = z[i] > 0
    if not bent_step(parts.matrix, parts.g, starts, z, free, work):
        return False
    goal[:] = z
    t, stop = room(z, work[2])
    move(starts, goal, work[2], t, stop)
    return True


@njit(cache=True, nogil=True)
def go(
    gram: Floats,
    c: Floats,
    shape: Shape,
    pull: Pull,
    before: Floats,
    z: Floats,
    value: float,
    slack: float,
    parts: Parts,
) -> tuple[bool, float]:
    """Go towards the goal if that is downhill, as far as it is; return whether it is, and the objective."""
    starts, trial, goal = shape[0], parts.trial, parts.goal
    trial[:] = goal
    t = 1.0
    for _ in range(HALVINGS):
        correlate(gram, c, shape, trial, parts)
        reached = objective(shape, pull, before, trial, parts)
        if reached <= value + slack:
            z[:] = trial
            return True, reached
        t *= 0.5
        for i in range(len(z)):
            trial[i] = z[i] + t * (goal[i] - z[i])
        close_blocks(starts, trial)
    correlate(gram, c, shape, z, parts)
    return False, value


@njit(cache=True, nogil=True)
def newton(
    gram: Floats,
    c: Floats,
    shape: Shape,
    pull: Pull,
    before: Floats,
    z: Floats,
    value: float,
    slack: float,
    tolerance: float,
    parts: Parts,
) -> float:
    """Step towards the minimum over all unknowns together, downhill only; return the objective."""
    starts = shape[0]
    for _ in range(NEWTON):
        gradient(c, shape, pull, before, z, parts)
        if kkt(starts, z, parts.g) <= tolerance:
            return value
        hessian(gram, shape, pull, z, parts)
        moved = False
        if aim_over_all(starts, z, tolerance, parts):
            moved, value = go(gram, c, shape, pull, before, z, value, slack, parts)
        if not moved and aim_on_face(starts, z, parts):
            moved, value = go(gram, c, shape, pull, before, z, value, slack, parts)
        if not moved:
            break
    return value


@njit(cache=True, nogil=True)
def wake(
    gram: Floats,
    c: Floats,
    shape: Shape,
    pull: Pull,
    before: Floats,
    z: Floats,
    value: float,
    slack: float,
    parts: Parts,
) -> float:
    """Try whether a layer that is asleep would help with other coefficients; return the objective.

    A layer without weight feels no pull on its coefficients, and with wrong coefficients it
    earns no weight: a trap that only a trial leaves.  It is given the coefficients that fit
    one region best by themselves, for each region in turn, and kept if the objective falls.
    """
    layer_starts = shape[1]
    fit, _, smooth = pull
    g, free, trial, one = parts.g, parts.free, parts.second, parts.pair
    regions, layers = parts.match.shape
    first = regions * layers
    tried = False
    for j in range(layers):
        most = 0.0
        for r in range(regions):
            most = max(most, z[r * layers + j])
        begin, end = first + layer_starts[j], first + layer_starts[j + 1]
        n = end - begin
        if most >= ASLEEP or n < 2:
            continue
        tried = True
        a, b = layer_starts[j], layer_starts[j + 1]
        for r in range(regions):
            one[1] = n
            trial[:] = z
            matrix = 2 * fit * gram[r, a:b, a:b] + 2 * smooth * np.eye(n)
            q = 2 * fit * c[r, a:b] + (2 * smooth * before[begin:end] if smooth > 0 else np.zeros(n))
            minimise_simplices(matrix, q, one, trial[begin:end], g[:n], free[:n], parts.work, 1e-12, 50 * n)
            correlate(gram, c, shape, trial, parts)
            improve_weights(shape, pull, before, trial, parts)
            reached = objective(shape, pull, before, trial, parts)
            if reached < value - 100 * slack:
                z[:] = trial
                value = reached
    if tried:
        correlate(gram, c, shape, z, parts)
    return value
