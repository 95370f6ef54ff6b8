"""The compiled inside of simplex problems: exact steps on the face of positive variables.

Variables come in blocks, each on the unit simplex.  On a face (the variables that are
positive) one variable of each block takes up what the others give, so a Newton step is
a small definite system; the face shrinks where a step meets zero and grows where the
gradient says that a zero variable would help.

`starts` holds where each block begins, and the total number of variables at its end.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.solve.definite import padded, solve_definite

Work = tuple[Floats, Floats, Floats, Ints, Ints, Floats]
"""Scratch: reduced matrix, reduced step, whole step, free variables, the pivot of each, and a row."""

RIDGE = 1e-13
"""Ridge on the reduced matrix, relative to the largest curvature or slope: flat directions lead to a wall."""


@njit(cache=True, nogil=True)
def scratch(size: int) -> Work:
    """Return the scratch of a problem with `size` variables."""
    room_for = padded(size)
    return (
        np.empty((room_for, room_for)),
        np.empty(room_for),
        np.empty(size),
        np.empty(size, np.int64),
        np.empty(size, np.int64),
        np.empty(size),
    )


@njit(cache=True, nogil=True)
def kkt(starts: Ints, x: Floats, g: Floats) -> float:
    """Return by how much the gradient of a positive variable exceeds the least of its block, at most."""
    worst = 0.0
    for b in range(len(starts) - 1):
        low = np.inf
        for i in range(starts[b], starts[b + 1]):
            low = min(low, g[i])
        for i in range(starts[b], starts[b + 1]):
            if x[i] > 0:
                worst = max(worst, g[i] - low)
    return worst


@njit(cache=True, nogil=True)
def largest(starts: Ints, x: Floats, b: int) -> int:
    """Return the largest variable of a block."""
    p = starts[b]
    for i in range(starts[b] + 1, starts[b + 1]):
        if x[i] > x[p]:
            p = i
    return int(p)


@njit(cache=True, nogil=True)
def close_blocks(starts: Ints, x: Floats) -> None:
    """Give the largest variable of each block what the others leave, so that sums are 1 to the last bit or two."""
    for b in range(len(starts) - 1):
        p = largest(starts, x, b)
        rest = 0.0
        for i in range(starts[b], starts[b + 1]):
            if i != p:
                rest += x[i]
        x[p] = 1.0 - rest


@njit(cache=True, nogil=True)
def face_step(matrix: Floats, g: Floats, starts: Ints, x: Floats, free: Flags, work: Work, shift: float) -> bool:
    """Set the whole step to Newton's step over the free variables; False if the curvature there is not positive.

    `shift` is added to the curvature, relative to its largest, to make it positive.
    """
    reduced, step, whole, members, pivots, row = work
    n, top = 0, 0.0
    for b in range(len(starts) - 1):
        p = largest(starts, x, b)
        for i in range(starts[b], starts[b + 1]):
            whole[i] = 0.0
            if free[i]:
                top = max(top, abs(matrix[i, i]), abs(g[i] - g[p]))
                if i != p:
                    members[n], pivots[n] = i, p
                    n += 1
    ridge = (RIDGE + shift) * top if top > 0 else 1.0
    for a in range(n):
        i, p = members[a], pivots[a]
        step[a] = g[p] - g[i]
        for c in range(len(x)):
            row[c] = matrix[i, c] - matrix[p, c]
        for c in range(a, n):
            reduced[a, c] = row[members[c]] - row[pivots[c]]
        reduced[a, a] += ridge
    if not solve_definite(reduced, n, step):
        return False
    for a in range(n):
        whole[members[a]] += step[a]
        whole[pivots[a]] -= step[a]
    return True


@njit(cache=True, nogil=True)
def room(x: Floats, whole: Floats) -> tuple[float, int]:
    """Return how much of the whole step keeps all variables at 0 or above, and which one ends it (-1: none)."""
    t, stop = 1.0, -1
    for i in range(len(x)):
        if whole[i] < 0 and x[i] < -t * whole[i]:
            t, stop = x[i] / -whole[i], i
    return t, stop


@njit(cache=True, nogil=True)
def move(starts: Ints, x: Floats, whole: Floats, t: float, stop: int) -> None:
    """Move by `t` of the step, the one that ends it exactly to 0."""
    for i in range(len(x)):
        x[i] = max(x[i] + t * whole[i], 0.0)
    if stop >= 0:
        x[stop] = 0.0
    close_blocks(starts, x)


@njit(cache=True, nogil=True)
def quadratic_gradient(matrix: Floats, q: Floats, x: Floats, g: Floats) -> None:
    """Set `g = Q x − q`."""
    for j in range(len(x)):
        g[j] = -q[j]
    for i in range(len(x)):
        if x[i] != 0:
            row, value = matrix[i], x[i]
            for j in range(len(x)):
                g[j] += value * row[j]


@njit(cache=True, nogil=True)
def unevenness(starts: Ints, g: Floats, x: Floats, free: Flags) -> float:
    """Return the largest difference of gradient within a block's free variables from its largest one: 0 at a face's minimum."""
    worst = 0.0
    for b in range(len(starts) - 1):
        level = g[largest(starts, x, b)]
        for i in range(starts[b], starts[b + 1]):
            if free[i]:
                worst = max(worst, abs(g[i] - level))
    return worst


@njit(cache=True, nogil=True)
def entering(starts: Ints, x: Floats, g: Floats, free: Flags, tolerance: float) -> int:
    """Return the variable at 0 that would help most, or -1."""
    best, found = -tolerance, -1
    for b in range(len(starts) - 1):
        level = g[largest(starts, x, b)]
        for i in range(starts[b], starts[b + 1]):
            if not free[i] and g[i] - level < best:
                best, found = g[i] - level, i
    return found


@njit(cache=True, nogil=True)
def minimise_simplices(
    matrix: Floats,
    q: Floats,
    starts: Ints,
    x: Floats,
    g: Floats,
    free: Flags,
    work: Work,
    tolerance: float,
    max_steps: int,
) -> int:
    """Improve `x` in place to the minimum of `½ xᵀQx − qᵀx` over the simplices; return the steps made.

    A primal active-set method: each step goes to the minimum of a face or to its border.
    """
    for i in range(len(x)):
        free[i] = x[i] > 0
    quadratic_gradient(matrix, q, x, g)
    left = unevenness(starts, g, x, free)
    at_minimum = left <= tolerance
    for steps in range(max_steps):
        if at_minimum:
            i = entering(starts, x, g, free, tolerance)
            if i < 0:
                return steps
            free[i] = True
        if not face_step(matrix, g, starts, x, free, work, 0.0):
            return steps
        t, stop = room(x, work[2])
        move(starts, x, work[2], t, stop)
        if stop >= 0:
            free[stop] = False
        quadratic_gradient(matrix, q, x, g)
        before, left = left, unevenness(starts, g, x, free)
        at_minimum = left <= tolerance or (stop < 0 and left > 0.5 * before)  # rounding allows no better
    return max_steps


@njit(cache=True, nogil=True)
def minimise_faces(matrix: Floats, q: Floats, x: Floats, work: Work) -> None:
    """Set `x` to the minimum of `½ xᵀQx − qᵀx` over one simplex: the best of the minima of all its faces."""
    reduced, step, trial, members, _, _ = work
    size, best = len(q), np.inf
    for face in range(1, 1 << size):
        n, first = 0, -1
        for i in range(size):
            trial[i] = 0.0
            if (face >> i) & 1:
                if first < 0:
                    first = i
                else:
                    members[n] = i
                    n += 1
        for a in range(n):
            i = members[a]
            step[a] = (matrix[first, first] - q[first]) - (matrix[i, first] - q[i])
            for c in range(a, n):
                j = members[c]
                reduced[a, c] = (matrix[i, j] - matrix[i, first]) - (matrix[first, j] - matrix[first, first])
        if not solve_definite(reduced, n, step):
            continue
        trial[first] = 1.0
        inside = True
        for a in range(n):
            trial[members[a]] = step[a]
            trial[first] -= step[a]
            inside = inside and step[a] >= 0
        if not inside or trial[first] < 0:
            continue
        value = 0.0
        for i in range(size):
            if trial[i] != 0:
                for j in range(size):
                    value += 0.5 * trial[i] * matrix[i, j] * trial[j]
                value -= q[i] * trial[i]
        if value < best:
            best = value
            x[:size] = trial[:size]
