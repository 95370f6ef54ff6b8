"""The compiled inside of the Gaussian kernel among one set of points: every pair is looked at once, nothing is kept.

A search for latent points evaluates this thousands of times on a few hundred points, where
arrays of all pairs cost more than the arithmetic.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def fill_kernel(z: Floats, height: float, steepness: float, noise: float, out: Floats) -> None:
    """Fill `(n, n)` with `height exp(−steepness/2 |z_i − z_j|²)`, and noise added on the diagonal."""
    n, q = z.shape
    for i in range(n):
        for j in range(i):
            distance = 0.0
            for d in range(q):
                difference = z[i, d] - z[j, d]
                distance += difference * difference
            value = height * np.exp(-0.5 * steepness * distance)
            out[i, j] = value
            out[j, i] = value
        out[i, i] = height + noise


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def pull(
    z: Floats, kernel: Floats, height: float, steepness: float, by: Floats, by_z: Floats
) -> tuple[float, float, float]:
    """Fill the derivative by the points `(n, q)` of what has the derivative `by` by the kernel matrix.

    Args:
        z: `(n, q)` points.
        kernel: `(n, n)` as `fill_kernel` fills it.
        height: θ1.
        steepness: θ2.
        by: `(n, n)`, of which the lower triangle is read; the matrix is symmetric.
        by_z: `(n, q)` out.

    Returns:
        The derivatives by `log height`, by `log steepness`, and by a constant added to the diagonal.
    """
    n, q = z.shape
    tall, steep, diagonal = 0.0, 0.0, 0.0
    by_z[:] = 0.0
    for i in range(n):
        diagonal += by[i, i]
        for j in range(i):
            share = 2 * by[i, j] * kernel[i, j]
            distance, strength = 0.0, steepness * share
            for d in range(q):
                difference = z[i, d] - z[j, d]
                distance += difference * difference
                by_z[i, d] -= strength * difference
                by_z[j, d] += strength * difference
            tall += share
            steep -= 0.5 * steepness * share * distance
    return tall + height * diagonal, steep, diagonal
