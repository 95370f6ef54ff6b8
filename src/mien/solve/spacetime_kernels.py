"""The compiled inside of the whole-clip solve: coordinate sweeps, and exact steps on the free set of all frames.

The problem is block tridiagonal: frame `f` has a symmetric block `A_f` and is tied to the next by
`−V_f`.  Sweeps find which coordinates are zero or at a bound; block elimination of the
remaining (free) ones, over all frames at once, is exact however strongly frames are tied.
Both lower the objective.

All functions stay in one file because numba's cache notices a change only in the file of the
function called from outside.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints

COMPILED: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
"""Without checks of divisors, and without entries from C that nobody takes: a tenth less to compile."""

RIDGE = 1e-12
"""Relative ridge on the free blocks: duplicated shapes stay factorisable, and the next step corrects its effect."""


@njit(**COMPILED)
def add_product(matrix: Floats, x: Floats, sign: float, out: Floats) -> None:
    """Add `sign · matrix x` for a symmetric matrix; zeros of `x` cost nothing."""
    for k in range(len(x)):
        if x[k] != 0:
            factor = sign * x[k]
            row = matrix[k]
            for i in range(len(out)):
                out[i] += factor * row[i]


@njit(**COMPILED)
def add_tie(link: Floats, plain: bool, x: Floats, sign: float, out: Floats) -> None:
    """Add `sign · V x` for a neighbour's weights; `plain` says that `V` is diagonal."""
    if plain:
        for k in range(len(x)):
            out[k] += sign * link[k, k] * x[k]
    else:
        add_product(link, x, sign, out)


@njit(**COMPILED)
def frame_gradient(
    blocks: Floats, which: Ints, links: Floats, plain: Flags, joined: Ints, load: Floats, x: Floats, f: int, g: Floats
) -> None:
    """Write the gradient of the smooth part at frame `f`."""
    for k in range(len(g)):
        g[k] = -load[f, k]
    add_product(blocks[which[f]], x[f], 1.0, g)
    if f > 0:
        add_tie(links[joined[f - 1]], plain[joined[f - 1]], x[f - 1], -1.0, g)
    if f + 1 < len(x):
        add_tie(links[joined[f]], plain[joined[f]], x[f + 1], -1.0, g)


@njit(**COMPILED)
def gradients(
    blocks: Floats, which: Ints, links: Floats, plain: Flags, joined: Ints, load: Floats, x: Floats, g: Floats
) -> None:
    """Write the gradient of the smooth part at all frames."""
    for f in range(len(x)):
        frame_gradient(blocks, which, links, plain, joined, load, x, f, g[f])


@njit(**COMPILED)
def objective(load: Floats, l1: Floats, x: Floats, g: Floats) -> float:
    """Return `½ xᵀHx − loadᵀx + Σ l1 |x|`, given `g = H x − load`."""
    total = 0.0
    for f in range(len(x)):
        for k in range(len(l1)):
            total += 0.5 * x[f, k] * (g[f, k] - load[f, k]) + l1[k] * abs(x[f, k])
    return total


@njit(**COMPILED)
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


