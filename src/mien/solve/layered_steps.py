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

from mien.core.arrays import Floats, Ints
from mien.solve.layered_frame import Frame, Parts, rounding
from mien.solve.layered_terms import coefficient_rows, correlate, gradient, hessian, objective
from mien.solve.simplex_exchange import minimise_exchanging
from mien.solve.simplex_kernels import (
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
SHIFTS = (0.0, 1e-6, 1e-4, 1e-2, 1.0)
"""Added to the curvature, relative to its largest: the first that makes it positive, where the problem is not convex."""
HALVINGS = 8
"""Times that a Newton step is halved before it is given up."""
ASLEEP = 1e-9
"""A layer with less weight than this everywhere is asleep: its coefficients cannot be told from the data."""


@njit(cache=True, nogil=True)
def improve_weights(frame: Frame, z: Floats, parts: Parts) -> None:
    """Set each region's weights to their best values for these coefficients, after `correlate`."""
    problem, smooth = frame.problem, frame.smooth
    products, match, matrix, one = parts.products, parts.match, parts.small, parts.pair
    regions, layers = match.shape
    q, fit = parts.q[:layers], 1.0 - frame.gamma
    one[1] = layers
    for r in range(regions):
        w = z[r * layers : (r + 1) * layers]
        pulled = frame.gamma if r == problem.region else 0.0
        for i in range(layers):
            for j in range(layers):
                matrix[i, j] = 2 * fit * products[r, i, j]
            matrix[i, i] += 2 * (smooth + pulled)
            q[i] = 2 * fit * match[r, i] + (2 * pulled if i == problem.layer else 0.0)
            if smooth > 0:
                q[i] += 2 * smooth * frame.before[r * layers + i]
        if layers <= FACES:
            minimise_faces(matrix, q, w, parts.work)
        else:
            g, free = parts.g[:layers], parts.free[:layers]
            minimise_simplices(matrix, q, one, w, g, free, parts.work, 1e-12, 50 * layers)


@njit(cache=True, nogil=True)
def improve_coefficients(frame: Frame, z: Floats, tolerance: float, parts: Parts) -> None:
    """Set the coefficients to their best values for these weights."""
    problem, c, gamma, smooth = frame.problem, frame.c, frame.gamma, frame.smooth
    starts, target, shares, block = problem.starts, problem.target, parts.shares, parts.block
    regions, size = c.shape
    first, fit = len(z) - size, 1.0 - gamma
    coefficient_rows(frame, z, parts, block)
    q = parts.q[:size]
    for k in range(size):
        q[k] = 2 * smooth * frame.before[first + k] if smooth > 0 else 0.0
    for r in range(regions):
        for k in range(size):
            q[k] += 2 * fit * shares[r, k] * c[r, k]
    if problem.region >= 0:
        begin = starts[problem.layer]
        for k in range(len(target)):
            q[begin + k] += 2 * gamma * target[k]
    x, goal, g, free = z[first:], parts.goal[:size], parts.g[:size], parts.free[:size]
    goal[:] = x
    quadratic_gradient(block, q, x, g)
    if minimise_exchanging(block, g, starts, goal, free, parts.work, 0.1 * tolerance):
        x[:] = goal
    else:
        minimise_simplices(block, q, starts, x, g, free, parts.work, 0.1 * tolerance, 20 * size)


@njit(cache=True, nogil=True)
def aim_over_all(blocks: Ints, z: Floats, tolerance: float, parts: Parts) -> bool:
    """Set the goal to the minimum over all shares of the quadratic that fits here; False if none is found."""
    parts.goal[:] = z
    parts.slope[:] = parts.g
    return minimise_exchanging(parts.matrix, parts.slope, blocks, parts.goal, parts.free, parts.work, tolerance)


@njit(cache=True, nogil=True)
def aim_on_face(blocks: Ints, z: Floats, parts: Parts) -> bool:
    """Set the goal to Newton's step on the positive unknowns, as far as they stay so; False if there is none."""
    goal, free, work = parts.goal, parts.free, parts.work
    for i in range(len(z)):
        free[i] = z[i] > 0
    for shift in SHIFTS:
        if face_step(parts.matrix, parts.g, blocks, z, free, work, shift):
            goal[:] = z
            t, stop = room(z, work[2])
            move(blocks, goal, work[2], t, stop)
            return True
    return False


@njit(cache=True, nogil=True)
def go(frame: Frame, z: Floats, value: float, parts: Parts) -> tuple[bool, float]:
    """Go towards the goal if that is downhill, as far as it is; return whether it is, and the objective."""
    trial, goal = parts.trial, parts.goal
    trial[:] = goal
    t, slack = 1.0, rounding(frame)
    for _ in range(HALVINGS):
        correlate(frame, trial, parts)
        reached = objective(frame, trial, parts)
        if reached <= value + slack:
            z[:] = trial
            return True, reached
        t *= 0.5
        for i in range(len(z)):
            trial[i] = z[i] + t * (goal[i] - z[i])
        close_blocks(frame.problem.blocks, trial)
    correlate(frame, z, parts)
    return False, value


@njit(cache=True, nogil=True)
def newton(frame: Frame, z: Floats, value: float, tolerance: float, parts: Parts) -> float:
    """Step towards the minimum over all unknowns together, downhill only; return the objective."""
    blocks = frame.problem.blocks
    for _ in range(NEWTON):
        gradient(frame, z, parts)
        if kkt(blocks, z, parts.g) <= tolerance:
            return value
        hessian(frame, z, parts)
        moved = False
        if aim_over_all(blocks, z, tolerance, parts):
            moved, value = go(frame, z, value, parts)
        if not moved and aim_on_face(blocks, z, parts):
            moved, value = go(frame, z, value, parts)
        if not moved:
            break
    return value


@njit(cache=True, nogil=True)
def wake(frame: Frame, z: Floats, value: float, parts: Parts) -> float:
    """Try whether a layer that is asleep would help with other coefficients; return the objective.

    A layer without weight feels no pull on its coefficients, and with wrong coefficients it
    earns no weight: a trap that only a trial leaves.  It is given the coefficients that fit
    one region best by themselves, for each region in turn, and kept if the objective falls.
    """
    starts, trial = frame.problem.starts, parts.second
    regions, layers = parts.match.shape
    tried = False
    for j in range(layers):
        most = 0.0
        for r in range(regions):
            most = max(most, z[r * layers + j])
        if most >= ASLEEP or starts[j + 1] - starts[j] < 2:
            continue
        tried = True
        for r in range(regions):
            trial[:] = z
            fit_alone(frame, r, j, trial, parts)
            correlate(frame, trial, parts)
            improve_weights(frame, trial, parts)
            reached = objective(frame, trial, parts)
            if reached < value - 100 * rounding(frame):
                z[:] = trial
                value = reached
    if tried:
        correlate(frame, z, parts)
    return value


@njit(cache=True, nogil=True)
def fit_alone(frame: Frame, region: int, layer: int, z: Floats, parts: Parts) -> None:
    """Set a layer's coefficients to those that fit a region best by themselves."""
    gram, smooth, one = frame.problem.gram, frame.smooth, parts.pair
    a, b = frame.problem.starts[layer], frame.problem.starts[layer + 1]
    n, first, fit = b - a, len(z) - frame.c.shape[1], 1.0 - frame.gamma
    matrix, q = np.empty((n, n)), parts.q[:n]
    for i in range(n):
        for k in range(n):
            matrix[i, k] = 2 * fit * gram[region, a + i, a + k]
        matrix[i, i] += 2 * smooth
        q[i] = 2 * fit * frame.c[region, a + i]
        if smooth > 0:
            q[i] += 2 * smooth * frame.before[first + a + i]
    one[1] = n
    x, g, free = z[first + a : first + b], parts.g[:n], parts.free[:n]
    minimise_simplices(matrix, q, one, x, g, free, parts.work, 1e-12, 50 * n)
