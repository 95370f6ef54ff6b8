"""The compiled inside of the solve with correctives: Levenberg-Marquardt steps, each a lasso of its own.

`w` are the weights of the free shapes and `u` those of all, the driven ones as products of hats.
Between the places where hats bend, `u` is a polynomial; every step stays within one such piece
of each weight, and the next may go on in the neighbouring one, so derivatives are always exact.
A bend can hold a weight though a lower energy lies beyond it: at a minimum each weight looks
into its other pieces, too.

All arrays are filled in place.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints
from mien.solve.coordinate_descent import Work, copy, minimise, residual

Rules = tuple[Ints, Ints, Ints, Floats, Floats, Floats, Ints, Floats]
"""Free shapes; driven shapes; drivers as places among the free ones, -1 for none; begin, peak and end of hats;
and the places where hats of each free shape bend, from `start[d]` to `start[d + 1]`."""

EASE = 0.1
"""The damping shrinks by this after a step that helped."""
TIGHTEN = 10.0
"""And grows by this after one that did not."""
FIRST = 1e-3
"""The damping of the first step tried again, as a share of the curvature."""
STIFFEST = 1e9
"""Damped more than this nothing moves."""
SAME = 1e-9
"""Another piece must lower the energy by this share to be worth leaping to."""
ROUNDING = 1e-14
"""An energy that differs by less, relative to the largest there, is the same."""


@njit(cache=True, nogil=True)
def factor(begin: float, peak: float, end: float, w: float, low: float, high: float) -> tuple[float, float]:
    """Return value and slope of a hat at `w`, on the piece from `low` to `high`."""
    if peak == 1:
        return w, 1.0
    if high <= begin or low >= end:
        return 0.0, 0.0
    if high <= peak:
        return (w - begin) / (peak - begin), 1 / (peak - begin)
    return (end - w) / (end - peak), -1 / (end - peak)


@njit(cache=True, nogil=True)
def expand(rules: Rules, w: Floats, low: Floats, high: Floats, u: Floats, slopes: Floats) -> None:
    """Set all weights `u` `(K,)`, and the slopes `(C, J)` of the driven ones to their drivers."""
    free, driven, drivers, begin, peak, end, _, _ = rules
    for d in range(len(free)):
        u[free[d]] = w[d]
    for c in range(len(driven)):
        product = 1.0
        for j in range(drivers.shape[1]):
            slopes[c, j] = 1.0
        for j in range(drivers.shape[1]):
            d = drivers[c, j]
            if d < 0:
                slopes[c, j] = 0.0
                continue
            value, slope = factor(begin[c, j], peak[c, j], end[c, j], w[d], low[d], high[d])
            product *= value
            for i in range(drivers.shape[1]):
                slopes[c, i] *= slope if i == j else value
        u[driven[c]] = product


@njit(cache=True, nogil=True)
def chain(rules: Rules, slopes: Floats, full: Floats, g: Floats) -> None:
    """Set the gradient `g` `(D,)` in the free weights from that in all weights `(K,)`."""
    free, driven, drivers, _, _, _, _, _ = rules
    for d in range(len(free)):
        g[d] = full[free[d]]
    for c in range(len(driven)):
        for j in range(drivers.shape[1]):
            if drivers[c, j] >= 0:
                g[drivers[c, j]] += full[driven[c]] * slopes[c, j]


@njit(cache=True, nogil=True)
def side(rules: Rules, d: int, w: Floats, low: Floats, high: Floats, full: Floats) -> float:
    """Return the derivative to free weight `d` on a piece of it, the other weights being where they are."""
    free, driven, drivers, begin, peak, end, _, _ = rules
    total = float(full[free[d]])
    for c in range(len(driven)):
        slope, others = 0.0, float(full[driven[c]])
        for j in range(drivers.shape[1]):
            i = drivers[c, j]
            if i < 0:
                continue
            value, rise = factor(begin[c, j], peak[c, j], end[c, j], w[i], low[i], high[i])
            if i == d:
                slope = rise
            else:
                others *= value
        total += slope * others
    return total


@njit(cache=True, nogil=True)
def place(rules: Rules, w: Floats, low: Floats, high: Floats) -> None:
    """Set the piece of each free weight; at a bend, the one below it."""
    start, bends = rules[6], rules[7]
    for d in range(len(w)):
        low[d], high[d] = -np.inf, np.inf
        for i in range(start[d], start[d + 1]):
            if bends[i] < w[d]:
                low[d] = bends[i]
            else:
                high[d] = min(high[d], bends[i])


@njit(cache=True, nogil=True)
def turn(
    rules: Rules,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    w: Floats,
    low: Floats,
    high: Floats,
    full: Floats,
    pull: Floats,
) -> None:
    """Where a weight is at a bend, choose the side on which the energy falls faster.

    `full` is the gradient in all weights, `pull` what smoothness adds to that in the free ones.
    """
    start, bends = rules[6], rules[7]
    for d in range(len(w)):
        if w[d] != high[d]:
            continue
        below, above = low[d], high[d]
        beyond = np.inf
        for i in range(start[d], start[d + 1]):
            if bends[i] > w[d]:
                beyond = bends[i]
                break
        down = side(rules, d, w, low, high, full) + pull[d] - (l1[d] if w[d] <= 0 else -l1[d])
        low[d], high[d] = above, beyond
        up = -(side(rules, d, w, low, high, full) + pull[d] + (l1[d] if w[d] >= 0 else -l1[d]))
        if w[d] <= lower[d]:
            down = -np.inf
        if w[d] >= upper[d]:
            up = -np.inf
        if down > up:
            low[d], high[d] = below, above


@njit(cache=True, nogil=True)
def curvature(rules: Rules, gram: Floats, slopes: Floats, half: Floats, matrix: Floats) -> None:
    """Set the Gauss-Newton matrix `(D, D)`, `Jᵀ Q J`; `half` `(K, D)` is scratch for `Q J`."""
    free, driven, drivers, _, _, _, _, _ = rules
    for r in range(len(gram)):
        row, into = gram[r], half[r]
        for d in range(len(free)):
            into[d] = row[free[d]]
        for c in range(len(driven)):
            for j in range(drivers.shape[1]):
                if slopes[c, j] != 0:
                    into[drivers[c, j]] += row[driven[c]] * slopes[c, j]
    for d in range(len(free)):
        matrix[d] = half[free[d]]
    for c in range(len(driven)):
        for j in range(drivers.shape[1]):
            if slopes[c, j] != 0:
                matrix[drivers[c, j]] += slopes[c, j] * half[driven[c]]


@njit(cache=True, nogil=True)
def energy(
    gram: Floats, l1: Floats, q: Floats, w: Floats, u: Floats, before: Floats, smoothness: float, full: Floats
) -> float:
    """Return the energy at `w` and set the gradient in all weights, `Q u - q`, without the smoothness."""
    total = 0.0
    for k in range(len(u)):
        full[k] = -q[k]
    for k in range(len(u)):
        if u[k] != 0:
            row = gram[k]
            for j in range(len(u)):
                full[j] += u[k] * row[j]
    for k in range(len(u)):
        total += 0.5 * u[k] * (full[k] - q[k])
    for d in range(len(w)):
        total += l1[d] * abs(w[d]) + smoothness * (w[d] - before[d]) ** 2
    return total


@njit(cache=True, nogil=True)
def moved(rules: Rules, d: int, x: float, w: Floats, u: Floats, low: float, high: float, du: Floats) -> None:
    """Set how all weights `(K,)` change if free weight `d` becomes `x`, on a piece of it; only what it drives is set."""
    free, driven, drivers, begin, peak, end, _, _ = rules
    du[free[d]] = x - w[d]
    for c in range(len(driven)):
        drives, product = False, 1.0
        for j in range(drivers.shape[1]):
            i = drivers[c, j]
            if i == d:
                drives = True
                product *= factor(begin[c, j], peak[c, j], end[c, j], x, low, high)[0]
            elif i >= 0 and peak[c, j] == 1:
                product *= w[i]
            elif i >= 0:
                product *= hat(begin[c, j], peak[c, j], end[c, j], w[i])
        if drives:
            du[driven[c]] = product - u[driven[c]]


@njit(cache=True, nogil=True)
def hat(begin: float, peak: float, end: float, w: float) -> float:
    """Return the value of a hat."""
    up, down = (w - begin) / (peak - begin), (end - w) / (end - peak)
    return 0.0 if min(up, down) < 0 else min(up, down)


@njit(cache=True, nogil=True)
def change(gram: Floats, full: Floats, du: Floats) -> float:
    """Return by how much the energy of the fit changes with `u`, for a change of few weights."""
    total = 0.0
    for k in range(len(du)):
        if du[k] != 0:
            total += full[k] * du[k]
            for j in range(len(du)):
                if du[j] != 0:
                    total += 0.5 * du[k] * du[j] * gram[k, j]
    return total


@njit(cache=True, nogil=True)
def leap(
    rules: Rules,
    gram: Floats,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    w: Floats,
    u: Floats,
    full: Floats,
    before: Floats,
    smoothness: float,
    worth: float,
) -> int:
    """Move one weight to another piece if that lowers the energy by more than `worth`; return which, or -1.

    On each of its pieces the energy is a parabola of the weight alone, so the best of all is known.
    """
    start, bends = rules[6], rules[7]
    du = np.zeros(len(u))
    for d in range(len(w)):
        if start[d] == start[d + 1]:
            continue
        best, least = w[d], -worth
        for i in range(start[d], start[d + 1] - 1):
            low, high = bends[i], bends[i + 1]
            a, b = max(low, lower[d]), min(high, upper[d])
            if not a < b or a <= w[d] <= b:
                continue
            at = np.empty(3)
            for p in range(3):
                x = a + 0.5 * p * (b - a)
                du[:] = 0
                moved(rules, d, x, w, u, low, high, du)
                at[p] = change(gram, full, du) + l1[d] * (abs(x) - abs(w[d]))
                at[p] += smoothness * ((x - before[d]) ** 2 - (w[d] - before[d]) ** 2)
            bow, tilt = 2 * (at[0] + at[2] - 2 * at[1]), 4 * at[1] - 3 * at[0] - at[2]
            t = 1.0 if at[2] < at[0] else 0.0
            if bow > 0:
                t = min(max(-tilt / (2 * bow), 0.0), 1.0)
            found = at[0] + t * (tilt + t * bow)
            if found < least:
                best, least = a + t * (b - a), found
        if best != w[d]:
            w[d] = best
            return d
    return -1


@njit(cache=True, nogil=True)
def minimise_driven(
    rules: Rules,
    gram: Floats,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    q: Floats,
    before: Floats,
    smoothness: float,
    w: Floats,
    u: Floats,
    tolerance: float,
    max_steps: int,
) -> tuple[float, int]:
    """Improve the free weights `w` to a minimum; return the residual left and the steps made.

    A `w` that is optimal already is returned untouched, bit for bit.
    """
    size, count = len(w), len(u)
    slopes, half = np.zeros(rules[2].shape), np.empty((count, size))
    matrix, damped = np.empty((size, size)), np.empty((size, size))
    low, high, least, most = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    full, g, scratch, b = np.empty(count), np.empty(size), np.empty(size), np.empty(size)
    tried, u_tried, full_tried = np.empty(size), np.empty(count), np.empty(count)
    work: Work = (
        np.empty((size, size)),
        np.empty(size, np.int64),
        np.empty(size, np.int64),
        np.empty(size),
        np.zeros(1, np.int64),
    )
    for d in range(size):
        w[d] = min(max(w[d], lower[d]), upper[d])
    place(rules, w, low, high)
    expand(rules, w, low, high, u, slopes)
    value = energy(gram, l1, q, w, u, before, smoothness, full)
    damping, steps = 0.0, 0
    while True:
        pull = 2 * smoothness * (w - before)
        turn(rules, l1, lower, upper, w, low, high, full, pull)
        expand(rules, w, low, high, u, slopes)
        chain(rules, slopes, full, g)
        g += pull
        for d in range(size):
            least[d], most[d] = max(lower[d], low[d]), min(upper[d], high[d])
        left = residual(l1, least, most, w, g)
        if left <= tolerance or steps >= max_steps or damping > STIFFEST:
            worth = SAME * max(abs(value), tolerance)
            if steps >= max_steps or leap(rules, gram, l1, lower, upper, w, u, full, before, smoothness, worth) < 0:
                return left, steps
            steps += 1
            place(rules, w, low, high)
            expand(rules, w, low, high, u, slopes)
            value = energy(gram, l1, q, w, u, before, smoothness, full)
            damping = 0.0
            continue
        curvature(rules, gram, slopes, half, matrix)
        while damping <= STIFFEST and steps < max_steps:
            for d in range(size):
                damped[d] = matrix[d]
                damped[d, d] += 2 * smoothness + damping * matrix[d, d]
            for d in range(size):
                b[d] = -g[d]
                for i in range(size):
                    b[d] += damped[d, i] * w[i]
            copy(w, tried)
            work[-1][0] = 0
            minimise(damped, l1, least, most, b, tried, scratch, work, 0.1 * tolerance, 1000)
            steps += 1
            place(rules, tried, low, high)
            expand(rules, tried, low, high, u_tried, slopes)
            energy_tried = energy(gram, l1, q, tried, u_tried, before, smoothness, full_tried)
            if energy_tried <= value + ROUNDING * abs(value):
                break
            damping = max(TIGHTEN * damping, FIRST)
        if energy_tried <= value + ROUNDING * abs(value):
            damping = EASE * damping if damping > FIRST * EASE else 0.0
            w[:], u[:], full[:], value = tried, u_tried, full_tried, energy_tried
        else:
            place(rules, w, low, high)
            damping = 2 * STIFFEST


@njit(cache=True, nogil=True)
def minimise_driven_frames(
    rules: Rules,
    gram: Floats,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    smoothness: float,
    previous: bool,
    frames: Floats,
    weights: Floats,
    left: Floats,
    steps: Ints,
    w: Floats,
    tolerances: Floats,
    max_steps: int,
) -> None:
    """Solve frame after frame, each from the one before; `w` holds the frame before the first if `previous`."""
    for f in range(len(frames)):
        pull = smoothness if previous or f > 0 else 0.0
        left[f], steps[f] = minimise_driven(
            rules, gram, l1, lower, upper, frames[f], w.copy(), pull, w, weights[f], tolerances[f], max_steps
        )