@njit(**COMPILED)
def sweep(
    blocks: Floats,
    which: Ints,
    links: Floats,
    plain: Flags,
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
        frame_gradient(blocks, which, links, plain, joined, load, x, f, g)
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


@njit(**COMPILED)
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


@njit(**COMPILED)
def invert(matrix: Floats, n: int, column: Floats) -> None:
    """Invert the first `n` rows and columns of a positive definite matrix in place, given its lower triangle.

    Symmetric Gauss–Jordan elimination, two rows at a time: at these sizes it takes a third of LAPACK's time.

    Args:
        matrix: `(K, K)`.
        n: how much of it is meant.
        column: `(K,)` scratch.
    """
    for k in range(n):
        for j in range(k):
            column[j] = matrix[k, j]
        for j in range(k, n):
            column[j] = matrix[j, k]
        pivot, i = 1.0 / column[k], n - 1
        while i > 0:
            row, other = matrix[i], matrix[i - 1]
            factor, second = pivot * column[i], pivot * column[i - 1]
            for j in range(i + 1):
                row[j] -= factor * column[j]
                other[j] -= second * column[j]
            i -= 2
        if i == 0:
            matrix[0, 0] -= pivot * column[0] * column[0]
        for j in range(k):
            matrix[k, j] = pivot * column[j]
        for j in range(k + 1, n):
            matrix[j, k] = pivot * column[j]
        matrix[k, k] = -pivot
    for i in range(n):
        for j in range(i + 1):
            matrix[i, j] = -matrix[i, j]
            matrix[j, i] = matrix[i, j]


@njit(**COMPILED)
def reduce(own: Floats, columns: Ints, n: int, link: Floats, plain: bool, inverse: Floats, rows: Ints, m: int) -> None:
    """Subtract `Vᵀ S⁻¹ V` from the lower triangle of a frame's block.

    Args:
        own: the block, restricted to its free coordinates.
        columns, n: these, and how many they are.
        link: `(K, K)` `V`.
        plain: whether `V` is diagonal.
        inverse: `S⁻¹` of the frame before, restricted to its free coordinates.
        rows, m: these, and how many they are.
    """
    if plain:
        i, both = 0, 0
        here, there = np.empty(n, np.int64), np.empty(n, np.int64)  # places of what is free in both frames
        for j in range(n):
            while i < m and rows[i] < columns[j]:
                i += 1
            if i < m and rows[i] == columns[j]:
                here[both], there[both] = j, i
                both += 1
        for a in range(both):
            left, row, known = link[columns[here[a]], columns[here[a]]], own[here[a]], inverse[there[a]]
            for b in range(a + 1):
                row[here[b]] -= left * known[there[b]] * link[columns[here[b]], columns[here[b]]]
        return
    carried = np.zeros((m, n))  # S⁻¹ V
    for a in range(m):
        for c in range(m):
            for j in range(n):
                carried[a, j] += inverse[a, c] * link[rows[c], columns[j]]
    for i in range(n):
        for a in range(m):
            tie = link[rows[a], columns[i]]
            for j in range(i + 1):
                own[i, j] -= tie * carried[a, j]


@njit(**COMPILED)
def product(matrix: Floats, x: Floats, n: int, out: Floats) -> None:
    """Write the product of a symmetric `(n, n)` matrix, row after row in one array, with the first `n` of `x`."""
    for j in range(n):
        out[j] = 0.0
    for i in range(n):
        row = matrix[i * n : i * n + n]
        for j in range(n):
            out[j] += x[i] * row[j]


@njit(**COMPILED)
def newton_direction(
    blocks: Floats,
    which: Ints,
    links: Floats,
    plain: Flags,
    joined: Ints,
    l1: Floats,
    x: Floats,
    g: Floats,
    free: Ints,
    count: Ints,
    d: Floats,
) -> None:
    """Write the step to the minimum over all free coordinates to `d`, which holds zeros.

    Elimination in time: `S_f = A_f − V_{f−1}ᵀ S_{f−1}⁻¹ V_{f−1}`, all of them restricted to the
    free coordinates, forward; then back from the last frame.
    """
    frames, size = x.shape
    at = np.zeros(frames + 1, np.int64)  # where each frame's inverse begins
    for f in range(frames):
        at[f + 1] = at[f] + count[f] * count[f]
    inverses, own, before = np.empty(at[frames]), np.empty((size, size)), np.empty((size, size))
    right, column, step = np.empty(size), np.empty(size), np.empty(size)
    for f in range(frames):
        own, before = before, own
        n, block, kept = count[f], blocks[which[f]], inverses[at[f] : at[f + 1]]
        for i in range(n):
            for j in range(i + 1):
                own[i, j] = block[free[f, i], free[f, j]]
            own[i, i] *= 1 + RIDGE
        for k in range(size):
            right[k] = -g[f, k] - l1[k] * np.sign(x[f, k])
        if f > 0:
            link, tied = links[joined[f - 1]], plain[joined[f - 1]]
            reduce(own, free[f], n, link, tied, before, free[f - 1], count[f - 1])
            add_tie(link, tied, d[f - 1], 1.0, right)
        invert(own, n, column)
        for i in range(n):
            column[i] = right[free[f, i]]
            for j in range(n):
                kept[i * n + j] = own[i, j]
        product(kept, column, n, step)
        for i in range(n):
            d[f, free[f, i]] = step[i]
    for f in range(frames - 2, -1, -1):
        n = count[f]
        for k in range(size):
            right[k] = 0.0
        add_tie(links[joined[f]], plain[joined[f]], d[f + 1], 1.0, right)
        for i in range(n):
            column[i] = right[free[f, i]]
        product(inverses[at[f] : at[f + 1]], column, n, step)
        for i in range(n):
            d[f, free[f, i]] += step[i]


@njit(**COMPILED)
def moved(l1: Floats, lower: Floats, upper: Floats, x: Floats, d: Floats, t: float, out: Floats) -> None:
    """Write `x + t d`, each coordinate stopped at its bound or at the kink."""
    for f in range(len(x)):
        for k in range(len(l1)):
            value = min(max(x[f, k] + t * d[f, k], lower[k]), upper[k])
            if l1[k] > 0 and value * x[f, k] < 0:
                value = 0.0
            out[f, k] = value
