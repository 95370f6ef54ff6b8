"""The compiled inside of the whole-clip solve: coordinate sweeps, and exact steps on the free set of all frames.

The problem is block tridiagonal: frame `f` has a symmetric block `A_f` and is tied to the next by
`−V_f`.  Sweeps find which coordinates are zero or at a bound; block elimination of the
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
def across(link: Floats, rows: Ints, columns: Ints, x: Floats, out: Floats) -> None:
    """Add `V x` to `out` for the rows and columns of `V` that are free."""
    for i in range(len(rows)):
        for j in range(len(columns)):
            out[i] += link[rows[i], columns[j]] * x[j]


@njit(cache=True, nogil=True)
def reduce(own: Floats, columns: Ints, link: Floats, plain: bool, inverse: Floats, rows: Ints) -> None:
    """Subtract `Vᵀ S⁻¹ V` from a frame's block, given the inverse `S⁻¹` of the frame before's.

    Args:
        own: `(n, n)` the block, restricted to its free coordinates `columns`.
        link: `(K, K)` `V`.
        plain: whether `V` is diagonal.
        inverse: `(m, m)` over the free coordinates `rows` of the frame before.
    """
    m, n = len(rows), len(columns)
    if plain:
        i = 0
        place = np.full(n, -1, np.int64)  # of each free coordinate among those of the frame before
        for j in range(n):
            while i < m and rows[i] < columns[j]:
                i += 1
            if i < m and rows[i] == columns[j]:
                place[j] = i
        for j in range(n):
            if place[j] >= 0:
                left, known = link[columns[j], columns[j]], inverse[place[j]]
                for p in range(n):
                    if place[p] >= 0:
                        own[j, p] -= left * known[place[p]] * link[columns[p], columns[p]]
        return
    tie = np.empty((m, n))
    for a in range(m):
        for b in range(n):
            tie[a, b] = link[rows[a], columns[b]]
    own -= np.dot(np.ascontiguousarray(tie.T), np.dot(inverse, tie))


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
) -> None:
    """Write the step to the minimum over all free coordinates.

    Elimination in time: `S_f = A_f − V_{f−1}ᵀ S_{f−1}⁻¹ V_{f−1}`, all of them restricted to the
    free coordinates, forward; then back from the last frame.
    """
    frames = len(x)
    at = np.zeros(frames + 1, np.int64)  # where each frame's inverse begins
    for f in range(frames):
        at[f + 1] = at[f] + count[f] * count[f]
    inverses, plain = np.empty(at[frames]), np.empty(len(links), np.bool_)
    for number in range(len(links)):
        plain[number] = np.count_nonzero(links[number]) == np.count_nonzero(np.diag(links[number]))
    z = np.zeros_like(x)
    for f in range(frames):
        n = count[f]
        if n == 0:
            continue
        mine = free[f, :n]
        own = np.empty((n, n))
        block = blocks[which[f]]
        for i in range(n):
            a = mine[i]
            for j in range(n):
                own[i, j] = block[a, mine[j]]
            own[i, i] *= 1 + RIDGE
            z[f, i] = -g[f, a] - l1[a] * np.sign(x[f, a])
        m = count[f - 1] if f > 0 else 0
        if m > 0:
            others = free[f - 1, :m]
            before = inverses[at[f - 1] : at[f]].reshape(m, m)
            link = links[joined[f - 1]]
            reduce(own, mine, link, plain[joined[f - 1]], before, others)
            across(link, mine, others, np.dot(before, z[f - 1, :m]), z[f])
        inverses[at[f] : at[f + 1]] = np.linalg.inv(own).ravel()
    d[:] = 0.0
    step = np.zeros(x.shape[1])
    for f in range(frames - 1, -1, -1):
        n = count[f]
        if n == 0:
            continue
        later = count[f + 1] if f + 1 < frames else 0
        if later > 0:
            across(links[joined[f]], free[f, :n], free[f + 1, :later], step[:later].copy(), z[f])
        step[:n] = np.dot(inverses[at[f] : at[f + 1]].reshape(n, n), z[f, :n])
        for i in range(n):
            d[f, free[f, i]] = step[i]


@njit(cache=True, nogil=True)
def moved(l1: Floats, lower: Floats, upper: Floats, x: Floats, d: Floats, t: float, out: Floats) -> None:
    """Write `x + t d`, each coordinate stopped at its bound or at the kink."""
    for f in range(len(x)):
        for k in range(len(l1)):
            value = min(max(x[f, k] + t * d[f, k], lower[k]), upper[k])
            if l1[k] > 0 and value * x[f, k] < 0:
                value = 0.0
            out[f, k] = value
