"""The compiled inside of the lasso: coordinate sweeps, and exact steps on the free set.

Coordinate descent finds in a sweep or two which coordinates are zero or at a
bound, but crawls along the valley of two nearly equal shapes.  A Cholesky step on
the remaining (free) coordinates is the opposite: exact in any valley, blind to
which coordinates are free.  They alternate, each lowering the objective, so the
exact optimum is reached after finitely many faces whatever the conditioning.

All functions work in place on `w` and on the gradient of the smooth part,
`g = Q w − q`.  They stay in one file because numba's cache notices a change only in the
file of the function called from outside.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints

COMPILED: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
"""Without checks of divisors, and without entries from C that nobody takes: a tenth less to compile."""

Work = tuple[Floats, Ints, Ints, Floats, Ints]
"""Scratch of `newton`: factor, free set, free set of the factor, direction, and the size of the factor's set."""

REPEATS = 3
"""Sweeps over the active coordinates after each sweep over all: fewer suit strong penalties, more suit weak ones."""

PATIENCE = 4
"""Rounds with one Newton step each, which is faster; later rounds go on to the minimum of a face, which is certain."""

RIDGE = 1e-12
"""Relative ridge on the free block: duplicated shapes stay factorisable, and the next step corrects its effect."""


@njit(**COMPILED)
def residual(l1: Floats, lower: Floats, upper: Floats, w: Floats, g: Floats) -> float:
    """Return the largest distance of 0 from a coordinate's subdifferential."""
    worst = 0.0
    for k in range(len(w)):
        above = g[k] + (-l1[k] if w[k] <= 0 else l1[k])
        below = g[k] + (l1[k] if w[k] >= 0 else -l1[k])
        if w[k] > lower[k]:
            worst = max(worst, above)
        if w[k] < upper[k]:
            worst = max(worst, -below)
    return worst


@njit(**COMPILED)
def coordinate_minimum(curvature: float, b: float, l1: float, lower: float, upper: float) -> float:
    """Return the minimiser of `½ curvature x² − b x + l1 |x|` between the bounds.

    Without curvature it is the bound nearest 0, or the bound that `b` points to when
    `b` outweighs `l1`; if that bound is infinite there is no minimum and 0 is kept.
    """
    excess = b - l1 if b > l1 else (b + l1 if b < -l1 else 0.0)
    x = 0.0
    if curvature > 0:
        x = excess / curvature
    elif excess > 0 and upper < np.inf:
        x = upper
    elif excess < 0 and lower > -np.inf:
        x = lower
    return min(max(x, lower), upper)


@njit(**COMPILED)
def sweep(gram: Floats, l1: Floats, lower: Floats, upper: Floats, w: Floats, g: Floats, active: bool) -> None:
    """Minimise over each coordinate in turn, or over the active (non-zero) ones only."""
    for k in range(len(w)):
        if active and w[k] == 0:
            continue
        curvature = gram[k, k]
        x = coordinate_minimum(curvature, curvature * w[k] - g[k], l1[k], lower[k], upper[k])
        step = x - w[k]
        if step != 0:
            w[k] = x
            row = gram[k]
            for j in range(len(w)):
                g[j] += step * row[j]


@njit(**COMPILED)
def gradient(gram: Floats, q: Floats, w: Floats, g: Floats) -> None:
    """Set `g = Q w − q` afresh, which also clears the rounding of many small updates."""
    for j in range(len(w)):
        g[j] = -q[j]
    for k in range(len(w)):
        if w[k] != 0:
            for j in range(len(w)):
                g[j] += w[k] * gram[k, j]


@njit(**COMPILED)
def free_set(gram: Floats, l1: Floats, lower: Floats, upper: Floats, w: Floats, free: Ints) -> int:
    """List the coordinates where the objective is smooth: inside the bounds and off the kink at 0."""
    n = 0
    for k in range(len(w)):
        smooth = w[k] != 0 or l1[k] == 0
        if smooth and lower[k] < w[k] < upper[k] and gram[k, k] > 0:
            free[n] = k
            n += 1
    return n


