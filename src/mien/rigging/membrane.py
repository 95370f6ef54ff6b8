"""Skin that an expression would turn over, relaxed until it lies right.

On a face of other proportions the same pull may reach over less skin than it is long: the
corner of a wide mouth close under an eye, the inside of thin lips.  Real skin bulges there,
and never turns over.  So where a triangle of the seen skin faces the other way than the
skin around it, and did not at rest, the displacement is evened out along the skin: little
at first, then farther and more, and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import exposed, vertex_normals
from mien.rigging.dense import DenseFit
from mien.rigging.roughness import Smoothing, edges, neighbours, points_of

AROUND = 2
"""Which way the skin faces is asked of so many rings around each triangle."""
ROUNDS = 4
"""So often the displacement is evened out over twice as many edges as before, one ring farther."""


@dataclass(frozen=True, eq=False)
class Membrane:
    """A face's skin as something that does not turn over.

    Attributes:
        rest: `(P, 3)` its points: vertices doubled along a texture seam are one.
        point: `(N,)` the point each vertex of the face is.
        first: `(P,)` a vertex of each point.
        triangles: `(T, 3)` points.
        seen: `(T,)` which triangles can be seen at rest.
        free: `(P,)` which points may be moved.
        near: `(P, P)` how strongly neighbours hold each other.
        rings: `(P, P)` one where points are neighbours, or the same.
        fans: `(P, T)` one where a triangle has a corner.
        away: `(T,)` which face away from the skin around them already at rest.
    """

    rest: Floats
    point: Ints
    first: Ints
    triangles: Ints
    seen: Flags
    free: Flags
    near: sparse.csr_matrix
    rings: sparse.csr_matrix
    fans: sparse.csr_matrix
    away: Flags

    @classmethod
    def of(cls, fit: DenseFit, held: Flags) -> Membrane:
        """Make the membrane of the face that a correspondence leads to.

        Args:
            fit: the correspondence.
            held: `(N,)` vertices of the face that are left alone: lids are rolled up over the eyeball.
        """
        mesh, skin = fit.target, np.flatnonzero(fit.target_skin)
        point, first = points_of(fit)
        own = mesh.triangles[fit.target_skin[mesh.triangles].all(axis=1)]
        normals, seen = vertex_normals(mesh.vertices, mesh.triangles), np.zeros(len(point), np.bool_)
        seen[skin] = exposed(mesh, mesh.vertices[skin], normals[skin])
        seen[held] = False
        rest, triangles, count = mesh.vertices[first], point[own], len(first)
        near = neighbours(rest, *edges(triangles, count))
        fans = (np.ones(triangles.size), (triangles.ravel(), np.repeat(np.arange(len(triangles)), 3)))
        inside: Flags = np.asarray(seen[own].all(axis=1), np.bool_)
        bare = cls(
            rest,
            point,
            first,
            triangles,
            inside,
            np.isin(np.arange(count), point[held], invert=True),
            near,
            sparse.csr_matrix((near > 0).astype(np.float64) + sparse.eye(count)),
            sparse.csr_matrix(fans, shape=(count, len(triangles))),
            np.zeros(len(triangles), np.bool_),
        )
        return cls(**{**vars(bare), "away": bare._facing_away(rest)})

    def turned(self, deltas: Floats) -> Flags:
        """Return which triangles displacements `(N, 3)` of the face's vertices turn over, `(T,)`."""
        return np.asarray(self._facing_away(self.rest + deltas[self.first]) & ~self.away & self.seen)

    def relaxed(self, deltas: Floats) -> tuple[Floats, int, int]:
        """Even displacements out where they turn the skin over.

        Args:
            deltas: `(N, 3)` of the face's vertices.

        Returns:
            Those of the fewest triangles turned over, and how many there were before and are after.
        """
        bad = self.turned(deltas)
        before = fewest = int(bad.sum())
        best, share, total = deltas, np.zeros(len(self.rest)), np.asarray(self.near.sum(axis=1)).ravel()
        for turn in range(ROUNDS):
            if not bad.any():
                break
            share = np.maximum(share, self.free * self._faded(self.triangles[bad], turn + 2))
            moved = np.flatnonzero(share)
            pull = sparse.diags((2.0 ** (turn + 1) * share[moved]) ** 2 / total[moved]) @ self.near[moved]
            trial = Smoothing(share, self.point, self.first, moved, pull)(deltas)
            bad = self.turned(trial)
            if bad.sum() < fewest:
                best, fewest = trial, int(bad.sum())
        return best, before, fewest

    def _faded(self, triangles: Ints, rings: int) -> Floats:
        """Return 1 at the corners of triangles, less with every ring around them, and 0 beyond, `(P,)`."""
        reached = np.zeros(len(self.rest))
        reached[triangles] = 1
        total = reached.copy()
        for _ in range(rings):
            reached = np.asarray(self.rings @ reached > 0, np.float64)
            total += reached
        return total / (rings + 1)

    def _facing_away(self, points: Floats) -> Flags:
        """Return which triangles face away from the skin around them `(T,)`."""
        a, b, c = (points[self.triangles[:, corner]] for corner in range(3))
        normals = np.cross(b - a, c - a)
        around = self.fans @ normals
        for _ in range(AROUND):
            around = self.rings @ around
        return np.asarray((normals * around[self.triangles].sum(axis=1)).sum(axis=1) < 0)
