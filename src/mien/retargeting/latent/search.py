"""The compiled inside of the source mapping (eq. 9 to 17): a few latent numbers searched per frame.

For a fixed latent point the best observation is known in closed form, dimension by
dimension, so only the latent point is searched, by BFGS with the exact gradient.  All
functions stay in one file because numba's cache notices a change only in the file of the
function called from outside.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats

ITERATIONS = 100
FLAT = 1e-5
"""A frame is found when no entry of the gradient exceeds this share of the energy's size."""
WORTH = 1e-8
"""Nor is a step taken that promises less than this share: rounding would hide it."""
REACH = 0.5
"""The longest step, in widths of the kernel: beyond, a curvature learned here says nothing."""
SMALLEST = 1e-9
"""The predictive variance is at least the kernel's noise; rounding must not make it less than this."""


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def respond(z: Floats, centres: Floats, height: float, steepness: float, k: Floats) -> None:
    """Fill `k` with the kernel between a latent point `(q,)` and the centres `(n, q)`."""
    for i in range(len(centres)):
        distance = 0.0
        for j in range(len(z)):
            difference = z[j] - centres[i, j]
            distance += difference * difference
        k[i] = height * np.exp(-0.5 * steepness * distance)


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def energy(
    z: Floats,
    centres: Floats,
    kernel: Floats,
    coefficients: Floats,
    reduction: Floats,
    wanted: Floats,
    weight: Floats,
    rest: Floats,
    gradient: Floats,
    work: Floats,
) -> float:
    """Return the energy of a latent point with the observation eliminated, and fill its gradient.

    Args:
        z: `(q,)`.
        centres: `(n, q)`.
        kernel: θ1, θ2, the noise variance, and the number of dimensions.
        coefficients: `(n, r)`, so that the mean is `k @ coefficients`.
        reduction: `(n, n)`, so that the variance is `θ1 + noise − k @ reduction @ k`.
        wanted: `(r,)` where observation and previous frame pull the observation to.
        weight: `(r,)` how strongly, as a precision.
        rest: squared distance to `wanted` that no latent point can explain, and its weight.
        gradient: `(q,)` out.
        work: `(3, max(n, r))` scratch.
    """
    n, r, q = len(centres), len(wanted), len(z)
    k, by, mean = work[0, :n], work[1, :n], work[2, :r]
    respond(z, centres, kernel[0], kernel[1], k)
    variance = kernel[0] + kernel[2]
    mean[:] = 0.0
    for i in range(n):
        ki = k[i]
        for d in range(r):
            mean[d] += ki * coefficients[i, d]
        total = 0.0
        for j in range(n):
            total += reduction[i, j] * k[j]
        by[i] = total
        variance -= total * ki
    variance = max(variance, SMALLEST)
    stiffness = rest[1] / (rest[1] * variance + 1)
    value = 0.5 * stiffness * rest[0] + 0.5 * kernel[3] * np.log(variance)
    by_variance = 0.5 * kernel[3] / variance - 0.5 * stiffness * stiffness * rest[0]
    for d in range(r):
        apart = wanted[d] - mean[d]
        stiffness = weight[d] / (weight[d] * variance + 1)
        value += 0.5 * stiffness * apart * apart
        by_variance -= 0.5 * (stiffness * apart) ** 2
        mean[d] = -stiffness * apart
    gradient[:] = z
    for i in range(n):
        total = 0.0
        for d in range(r):
            total += coefficients[i, d] * mean[d]
        pull = (total - 2 * by_variance * by[i]) * k[i] * kernel[1]
        for j in range(q):
            gradient[j] -= pull * (z[j] - centres[i, j])
    for j in range(q):
        value += 0.5 * z[j] * z[j]
    return float(value)


@njit(cache=True, nogil=True)
def descend(
    z: Floats,
    inverse: Floats,
    centres: Floats,
    kernel: Floats,
    coefficients: Floats,
    reduction: Floats,
    wanted: Floats,
    weight: Floats,
    rest: Floats,
) -> tuple[float, float, int]:
    """Move a latent point to a minimum of `energy` in place.

    Args:
        z: `(q,)` the point, moved.
        inverse: `(q, q)` the inverse Hessian to begin with, improved; zero if none is known.
        centres: this and the others as for `energy`.
        kernel: as above.
        coefficients: as above.
        reduction: as above.
        wanted: as above.
        weight: as above.
        rest: as above.

    Returns:
        The energy, the largest derivative left, and how often the energy was computed.
    """
    q = len(z)
    work = np.empty((3, max(len(centres), len(wanted))))
    g, g_new, direction, trial = np.empty(q), np.empty(q), np.empty(q), np.empty(q)
    value = energy(z, centres, kernel, coefficients, reduction, wanted, weight, rest, g, work)
    evaluations, scaled = 1, inverse[0, 0] > 0
    for _ in range(ITERATIONS):
        size = max(1.0, abs(value))
        slope = downhill(inverse, g, direction) if scaled else 0.0
        if slope >= 0:
            scaled = False
            direction[:] = -g
            slope = -(g * g).sum()
        if np.abs(g).max() <= FLAT * size or (scaled and -slope <= WORTH * size):
            break
        step = 1.0 if scaled else min(1.0, 0.1 / np.sqrt(-slope))
        step = min(step, REACH / np.sqrt(kernel[1] * (direction * direction).sum()))
        accepted = False
        for _ in range(12):
            trial[:] = z + step * direction
            new = energy(trial, centres, kernel, coefficients, reduction, wanted, weight, rest, g_new, work)
            evaluations += 1
            if new <= value + 1e-4 * step * slope:
                accepted = True
                break
            step *= min(0.5, max(0.1, -0.5 * slope * step / (new - value - slope * step)))
        if accepted:
            scaled = learn(inverse, trial - z, g_new - g, scaled)
            z[:], g[:], value = trial, g_new, new
        elif scaled:
            scaled = False
        else:
            break
    if not scaled:
        inverse[:] = 0.0
    return value, np.abs(g).max(), evaluations