@njit(**COMPILED)
def same_set(one: Ints, n: int, other: Ints, m: int) -> bool:
    """Tell whether the first `n` and `m` entries are the same indices."""
    if n != m:
        return False
    for i in range(n):  # noqa: SIM110 (compiled: a loop, not a generator)
        if one[i] != other[i]:
            return False
    return True


@njit(**COMPILED)
def factorise(gram: Floats, free: Ints, n: int, factor: Floats) -> bool:
    """Factor the free block as `Uᵀ D⁻¹ U`, `D` the diagonal of `U`; False if it is not definite."""
    for i in range(n):
        row = gram[free[i]]
        for j in range(n):
            factor[i, j] = row[free[j]]
        factor[i, i] *= 1 + RIDGE
    for i in range(n):
        if not factor[i, i] > 0:
            return False
        for j in range(i + 1, n):
            ratio = factor[i, j] / factor[i, i]
            below, pivot = factor[j, j:n], factor[i, j:n]
            for p in range(n - j):
                below[p] -= ratio * pivot[p]
    return True


@njit(**COMPILED, fastmath={"reassoc"})
def solve_factored(factor: Floats, n: int, x: Floats) -> None:
    """Solve `Uᵀ D⁻¹ U x = x` in place for the first `n` entries."""
    for i in range(n):
        ratio = x[i] / factor[i, i]
        for p in range(i + 1, n):
            x[p] -= ratio * factor[i, p]
    for i in range(n - 1, -1, -1):
        s = 0.0
        for p in range(i + 1, n):
            s += factor[i, p] * x[p]
        x[i] = (x[i] - s) / factor[i, i]


@njit(**COMPILED)
def wall(l1: float, lower: float, upper: float, x: float, direction: float) -> float:
    """Return where a coordinate moving from `x` first meets the kink at 0 or a bound."""
    if direction < 0:
        return max(lower, 0.0) if l1 > 0 and x > 0 else lower
    return min(upper, 0.0) if l1 > 0 and x < 0 else upper


@njit(**COMPILED)
def advance(l1: Floats, lower: Floats, upper: Floats, w: Floats, free: Ints, n: int, d: Floats) -> bool:
    """Move along `d` until a coordinate meets its wall, and put that one exactly there; True if none did."""
    t, stop = 1.0, -1
    for i in range(n):
        k = free[i]
        room = abs(wall(l1[k], lower[k], upper[k], w[k], d[i]) - w[k])
        if room < t * abs(d[i]):
            t, stop = room / abs(d[i]), i
    for i in range(n):
        k = free[i]
        end = wall(l1[k], lower[k], upper[k], w[k], d[i])
        x = w[k] + t * d[i]
        if i == stop or (x > end) == (d[i] > 0):
            x = end if d[i] != 0 else w[k]
        w[k] = x
    return stop < 0


@njit(**COMPILED)
def newton(
    gram: Floats,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    q: Floats,
    w: Floats,
    g: Floats,
    work: Work,
    max_steps: int,
) -> None:
    """Step to the minimum over the free coordinates; one that meets a kink or bound on the way is free no more."""
    factor, free, factored, direction, count = work
    for _ in range(max_steps):
        n = free_set(gram, l1, lower, upper, w, free)
        if not same_set(free, n, factored, count[0]):
            count[0] = 0
            if not factorise(gram, free, n, factor):
                return
            for i in range(n):
                factored[i] = free[i]
            count[0] = n
        for i in range(n):
            k = free[i]
            direction[i] = -g[k] - l1[k] * np.sign(w[k])
        solve_factored(factor, n, direction)
        whole = advance(l1, lower, upper, w, free, n, direction)
        gradient(gram, q, w, g)
        if whole:
            return


@njit(**COMPILED)
def minimise(
    gram: Floats,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    q: Floats,
    w: Floats,
    g: Floats,
    work: Work,
    tolerance: float,
    max_sweeps: int,
) -> tuple[float, int]:
    """Improve `w` to the optimum; return the residual left and the rounds of sweeps made.

    A `w` that is optimal already is returned untouched, bit for bit.
    """
    for k in range(len(w)):
        w[k] = min(max(w[k], lower[k]), upper[k])
    gradient(gram, q, w, g)
    sweeps = 0
    while True:
        if residual(l1, lower, upper, w, g) > tolerance:
            newton(gram, l1, lower, upper, q, w, g, work, 1 if sweeps < PATIENCE else len(w))
        left = residual(l1, lower, upper, w, g)
        if left <= tolerance or sweeps >= max_sweeps:
            return left, sweeps
        for turn in range(1 + REPEATS):
            sweep(gram, l1, lower, upper, w, g, turn > 0)
        sweeps += 1


