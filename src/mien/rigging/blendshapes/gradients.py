"""How triangles deform: the affine map of each, its fourth vertex along the normal.

Sumner & Popović 2004, eq. 2-4.  Everything is kept as a difference from the identity, so
a triangle that does not move is exactly zero and stays zero through every later step.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from mien.core.arrays import Floats, Ints

FLAT = 1e-12
"""A triangle with less area than this share of its longest edge squared has no frame of its own."""


def frames(vertices: Floats, triangles: Ints) -> Floats:
    """Return `(T, 3, 3)` with the columns `e1`, `e2` and `e1 × e2 / √|e1 × e2|` (Sumner & Popović 2004, eq. 2)."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    length = np.sqrt(np.linalg.norm(across, axis=1, keepdims=True))
    up = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
    return np.stack([b - a, c - a, up], axis=2)


def upright(vertices: Floats, triangles: Ints) -> np.ndarray:
    """Return `(T,)` whether a triangle has area enough to deform by."""
    edges = frames(vertices, triangles)[:, :, :2]
    longest = (edges**2).sum(axis=1).max(axis=1)
    area = np.linalg.norm(np.cross(edges[:, :, 0], edges[:, :, 1]), axis=1)
    return np.asarray(area > FLAT * np.maximum(longest, np.finfo(float).tiny))


def deformation(rest: Floats, inverse: Floats, deltas: Floats, triangles: Ints) -> Floats:
    """Return `S - I`, `(T, 3, 3)`, of triangles whose vertices move (Sumner & Popović 2004, eq. 4).

    Args:
        rest: `(N, 3)` vertices.
        inverse: `(T, 3, 3)` inverses of `frames(rest, triangles)`.
        deltas: `(N, 3)` displacements.
        triangles: `(T, 3)`.
    """
    change = frames(rest + deltas, triangles) - frames(rest, triangles)
    # the edges' change is taken from the displacements: a difference of sums would cost digits
    a, b, c = (deltas[triangles[:, i]] for i in range(3))
    change[:, :, 0], change[:, :, 1] = b - a, c - a
    return np.asarray(change @ inverse)


def hat_gradients(vertices: Floats, triangles: Ints) -> Floats:
    """Return `(T, 3, 3)`: the gradient, in the triangle's plane, of the hat function of each corner."""
    inverse = np.linalg.inv(frames(vertices, triangles))
    return np.stack([-inverse[:, 0] - inverse[:, 1], inverse[:, 0], inverse[:, 1]], axis=1)


def gradient(hats: Floats, triangles: Ints, count: int) -> sparse.csr_matrix:
    """Return the `(3T, N)` operator from values at vertices to their gradient in each triangle."""
    t = len(triangles)
    rows = (3 * np.arange(t)[:, None, None] + np.arange(3)).repeat(3, axis=1)
    columns = np.repeat(triangles[:, :, None], 3, axis=2)
    return sparse.csr_matrix((hats.ravel(), (rows.ravel(), columns.ravel())), shape=(3 * t, count))
