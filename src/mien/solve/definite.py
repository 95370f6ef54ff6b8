"""Small positive definite systems, compiled.

Newton steps on faces of simplices solve systems of ten to fifty unknowns by the hundred thousand,
and know only by trying whether they are definite.  LAPACK's cost of a call is as much as such a
system takes, so it is solved here: by elimination, four rows at a time.
"""

from __future__ import annotations

from numba import njit

from mien.core.arrays import Floats

PANEL = 4
"""Rows that are eliminated together: each number of the rows below is loaded and stored once for them."""


@njit(cache=True, nogil=True)
def padded(n: int) -> int:
    """Return the next multiple of `PANEL`: how large the array of a system of `n` unknowns has to be."""
    return -(-n // PANEL) * PANEL


@njit(cache=True, nogil=True)
def solve_definite(upper: Floats, n: int, x: Floats) -> bool:
    """Solve in place with a positive definite matrix; return whether it is.

    Args:
        upper: the upper triangle of the matrix in its first `n` rows and columns, destroyed; the
            array has `padded(n)` rows and columns at least.
        n: unknowns.
        x: `(padded(n),)` at least: the right side in its first `n` entries, then the solution.
    """
    size = padded(n)
    for j in range(n, size):
        upper[:j, j] = 0.0
        upper[j, j] = 1.0
        x[j] = 0.0
    for first in range(0, size, PANEL):
        if not eliminate_panel(upper, first, size, x):
            return False
        eliminate_below(upper, first, size, x)
    for i in range(n - 1, -1, -1):
        x[i] = (x[i] - dot(upper[i, i + 1 : n], x[i + 1 : n])) / upper[i, i]
    return True


@njit(cache=True, nogil=True, fastmath={"contract"})
def eliminate_panel(upper: Floats, first: int, size: int, x: Floats) -> bool:
    """Eliminate the rows of a panel from each other; False if a pivot is not positive."""
    for k in range(first, first + PANEL):
        if not upper[k, k] > 0:
            return False
        inverse = 1 / upper[k, k]
        for j in range(k + 1, first + PANEL):
            ratio = inverse * upper[k, j]
            x[j] -= ratio * x[k]
            for c in range(first, size):
                upper[j, c] -= ratio * upper[k, c]
    return True


@njit(cache=True, nogil=True, fastmath={"contract"})
def eliminate_below(upper: Floats, first: int, size: int, x: Floats) -> None:
    """Eliminate the rows of a panel from those below it, four by four."""
    a, b, c, d = upper[first], upper[first + 1], upper[first + 2], upper[first + 3]
    p, q, r, s = 1 / a[first], 1 / b[first + 1], 1 / c[first + 2], 1 / d[first + 3]
    for j in range(first + PANEL, size, PANEL):
        a0, a1, a2, a3 = p * a[j], p * a[j + 1], p * a[j + 2], p * a[j + 3]
        b0, b1, b2, b3 = q * b[j], q * b[j + 1], q * b[j + 2], q * b[j + 3]
        c0, c1, c2, c3 = r * c[j], r * c[j + 1], r * c[j + 2], r * c[j + 3]
        d0, d1, d2, d3 = s * d[j], s * d[j + 1], s * d[j + 2], s * d[j + 3]
        e, f, g, h = x[first], x[first + 1], x[first + 2], x[first + 3]
        x[j] -= a0 * e + b0 * f + c0 * g + d0 * h
        x[j + 1] -= a1 * e + b1 * f + c1 * g + d1 * h
        x[j + 2] -= a2 * e + b2 * f + c2 * g + d2 * h
        x[j + 3] -= a3 * e + b3 * f + c3 * g + d3 * h
        row0, row1, row2, row3 = upper[j], upper[j + 1], upper[j + 2], upper[j + 3]
        for i in range(j, size):
            e, f, g, h = a[i], b[i], c[i], d[i]
            row0[i] -= a0 * e + b0 * f + c0 * g + d0 * h
            row1[i] -= a1 * e + b1 * f + c1 * g + d1 * h
            row2[i] -= a2 * e + b2 * f + c2 * g + d2 * h
            row3[i] -= a3 * e + b3 * f + c3 * g + d3 * h


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def dot(a: Floats, b: Floats) -> float:
    """Return `aᵀb`, summed in the order that is quickest."""
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total
