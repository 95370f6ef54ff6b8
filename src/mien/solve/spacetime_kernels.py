"""The compiled inside of the whole-clip solve: coordinate sweeps, and exact steps on the free set of all frames.

The problem is block tridiagonal: frame `f` has a symmetric block `A_f` and is tied to the next by
`−V_f`.  Sweeps find which coordinates are zero or at a bound; a block Cholesky step on the
remaining (free) ones, over all frames at once, is exact however strongly frames are tied.
Both lower the objective.

All functions stay in one file because numba's cache notices a change only in the file of the
function called from outside.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints

RIDGE = 1e-12
"""Relative ridge on the free blocks: duplicated shapes stay factorisable, and the next step corrects its effect."""


@njit(cache=True, nogil=True)
def add_product(matrix: Floats, x: Floats, sign: float, out: Floats) -> None:
    """Add `sign · matrix x` for a symmetric matrix; zeros of `x` cost nothing."""
    for k in range(len(x)):
        if x[k] != 0:
            factor = sign * x[k]
            row = matrix[k]
            for i in range(len(out)):
                out[i] += factor * row[i]


@njit(cache=True, nogil=True)
def frame_gradient(
    blocks: Floats, which: Ints, links: Floats, joined: Ints, load: Floats, x: Floats, f: int, g: Floats
) -> None:
    """Write the gradient of the smooth part at frame `f`."""
    g[:] = -load[f]
    add_product(blocks[which[f]], x[f], 1.0, g)
    if f > 0:
        add_product(links[joined[f - 1]], x[f - 1], -1.0, g)
    if f + 1 < len(x):
        add_product(links[joined[f]], x[f + 1], -1.0, g)


@njit(cache=True, nogil=True)
def gradients(blocks: Floats, which: Ints, links: Floats, joined: Ints, load: Floats, x: Floats, g: Floats) -> None:
    """Write the gradient of the smooth part at all frames."""
    for f in range(len(x)):
        frame_gradient(blocks, which, links, joined, load, x, f, g[f])


@njit(cache=True, nogil=True)
def objective(load: Floats, l1: Floats, x: Floats, g: Floats) -> float:
    """Return `½ xᵀHx − loadᵀx + Σ l1 |x|`, given `g = H x − load`."""
    total = 0.0
    for f in range(len(x)):
        for k in range(len(l1)):
            total += 0.5 * x[f, k] * (g[f, k] - load[f, k]) + l1[k] * abs(x[f, k])
    return total


@njit(cache=True, nogil=True)
def residual(l1: Floats, lower: Floats, upper: Floats, x: Floats, g: Floats) -> float:
    """Return the largest distance of 0 from a coordinate's subdifferential."""
    worst = 0.0
    for f in range(len(x)):
        for k in range(len(l1)):
            above = g[f, k] + (l1[k] if x[f, k] > 0 else -l1[k])
            below = g[f, k] - (l1[k] if x[f, k] < 0 else -l1[k])
            if x[f, k] > lower[k]:
                worst = max(worst, above)
            if x[f, k] < upper[k]:
                worst = max(worst, -below)
    return worst


@njit(cache=True, nogil=True)
def sweep(
    blocks: Floats,
    which: Ints,
    links: Floats,
    joined: Ints,
    load: Floats,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    x: Floats,
    backward: bool,
) -> None:
    """Minimise over each coordinate in turn, frame after frame."""
    g = np.empty(len(l1))
    for i in range(len(x)):
        f = len(x) - 1 - i if backward else i
        frame_gradient(blocks, which, links, joined, load, x, f, g)
        block, w = blocks[which[f]], x[f]
        for k in range(len(l1)):
            curve = block[k, k]
            if curve <= 0:
                continue
            z = w[k] - g[k] / curve
            z = np.sign(z) * max(abs(z) - l1[k] / curve, 0.0)
            z = min(max(z, lower[k]), upper[k])
            change = z - w[k]
            if change != 0:
                w[k] = z
                row = block[k]
                for p in range(len(g)):
                    g[p] += change * row[p]


@njit(cache=True, nogil=True)
def free_sets(
    blocks: Floats, which: Ints, l1: Floats, lower: Floats, upper: Floats, x: Floats, free: Ints, count: Ints
) -> None:
    """Write for each frame the coordinates that are neither at a bound nor held at the kink."""
    for f in range(len(x)):
        n = 0
        for k in range(len(l1)):
            inside = lower[k] < x[f, k] < upper[k] and blocks[which[f], k, k] > 0
            if inside and (l1[k] == 0 or x[f, k] != 0):
                free[f, n] = k
                n += 1
        count[f] = n


