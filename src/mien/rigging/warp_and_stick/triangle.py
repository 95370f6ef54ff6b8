"""One point and one triangle, for compiled loops that ask about a few of many."""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints


@njit(cache=True, nogil=True)
def distance(a: Floats, b: Floats) -> float:
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
def closest_on_triangle(query: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """Return the barycentric weights `(3,)` of a triangle's closest point (Ericson 2005, §5.1.5)."""
    ab, ac, ap, bp, cp = b - a, c - a, query - a, query - b, query - c
    d1, d2, d3, d4, d5, d6 = dot(ab, ap), dot(ac, ap), dot(ab, bp), dot(ac, bp), dot(ab, cp), dot(ac, cp)
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
    return np.array([max(1 - v - w, 0.0), v, w])
