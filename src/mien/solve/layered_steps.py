"""The steps that lower the layered objective, compiled.

Given `α` the weights of each region are a tiny quadratic problem, solved by its faces; given
`W` the coefficients are one convex quadratic problem, solved by active sets.  Newton steps go
on all positive unknowns together.  `wake` leaves the one kind of point
where none of these moves and a better one is near.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.solve.layered_terms import Parts, Pull, Shape, coefficient_matrix, correlate, gradient, hessian, objective
from mien.solve.simplex_kernels import (
    Work,
    face_step,
    minimise_faces,
    minimise_simplices,
    move,
    room,
    unevenness,
)

FACES = 4
"""Up to so many layers the weights of a region are found by trying all faces."""
NEWTON = 4
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
    _, products, match, _, g, _, free, work = parts
    fit, gamma, smooth = pull
    bias = shape[2]
    regions, layers = match.shape
    matrix, q, one = np.empty((layers, layers)), np.empty(layers), np.array([0, layers])
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
            minimise_faces(matrix, q, w, work)
        else:
            minimise_simplices(matrix, q, one, w, g[:layers], free[:layers], work, 1e-12, 50 * layers)


@njit(cache=True, nogil=True)
def improve_coefficients(
    gram: Floats, c: Floats, shape: Shape, pull: Pull, before: Floats, z: Floats, parts: Parts, tolerance: float
) -> None:
    """Set the coefficients to their best values for these weights."""
    _, _, match, _, g, matrix, free, work = parts
    _, layer_starts, bias, target = shape
    fit, gamma, smooth = pull
    regions, layers = match.shape
    size = gram.shape[1]
    first = regions * layers
    block = matrix[first:, first:]
    coefficient_matrix(gram, shape, pull, z, layers, block)
    q = np.zeros(size)
    for j in range(layers):
        for k in range(layer_starts[j], layer_starts[j + 1]):
            for r in range(regions):
                q[k] += 2 * fit * z[r * layers + j] * c[r, k]
            if smooth > 0:
                q[k] += 2 * smooth * before[first + k]
    if bias[0] >= 0:
        begin = layer_starts[bias[1]]
        for k in range(len(target)):
            q[begin + k] += 2 * gamma * target[k]
    minimise_simplices(block, q, layer_starts, z[first:], g[first:], free[first:], work, 0.1 * tolerance, 20 * size)


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
    """Step towards the minimum over the positive unknowns together, downhill only; return the objective."""
    starts = shape[0]
    g, matrix, free, work = parts[4], parts[5], parts[6], parts[7]
    trial = np.empty_like(z)
    for _ in range(NEWTON):
        gradient(c, shape, pull, before, z, parts)
        for i in range(len(z)):
            free[i] = z[i] > 0
        if unevenness(starts, g, z, free) <= tolerance:
            return value
        hessian(gram, shape, pull, z, parts)
        if not bent_step(matrix, g, starts, z, free, work):
            return value
        t, stop = room(z, work[2])
        lower = False
        for _ in range(HALVINGS):
            trial[:] = z
            move(starts, trial, work[2], t, stop)
            correlate(gram, c, shape, trial, parts)
            reached = objective(shape, pull, before, trial, parts)
            if reached <= value + slack:
                lower = True
                break
            t, stop = 0.5 * t, -1
        if not lower:
            correlate(gram, c, shape, z, parts)
            return value
        z[:] = trial
        value = reached
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
    g, free, work = parts[4], parts[6], parts[7]
    regions, layers = parts[2].shape
    first = regions * layers
    one = np.zeros(2, np.int64)
    for j in range(layers):
        most = 0.0
        for r in range(regions):
            most = max(most, z[r * layers + j])
        begin, end = first + layer_starts[j], first + layer_starts[j + 1]
        n = end - begin
        if most >= ASLEEP or n < 2:
            continue
        a, b = layer_starts[j], layer_starts[j + 1]
        one[1] = n
        for r in range(regions):
            trial = z.copy()
            matrix = 2 * fit * gram[r, a:b, a:b] + 2 * smooth * np.eye(n)
            q = 2 * fit * c[r, a:b] + (2 * smooth * before[begin:end] if smooth > 0 else np.zeros(n))
            minimise_simplices(matrix, q, one, trial[begin:end], g[:n], free[:n], work, 1e-12, 50 * n)
            correlate(gram, c, shape, trial, parts)
            improve_weights(shape, pull, before, trial, parts)
            reached = objective(shape, pull, before, trial, parts)
            if reached < value - 100 * slack:
                z[:] = trial
                value = reached
    correlate(gram, c, shape, z, parts)
    return value
