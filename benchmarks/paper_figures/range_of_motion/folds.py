"""Where a posed surface folds over: triangles that face backwards although the skin around them does not."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from mien.core import Mesh
from mien.core.arrays import Flags, Floats

AROUND = 2
"""The rotation of the skin around a triangle is that of its corners' neighbourhoods, spread this many rings."""


def folded(mesh: Mesh, posed: Floats) -> Flags:
    """Return `(T,)` whether each triangle's normal flips against the neutral under the pose's local rotation.

    Args:
        mesh: the neutral.
        posed: `(N, 3)` its vertices in the pose.
    """
    triangles, count = mesh.triangles, len(mesh.vertices)
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges = np.unique(np.sort(ends, axis=1), axis=0)
    before, after = (points[edges[:, 1]] - points[edges[:, 0]] for points in (mesh.vertices, posed))
    turned = np.einsum("ea,eb->eab", after, before).reshape(-1, 9)
    spread = np.zeros((count, 9))
    for side in edges.T:
        np.add.at(spread, side, turned)
    ones = np.ones(len(edges))
    near = sparse.coo_matrix((ones, edges.T), shape=(count, count)).tocsr()
    near = near + near.T + sparse.eye(count)
    for _ in range(AROUND):
        spread = near @ spread
    rotations = _rotations(spread[triangles].sum(axis=1).reshape(-1, 3, 3))
    rest, now = (_normals(points, mesh) for points in (mesh.vertices, posed))
    return np.asarray(np.einsum("ta,tab,tb->t", now, rotations, rest) < 0)


def _rotations(matrices: Floats) -> Floats:
    """Return the closest rotation to each matrix."""
    u, _, v = np.linalg.svd(matrices)
    u[:, :, 2] *= np.sign(np.linalg.det(u @ v))[:, None]
    return np.asarray(u @ v)


def _normals(points: Floats, mesh: Mesh) -> Floats:
    a, b, c = points[mesh.triangles].transpose(1, 0, 2)
    return np.asarray(np.cross(b - a, c - a))