@njit(cache=True, nogil=True)
def factorise(matrix: Floats) -> bool:
    """Replace the upper triangle of a symmetric matrix by `U`, `UᵀU` being the matrix; False if it is not definite."""
    n = len(matrix)
    for i in range(n):
        if not matrix[i, i] > 0:
            return False
        pivot = np.sqrt(matrix[i, i])
        row = matrix[i]
        for j in range(i, n):
            row[j] /= pivot
        for r in range(i + 1, n):
            factor, below = row[r], matrix[r]
            for j in range(r, n):
                below[j] -= factor * row[j]
    return True


@njit(cache=True, nogil=True)
def forward(upper_factor: Floats, rows: Floats) -> None:
    """Solve `Uᵀ Y = rows` in place."""
    for i in range(len(rows)):
        for p in range(i):
            factor = upper_factor[p, i]
            for j in range(rows.shape[1]):
                rows[i, j] -= factor * rows[p, j]
        for j in range(rows.shape[1]):
            rows[i, j] /= upper_factor[i, i]


@njit(cache=True, nogil=True)
def newton_direction(
    blocks: Floats,
    which: Ints,
    links: Floats,
    joined: Ints,
    l1: Floats,
    x: Floats,
    g: Floats,
    free: Ints,
    count: Ints,
    d: Floats,
) -> bool:
    """Write the step to the minimum over all free coordinates; False if that has no definite system.

    Block Cholesky in time: `U_fᵀU_f = A_f − Y_fᵀY_f` with `U_{f−1}ᵀ Y_f = −V_{f−1}`, all of them
    restricted to the free coordinates.
    """
    frames = len(x)
    at = np.zeros(frames + 1, np.int64)  # where each frame's factor begins
    tie = np.zeros(frames + 1, np.int64)  # where each frame's tie to the one before begins
    for f in range(frames):
        at[f + 1] = at[f] + count[f] * count[f]
        tie[f + 1] = tie[f] + (count[f - 1] * count[f] if f > 0 else 0)
    factors, ties = np.empty(at[frames]), np.empty(tie[frames])
    z = np.zeros_like(x)
    for f in range(frames):
        n = count[f]
        own = factors[at[f] : at[f + 1]].reshape(n, n)
        block = blocks[which[f]]
        for i in range(n):
            a = free[f, i]
            for j in range(n):
                own[i, j] = block[a, free[f, j]]
            own[i, i] *= 1 + RIDGE
            z[f, i] = -g[f, a] - l1[a] * np.sign(x[f, a])
        m = count[f - 1] if f > 0 else 0
        if m > 0:
            before = factors[at[f - 1] : at[f]].reshape(m, m)
            y = ties[tie[f] : tie[f + 1]].reshape(m, n)
            link = links[joined[f - 1]]
            for i in range(m):
                for j in range(n):
                    y[i, j] = -link[free[f - 1, i], free[f, j]]
            forward(before, y)
            for i in range(m):
                row = y[i]
                for a in range(n):
                    factor, target = row[a], own[a]
                    z[f, a] -= factor * z[f - 1, i]
                    for b in range(a, n):
                        target[b] -= factor * row[b]
        if not factorise(own):
            return False
        for i in range(n):
            for p in range(i):
                z[f, i] -= own[p, i] * z[f, p]
            z[f, i] /= own[i, i]
    for f in range(frames - 1, -1, -1):
        n = count[f]
        own = factors[at[f] : at[f + 1]].reshape(n, n)
        if f + 1 < frames and count[f + 1] > 0 and n > 0:
            y = ties[tie[f + 1] : tie[f + 2]].reshape(n, count[f + 1])
            for i in range(n):
                for j in range(count[f + 1]):
                    z[f, i] -= y[i, j] * z[f + 1, j]
        for i in range(n - 1, -1, -1):
            for p in range(i + 1, n):
                z[f, i] -= own[i, p] * z[f, p]
            z[f, i] /= own[i, i]
    d[:] = 0.0
    for f in range(frames):
        for i in range(count[f]):
            d[f, free[f, i]] = z[f, i]
    return True


@njit(cache=True, nogil=True)
def moved(l1: Floats, lower: Floats, upper: Floats, x: Floats, d: Floats, t: float, out: Floats) -> None:
    """Write `x + t d`, each coordinate stopped at its bound or at the kink."""
    for f in range(len(x)):
        for k in range(len(l1)):
            value = min(max(x[f, k] + t * d[f, k], lower[k]), upper[k])
            if l1[k] > 0 and value * x[f, k] < 0:
                value = 0.0
            out[f, k] = value
