"""Where a surface lets one look inside: through its open rims.

A mask has nothing behind its eyes and its mouth, and still an open eye must look dark
and not like the wall behind.  Between two horns, or through a handle, one does see that
wall.  What tells them apart is what would close the surface: stretch a lid over every
rim, and whoever looks into the head, by whatever opening, looks at the inside of a lid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from mien.core.arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class Openings:
    """The rims of a surface.

    Attributes:
        edges: `(E, 2)` edges that only one triangle has.
        rim: `(E,)` the number of the rim each one belongs to.
    """

    edges: Ints
    rim: Ints

    @classmethod
    def of(cls, triangles: Ints, same: Ints) -> Openings:
        """Find the rims of a surface.

        Args:
            triangles: `(T, 3)` vertex indices.
            same: `(N,)` the vertex that stands for each one, so that seams are closed.
        """
        joined = same[triangles]
        edges = np.sort(np.concatenate([joined[:, [0, 1]], joined[:, [1, 2]], joined[:, [2, 0]]]), axis=1)
        once, uses = np.unique(edges, axis=0, return_counts=True)
        once = once[(uses == 1) & (once[:, 0] != once[:, 1])]
        links = coo_matrix((np.ones(len(once), np.int8), (once[:, 0], once[:, 1])), (len(same), len(same)))
        rim = connected_components(links, directed=False)[1][once[:, 0]]
        return cls(once, np.unique(rim, return_inverse=True)[1].astype(np.int64))

    def lids(self, vertices: Floats) -> tuple[Floats, Ints]:
        """Return what closes the rims in a pose: fans around the middles of the rims.

        Args:
            vertices: `(N, 3)` positions.

        Returns:
            `(N + R, 3)` positions, the middles behind the vertices, and `(E, 3)` triangles.
        """
        ends = vertices[self.edges].mean(axis=1)
        count = np.bincount(self.rim)
        middle = np.stack([np.bincount(self.rim, ends[:, axis]) / np.maximum(count, 1) for axis in range(3)], axis=1)
        corners = np.column_stack([self.edges, len(vertices) + self.rim])
        return np.concatenate([vertices, middle.reshape(-1, 3)]), corners