@njit(**COMPILED)
def objective(l1: Floats, q: Floats, w: Floats, g: Floats) -> float:
    """Return `½ wᵀQw − qᵀw + Σ l1 |w|`, given `g = Q w − q`."""
    total = 0.0
    for k in range(len(w)):
        total += 0.5 * w[k] * (g[k] - q[k]) + l1[k] * abs(w[k])
    return total


@njit(**COMPILED)
def violated(pairs: Ints, w: Floats) -> int:
    """Return the first pair with both members non-zero, or -1."""
    for i in range(len(pairs)):
        if w[pairs[i, 0]] != 0 and w[pairs[i, 1]] != 0:
            return i
    return -1


@njit(**COMPILED)
def copy(values: Floats, out: Floats) -> None:
    """Write values to where there is room for them: a slice would take several times as long to compile."""
    for k in range(len(values)):
        out[k] = values[k]


@njit(**COMPILED)
def assemble(gram: Floats, pull: float, out: Floats) -> None:
    """Write `Q`, plus `pull` on its diagonal."""
    for i in range(len(gram)):
        for j in range(len(gram)):
            out[i, j] = gram[i, j]
        out[i, i] += pull


@njit(**COMPILED)
def minimise_exclusive(
    gram: Floats,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    pairs: Ints,
    q: Floats,
    w: Floats,
    work: Work,
    tolerance: float,
    max_sweeps: int,
) -> tuple[float, int]:
    """Minimise, then force one member of each violated pair to 0: the one that costs less, pair after pair.

    Every restricted problem starts from the `w` given, so that a held pose is held exactly.
    """
    g, start = np.empty_like(w), w.copy()
    left, sweeps = minimise(gram, l1, lower, upper, q, w, g, work, tolerance, max_sweeps)
    pair = violated(pairs, w)
    if pair < 0:
        return left, sweeps
    lower, upper = lower.copy(), upper.copy()
    while pair >= 0:
        best, zeroed = np.inf, -1
        for k in pairs[pair]:
            low, high = lower.copy(), upper.copy()
            low[k] = high[k] = 0.0
            candidate = start.copy()
            candidate_left, made = minimise(gram, l1, low, high, q, candidate, g, work, tolerance, max_sweeps)
            sweeps += made
            value = objective(l1, q, candidate, g)
            if zeroed < 0 or value < best:
                best, zeroed, left = value, k, candidate_left
                copy(candidate, w)
        lower[zeroed] = upper[zeroed] = 0.0
        pair = violated(pairs, w)
    return left, sweeps


@njit(**COMPILED)
def minimise_frames(
    gram: Floats,
    l1: Floats,
    lower: Floats,
    upper: Floats,
    pairs: Ints,
    smoothness: float,
    previous: bool,
    frames: Floats,
    weights: Floats,
    left: Floats,
    sweeps: Ints,
    w: Floats,
    tolerances: Floats,
    max_sweeps: int,
) -> None:
    """Solve frame after frame, each from the one before; `w` holds the frame before the first if `previous`."""
    size = len(l1)
    work = (
        np.empty((size, size)),
        np.empty(size, np.int64),
        np.empty(size, np.int64),
        np.empty(size),
        np.zeros(1, np.int64),
    )
    matrix, q, pull = np.empty((size, size)), np.empty(size), 0.0
    for f in range(len(frames)):
        if f == 0 or (f == 1 and not previous):
            pull = 2 * smoothness if previous or f > 0 else 0.0
            assemble(gram, pull, matrix)
            work[-1][0] = 0
        for k in range(size):
            q[k] = frames[f, k] + pull * w[k]
        left[f], sweeps[f] = minimise_exclusive(matrix, l1, lower, upper, pairs, q, w, work, tolerances[f], max_sweeps)
        copy(w, weights[f])
