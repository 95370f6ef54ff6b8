"""One point and one triangle, for compiled loops that ask about a few of many."""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints

Place = tuple[float, float, float]
"""A point in space as numbers: in inner loops, arrays cost more than the work."""


@njit(cache=True, nogil=True)
def distance(a: Place | Floats, b: Place | Floats) -> float:
    """Return the distance between two points."""
    return float(np.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2))


@njit(cache=True, nogil=True)
def dot(a: Floats, b: Floats) -> float:
    """Return the inner product of two vectors in space."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@njit(cache=True, nogil=True)
def point_at(vertices: Floats, corners: Ints, weights: Floats) -> Floats:
    """Return the weighted mean of three vertices."""
    place: Floats = (
        vertices[corners[0]] * weights[0] + vertices[corners[1]] * weights[1] + vertices[corners[2]] * weights[2]
    )
    return place


@njit(cache=True, nogil=True)
def nearest(query: Place | Floats, vertices: Floats, p: int, q: int, r: int) -> tuple[float, float, float, float]:
    """Return the weights of a triangle's closest point, and its squared distance (Ericson 2005, §5.1.5).

    Numbers instead of vectors: the arrays would cost more than the work.
    """
    ax, ay, az = vertices[p, 0], vertices[p, 1], vertices[p, 2]
    abx, aby, abz = vertices[q, 0] - ax, vertices[q, 1] - ay, vertices[q, 2] - az
    acx, acy, acz = vertices[r, 0] - ax, vertices[r, 1] - ay, vertices[r, 2] - az
    apx, apy, apz = query[0] - ax, query[1] - ay, query[2] - az
    d1, d2 = abx * apx + aby * apy + abz * apz, acx * apx + acy * apy + acz * apz
    bb, cc, bc = abx * abx + aby * aby + abz * abz, acx * acx + acy * acy + acz * acz, abx * acx + aby * acy + abz * acz
    d3, d4, d5, d6 = d1 - bb, d2 - bc, d1 - bc, d2 - cc
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    v, w = 0.0, 0.0
    if d1 <= 0 and d2 <= 0:
        pass
    elif d3 >= 0 and d4 <= d3:
        v = 1.0
    elif d6 >= 0 and d5 <= d6:
        w = 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        v = d1 / (d1 - d3) if d1 > d3 else 0.0
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        w = d2 / (d2 - d6) if d2 > d6 else 0.0
    elif va <= 0 and d4 >= d3 and d5 >= d6:
        edge = (d4 - d3) + (d5 - d6)
        w = (d4 - d3) / edge if edge > 0 else 0.0
        v = 1 - w
    elif va + vb + vc > 0:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    offx, offy, offz = apx - v * abx - w * acx, apy - v * aby - w * acy, apz - v * abz - w * acz
    return max(1 - v - w, 0.0), v, w, offx * offx + offy * offy + offz * offz
