"""Cotangent Laplacians: of a mesh, and of a handful of markers."""

from __future__ import annotations

import igl
import numpy as np
from scipy import sparse
from scipy.spatial import Delaunay

from mien.core.arrays import Floats, Ints

DEGENERATE_DEGREES = 0.1
"""Triangles with a smaller angle have cotangents that drown all others."""
SLIVER_DEGREES = 3.0
"""Triangles with a smaller angle say more about the hull of the markers than about the face."""


def cotangent_laplacian(vertices: Floats, triangles: Ints) -> sparse.csr_matrix:
    """Return the cotangent matrix `C` (Pinkall & Polthier 1993).

    `C u` is the surface Laplacian of `u` integrated over the area around each vertex, so
    it has the unit of `u` and small triangles weigh little.  Degenerate triangles are
    left out; a vertex without triangles has a zero row.

    Args:
        vertices: `(N, 3)`.
        triangles: `(T, 3)`.

    Returns:
        `(N, N)` sparse, symmetric, negative semi-definite.
    """
    kept = triangles[_smallest_angle(vertices, triangles) > DEGENERATE_DEGREES]
    n = len(vertices)
    if len(kept) == 0:
        return sparse.csr_matrix((n, n))
    weights = sparse.csr_matrix(igl.cotmatrix(np.ascontiguousarray(vertices), np.ascontiguousarray(kept)))
    weights.resize((n, n))
    return weights


def triangulate_markers(points: Floats) -> Ints:
    """Triangulate points scattered over a face (Ribera et al. 2017, §4.4).

    The points are laid out in the plane by the azimuthal map of the sphere that fits
    them, and triangulated there (Delaunay).  Lips and lids are not holes in that plane,
    so the edges that the paper adds between upper and lower lip and lid are there.

    Args:
        points: `(M, 3)` the neutral face.

    Returns:
        `(T, 3)` indices; slivers along the hull are dropped.
    """
    flat = _unrolled(points)
    try:
        triangles = np.asarray(Delaunay(flat).simplices, dtype=np.int64)
    except Exception:  # Qhull's own error type is private; it means the points are collinear in the plane.
        return np.empty((0, 3), np.int64)
    angles = np.minimum(
        _smallest_angle(np.c_[flat, np.zeros(len(flat))], triangles), _smallest_angle(points, triangles)
    )
    return triangles[angles > SLIVER_DEGREES]


def _unrolled(points: Floats) -> Floats:
    centre = _sphere_centre(points)
    rays = points - centre
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    out = rays.mean(axis=0)
    out /= np.linalg.norm(out)
    angle = np.arccos(np.clip(rays @ out, -1, 1))
    side = np.linalg.svd(out[None])[2][1:]
    across = rays @ side.T
    length = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(across / np.maximum(length, 1e-12) * angle[:, None])


def _sphere_centre(points: Floats) -> Floats:
    system = np.hstack([2 * points, np.ones((len(points), 1))])
    centre = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=None)[0][:3]
    middle = points.mean(axis=0)
    reach = np.linalg.norm(points - middle, axis=1).max()
    offset = centre - middle
    # A nearly flat set of points fits a huge sphere; a nearer centre unrolls it just as well.
    far = np.linalg.norm(offset) / (3 * reach)
    return np.asarray(middle + offset / max(far, 1.0))


def _smallest_angle(vertices: Floats, triangles: Ints) -> Floats:
    smallest = np.full(len(triangles), 180.0)
    for i in range(3):
        at, one, two = (vertices[triangles[:, (i + j) % 3]] for j in range(3))
        u, v = one - at, two - at
        size = np.linalg.norm(np.cross(u, v), axis=1)
        smallest = np.minimum(smallest, np.degrees(np.arctan2(size, (u * v).sum(axis=1))))
    return smallest
