"""Where a face's skin touches itself: the lips at rest, the lids in a blink.

Points that touch are close in space and far apart along the skin.  Both are asked of
every pose; who touches at rest is found once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mien.core import Mesh, SurfacePoints
from mien.core.arrays import Flags, Floats, Ints, unique_numbers
from mien.geometry.surface import vertex_normals
from mien.rigging.warp_and_stick.sheet import twins_of
from mien.rigging.warp_and_stick.walk import Ways, within

MEET_CM = 0.06
"""Skin touches if it is this close, on a human face: the lips of a coarse mesh do not touch along all of them."""
NEARLY_CM = 0.12
"""Skin that a pose brings together all but touches if it comes this close."""
DETOUR_CM = 0.5
"""… and if the way along the skin is at least this long: neighbours do not touch, they are one."""
FACING = 0.3
"""Skin that touches at rest faces other skin, the cosine between the normals is below this, or ends where that does."""
LARGE = 0.05
"""Pieces with less than this share of the skin's vertices touch nothing: lashes lie on one another."""
CROWD = 16
"""So many nearest vertices are looked at for one of other skin."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """Points of a source that touch in one pose.

    Attributes:
        vertices: `(C,)` vertices of the source.
        opposite: the points of the skin they touch.
        gaps: `(C, 3)` from there to the vertex, in the pose.
        met: `(C,)` whether they touch at rest too.
    """

    vertices: Ints
    opposite: SurfacePoints
    gaps: Floats
    met: Flags

    def __len__(self) -> int:
        return len(self.vertices)

    def take(self, rows: Flags) -> Contacts:
        """Keep some of the contacts."""
        return Contacts(self.vertices[rows], self.opposite.take(rows), self.gaps[rows], self.met[rows])


class Touching:
    """Finds where a source's skin touches itself, at rest and in a pose.

    Attributes:
        mesh: the source at rest.
        skin: `(N,)` its skin.
        centimetre: a centimetre on its face.
    """

    def __init__(self, mesh: Mesh, skin: Flags, centimetre: float) -> None:
        skin = skin & large_pieces(mesh.triangles, skin)
        self.mesh, self.skin, self.centimetre = mesh, np.flatnonzero(skin), centimetre
        self._faces = mesh.triangles[skin[mesh.triangles].all(axis=1)]
        edges, edge = edge_lengths(mesh.vertices, self._faces)
        self._ways = ways_of(edges)
        self._meet = MEET_CM * centimetre
        self._nearly = NEARLY_CM * centimetre
        self._near = self._nearly + edge
        self._detour = max(DETOUR_CM * centimetre, 2 * edge)
        incidence = (
            np.ones(3 * len(self._faces), np.int8),
            (self._faces.ravel(), np.repeat(np.arange(len(self._faces)), 3)),
        )
        self._around = sparse.csr_matrix(incidence, shape=(len(skin), len(self._faces)))
        one, faces = self._pairs(mesh.vertices, self.skin, apart=False)
        touching = self._closest(mesh.vertices, one, faces, np.ones(len(one), np.bool_))
        self._at_rest = touching.vertices, touching.opposite.corners

    def contacts(self, displacement: Floats) -> Contacts:
        """Find the vertices that touch other skin in the pose of displacements `(N, 3)`."""
        posed = self.mesh.vertices + displacement
        moved = self.skin[np.linalg.norm(displacement[self.skin], axis=1) > 0.5 * self._meet]
        new = self._pairs(posed, moved, apart=True)
        one, faces = (np.concatenate(both) for both in zip(self._at_rest, new, strict=True))
        met = np.arange(len(one)) < len(self._at_rest[0])
        stirred = displacement[one].any(axis=1) | displacement[faces].any(axis=(1, 2))
        return self._closest(posed, one[stirred], faces[stirred], met[stirred])

    def _pairs(self, posed: Floats, vertices: Ints, *, apart: bool) -> tuple[Ints, Ints]:
        """Return vertices and triangles that come close in a pose and are far from each other along the skin.

        Args:
            posed: `(N, 3)`.
            vertices: the ones of which at least one is in every pair.
            apart: only pairs that were farther apart at rest: all others are in `_at_rest`.
        """
        one, other, distance = self._close(posed, vertices)
        if apart:
            rest = np.linalg.norm(self.mesh.vertices[one] - self.mesh.vertices[other], axis=1)
            kept = np.flatnonzero(rest > 2 * distance + self._meet)
        else:
            facing = (self._normals[one] * self._normals[other]).sum(axis=1) < FACING
            kept = np.flatnonzero(facing | (self._rim[one] & self._rim[other]))
        one, other = one[kept], other[kept]
        strange = self._strangers(one, other)
        one, other = one[strange], other[strange]
        # either end of a pair may be the vertex, the triangles around the other its opposite
        one, other = np.concatenate([one, other]), np.concatenate([other, one])
        around = self._around[other].tocoo()
        one, which = np.divmod(unique_numbers(one[around.row] * len(self._faces) + around.col), len(self._faces))
        faces = self._faces[which]
        clear = np.flatnonzero(self._strangers(np.repeat(one, 3), faces.ravel()).reshape(-1, 3).all(axis=1))
        return one[clear], faces[clear]

    def _close(self, posed: Floats, vertices: Ints) -> tuple[Ints, Ints, Floats]:
        """Return pairs of a vertex and other skin near it in a pose, and their distances."""
        if len(vertices) == 0:
            return vertices, vertices, np.empty(0)
        places, queries = posed[self.skin], posed[vertices]
        low, high = queries.min(axis=0) - self._near, queries.max(axis=0) + self._near
        skin = self.skin[((places >= low) & (places <= high)).all(axis=1)]
        count = min(CROWD, len(skin))
        # this tree is asked once only: a better one takes longer to build than it saves
        tree = cKDTree(posed[skin], balanced_tree=False, compact_nodes=False)
        distance, which = tree.query(queries, count, distance_upper_bound=self._near)
        row, column = np.nonzero(np.isfinite(distance.reshape(len(vertices), count)))
        return (
            vertices[row],
            skin[which.reshape(len(vertices), count)[row, column]],
            distance.reshape(-1, count)[row, column],
        )

    @cached_property
    def _rim(self) -> Flags:
        """Which vertices `(N,)` lie where the skin ends: a slit may be no more than that."""
        edges, n = np.concatenate([self._faces[:, [i, (i + 1) % 3]] for i in range(3)]), len(self.mesh.vertices)
        sides, count = np.unique(edges.min(axis=1) * n + edges.max(axis=1), return_counts=True)
        lonely = sides[count == 1]
        return np.isin(np.arange(n), np.concatenate([lonely // n, lonely % n]))

    @cached_property
    def _normals(self) -> Floats:
        return vertex_normals(self.mesh.vertices, self._faces)

    def _closest(self, posed: Floats, one: Ints, faces: Ints, met: Flags) -> Contacts:
        """Keep for each vertex the closest of its triangles, if that touches."""
        weights = closest_on_triangles(posed[one], posed[faces])
        gaps = posed[one] - np.einsum("mi,mic->mc", weights, posed[faces])
        order = np.lexsort((np.linalg.norm(gaps, axis=1), one))
        best = order[np.unique(one[order], return_index=True)[1]]
        best = best[np.linalg.norm(gaps[best], axis=1) <= np.where(met[best], self._meet, self._nearly)]
        return Contacts(one[best], SurfacePoints(faces[best], weights[best]), gaps[best], met[best])

    def _strangers(self, one: Ints, other: Ints) -> Flags:
        """Tell which pairs are far from each other along the skin."""
        return ~within(self._ways, one, other, np.full(len(one), self._detour))


def ways_of(edges: sparse.csr_matrix) -> Ways:
    """Return edges, each of them stored once, as walks along the skin take them."""
    both = sparse.csr_matrix(edges + edges.T)
    return Ways(both.indptr.astype(np.int64), both.indices.astype(np.int64), both.data)


def edge_lengths(vertices: Floats, triangles: Ints) -> tuple[sparse.csr_matrix, float]:
    """Return the lengths of the edges as a sparse `(N, N)` matrix, next to nothing between twins, and their median."""
    n, twins = len(vertices), twins_of(vertices, triangles)
    edges = np.sort(np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)] + [twins]), axis=1)
    key = unique_numbers(edges[:, 0] * n + edges[:, 1])
    a, b = key // n, key % n
    lengths = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    smallest = 1e-9 * float(lengths.max(initial=1.0))  # a stored zero would mean "no edge"
    middle = float(np.median(lengths)) if len(lengths) else 0.0
    return sparse.csr_matrix((np.maximum(lengths, smallest), (a, b)), shape=(n, n)), middle


def large_pieces(triangles: Ints, skin: Flags) -> Flags:
    """Return `(N,)` which vertices belong to a large connected piece: not lashes or tear film glued to the skin."""
    n = len(skin)
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    linked = sparse.csr_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    piece = connected_components(linked, directed=False)[1]
    return np.asarray(np.bincount(piece)[piece] >= LARGE * skin.sum())


def closest_on_triangles(points: Floats, corners: Floats) -> Floats:
    """Return the weights `(M, 3)` of the point of each triangle `(M, 3, 3)` closest to each point `(M, 3)`."""
    a, b, c = (corners[:, i] for i in range(3))
    u, v, w = b - a, c - a, points - a
    uu, uv, vv, uw, vw = ((x * y).sum(axis=1) for x, y in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    area = np.maximum(uu * vv - uv * uv, 1e-300)
    beta, gamma = (vv * uw - uv * vw) / area, (uu * vw - uv * uw) / area
    best = np.stack([1 - beta - gamma, beta, gamma], axis=1)
    outside = (best < 0).any(axis=1) | (area <= 1e-14 * np.maximum(uu, vv) ** 2)
    nearest = np.where(outside, np.inf, 0.0)
    for i in range(3):
        start, way = corners[:, i], corners[:, (i + 1) % 3] - corners[:, i]
        along = ((points - start) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-300)
        along = np.clip(along, 0, 1)
        distance = np.linalg.norm(points - start - along[:, None] * way, axis=1)
        closer = outside & (distance < nearest)
        edge = np.zeros_like(best)
        edge[:, i], edge[:, (i + 1) % 3] = 1 - along, along
        best = np.where(closer[:, None], edge, best)
        nearest = np.where(closer, distance, nearest)
    return best