@njit(cache=True, nogil=True)
def downhill(inverse: Floats, g: Floats, direction: Floats) -> float:
    """Fill the quasi-Newton direction and return the slope along it."""
    slope = 0.0
    for i in range(len(g)):
        total = 0.0
        for j in range(len(g)):
            total -= inverse[i, j] * g[j]
        direction[i] = total
        slope += total * g[i]
    return slope


@njit(cache=True, nogil=True)
def learn(inverse: Floats, moved: Floats, change: Floats, scaled: bool) -> bool:
    """Update an inverse Hessian (BFGS) in place; return whether it now has a scale."""
    curvature = (moved * change).sum()
    if curvature <= 1e-12 * np.sqrt((moved * moved).sum() * (change * change).sum()):
        return scaled
    q = len(moved)
    if not scaled:
        inverse[:] = np.eye(q) * (curvature / (change * change).sum())
    along = np.zeros(q)
    for i in range(q):
        for j in range(q):
            along[i] += inverse[i, j] * change[j]
    stretch = 1 + (change * along).sum() / curvature
    for i in range(q):
        for j in range(q):
            inverse[i, j] += (stretch * moved[i] * moved[j] - along[i] * moved[j] - moved[i] * along[j]) / curvature
    return True


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def find(
    z: Floats,
    other: Floats,
    bend: Floats,
    centres: Floats,
    kernel: Floats,
    coefficients: Floats,
    turn: Floats,
    turned: Floats,
    reduction: Floats,
    wanted: Floats,
    weight: Floats,
    meant: Floats,
) -> float:
    """Find the latent point of an observation and what was probably meant by it.

    If all dimensions weigh the same, only the `r` directions are looked at in which the mean
    can move; the rest is one number.

    Args:
        z: `(q,)` where to begin; out, the latent point.
        other: `(q,)` another place, taken if it is better.
        bend: `(q, q)` the inverse Hessian at `z`, as for `descend`.
        centres: as for `energy`, and so are those not named here.
        kernel: as above.
        coefficients: `(n, d)`.
        turn: `(d, r)` orthonormal directions that hold all coefficients.
        turned: `(n, r)` the coefficients in them.
        reduction: as above.
        wanted: `(d,)`.
        weight: `(d,)`.
        meant: `(d,)` out, the best observation for the point found (eq. 12 solved for `x`).

    Returns:
        The energy.
    """
    d, n = len(wanted), len(centres)
    even = True
    for i in range(d):
        even = even and weight[i] == weight[0]
    rest = np.zeros(2)
    if even:
        within = np.zeros(turn.shape[1])
        for i in range(d):
            rest[0] += wanted[i] * wanted[i]
            for j in range(len(within)):
                within[j] += wanted[i] * turn[i, j]
        rest[0] = max(rest[0] - (within * within).sum(), 0.0)
        rest[1] = weight[0]
        problem = (centres, kernel, turned, reduction, within, np.full(len(within), weight[0]), rest)
    else:
        problem = (centres, kernel, coefficients, reduction, wanted, weight, rest)
    work = np.empty((3, max(n, d)))
    g = np.empty(len(z))
    if energy(other, *problem, g, work) < energy(z, *problem, g, work):
        z[:] = other
        bend[:] = 0.0
    lowest = descend(z, bend, *problem)[0]
    k = work[0, :n]
    respond(z, centres, kernel[0], kernel[1], k)
    meant[:] = 0.0
    variance = kernel[0] + kernel[2]
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += reduction[i, j] * k[j]
        variance -= total * k[i]
        for j in range(d):
            meant[j] += k[i] * coefficients[i, j]
    variance = max(variance, SMALLEST)
    for j in range(d):
        meant[j] += weight[j] * variance / (weight[j] * variance + 1) * (wanted[j] - meant[j])
    return lowest


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def nearest_row(rows: Floats, observed: Floats, seen: Floats) -> int:
    """Return the row `(n, d)` closest to an observation `(d,)` over what is seen (1, else 0)."""
    best, where = np.inf, 0
    for i in range(len(rows)):
        distance = 0.0
        for j in range(len(observed)):
            difference = rows[i, j] - observed[j]
            distance += seen[j] * difference * difference
        if distance < best:
            best, where = distance, i
    return where
