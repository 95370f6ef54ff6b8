"""Where teeth have edges: there the two sides do not share their normals.

Normals shared by all triangles around a vertex make a coarse skin smooth, and its folds
soft.  Teeth are hard, though, and often no more than a thin band folded along the biting
edge: the mean of its two sides' normals is square to both and makes such teeth dark.  So
the vertices along a crease of the teeth are doubled, one for each side.  Which edges are
creases is told at rest, so that nothing flickers, and pictures cost no more than before.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import triangle_normals

Kind = TypeVar("Kind", bound=np.generic)

SMOOTH = float(np.cos(np.radians(60.0)))
"""Triangles whose normals have a smaller cosine meet in a crease."""


@dataclass(frozen=True, eq=False)
class Creases:
    """A surface whose vertices are doubled along its creases.

    Attributes:
        triangles: `(T, 3)` indices into the `N` vertices and the `D` doubles behind them.
        doubled: `(D,)` the vertex that each double repeats.
        same: `(N + D,)` the vertex each one shares its normal with.
    """

    triangles: Ints
    doubled: Ints
    same: Ints

    @classmethod
    def of(cls, vertices: Floats, triangles: Ints, same: Ints, hard: Flags) -> Creases:
        """Double the vertices along the creases of a surface at rest.

        Args:
            vertices: `(N, 3)` positions.
            triangles: `(T, 3)` vertex indices.
            same: `(N,)` the vertex that stands for each one, so that seams are closed.
            hard: `(N,)` where the surface can have creases.
        """
        side = same[triangles]
        creased = hard[triangles].all(axis=1)
        side[creased] = len(same) + _sides(vertices, triangles[creased], same)
        count = 1 + side.max(initial=0)
        keys, place = np.unique(triangles * count + side, return_inverse=True)
        vertex, side = np.divmod(keys, count)
        double = np.diff(vertex, prepend=-1) == 0
        ids = np.where(double, len(same) + np.cumsum(double) - 1, vertex)
        _, first, group = np.unique(side, return_index=True, return_inverse=True)
        shared = np.concatenate([same, len(same) + np.arange(double.sum())])
        shared[ids] = ids[first][group]
        return cls(ids[place].reshape(-1, 3), vertex[double], shared)

    def split(self, values: NDArray[Kind]) -> NDArray[Kind]:
        """Return `(N + D, …)` values for the `(N, …)` of the surface's own vertices."""
        return np.concatenate([values, values[self.doubled]]) if len(self.doubled) else values


def _sides(vertices: Floats, triangles: Ints, same: Ints) -> Ints:
    """Return `(T, 3)` numbers, alike for the corners that meet in a vertex with no crease between them."""
    corners = np.arange(triangles.size).reshape(-1, 3)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    ends = same[triangles].ravel()[edges]
    edges, ends = (np.take_along_axis(a, np.argsort(ends, axis=1), axis=1) for a in (edges, ends))
    order = np.lexsort(ends.T)
    twin = np.flatnonzero((ends[order[1:]] == ends[order[:-1]]).all(axis=1))
    one, other = edges[order[twin]], edges[order[twin + 1]]
    normals = triangle_normals(vertices, triangles)
    smooth = (normals[one[:, 0] // 3] * normals[other[:, 0] // 3]).sum(axis=1) > SMOOTH
    links = (np.ones(2 * smooth.sum(), np.int8), (one[smooth].ravel(), other[smooth].ravel()))
    found = connected_components(coo_matrix(links, (corners.size, corners.size)), directed=False)[1]
    return np.asarray(found.reshape(-1, 3), dtype=np.int64)
