"""Differences of displacements along the edges of the triangulated markers: their gradient domain.

Li et al. describe each triangle of a mesh by its two edges and normal.  A few dozen markers have triangles too, but
their normals carry no more than the edges do.  What edges leave open is where the whole face is;
the head is held still, so every marker has one more edge, to a point of the skull that does not move.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from mien.core.arrays import Floats
from mien.geometry.laplacian import triangulate_markers


@dataclass(frozen=True, eq=False)
class Edges:
    """The edges of `M` markers.

    Attributes:
        differences: `(R, M)` sparse `D`: displacements to differences along edges.
    """

    differences: sparse.csr_matrix

    def of(self, displacements: Floats) -> Floats:
        """Return the differences `(…, R, 3)` of displacements `(…, M, 3)`."""
        rows = np.moveaxis(displacements, -2, 0)
        found = self.differences @ rows.reshape(len(rows), -1)
        return np.asarray(np.moveaxis(found.reshape(-1, *rows.shape[1:]), 0, -2))

    def back(self, differences: Floats) -> Floats:
        """Apply `Dᵀ`: `(…, R, 3)` to `(…, M, 3)`."""
        rows = np.moveaxis(differences, -2, 0)
        found = self.differences.T @ rows.reshape(len(rows), -1)
        return np.asarray(np.moveaxis(found.reshape(-1, *rows.shape[1:]), 0, -2))


def marker_edges(neutral: Floats) -> Edges:
    """Return the edges of the triangulated markers, and one from each marker to the skull.

    Args:
        neutral: `(M, 3)` markers at rest [cm].
    """
    triangles, count = triangulate_markers(neutral), len(neutral)
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    pairs = np.unique(np.sort(sides, axis=1), axis=0).reshape(-1, 2)
    rows = np.arange(len(pairs))
    ones = np.ones(len(pairs))
    across = sparse.csr_matrix((np.r_[-ones, ones], (np.r_[rows, rows], pairs.T.ravel())), (len(pairs), count))
    return Edges(sparse.csr_matrix(sparse.vstack([across, sparse.identity(count)])))
