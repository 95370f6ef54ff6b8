"""A skin as sticking needs it: who is next to whom, which way it faces, and where its seams are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import Searchable, triangle_normals, vertex_normals
from mien.rigging.warp_and_stick.seams import seams
from mien.rigging.warp_and_stick.walk import Ways

SEAM_REACH = 0.06
"""Two sides of a seam are nearer to each other than this share of the face's radius …"""
SEAM_RATIO = 2.2
"""… and the way along the skin is longer by this factor."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """The skin of a mesh, ready to walk on.

    Vertices that a file doubled along a texture seam are joined by edges without length.

    Attributes:
        vertices: `(N, 3)` positions; those of no triangle are not part of the sheet.
        triangles: `(T, 3)` the skin's.
        normals: `(T, 3)` of the triangles.
        facing: `(N, 3)` of the vertices.
        ways: its edges.
        fan_starts, fans: the usable triangles around vertex `v` are `fans[fan_starts[v]:fan_starts[v + 1]]`.
        usable: `(T,)` which triangles may be stuck to.
    """

    vertices: Floats
    triangles: Ints
    normals: Floats
    facing: Floats
    ways: Ways
    fan_starts: Ints
    fans: Ints
    usable: Flags

    @classmethod
    def of(cls, vertices: Floats, triangles: Ints, twins: Ints, usable: Flags | None = None) -> Sheet:
        """Make the sheet of some triangles.

        Args:
            vertices: `(N, 3)`.
            triangles: `(T, 3)`.
            twins: `(P, 2)` vertices that are one point of the skin.
            usable: `(T,)` which triangles may be stuck to; all if None.
        """
        # copies, so that the compiled walks meet one kind of array and are compiled once
        vertices, triangles = np.array(vertices, order="C"), np.array(triangles, dtype=np.int64, order="C")
        usable = np.ones(len(triangles), dtype=np.bool_) if usable is None else usable
        graph = _adjacency(triangles, twins, len(vertices))
        return cls(
            vertices,
            triangles,
            triangle_normals(vertices, triangles),
            vertex_normals(vertices, triangles),
            _ways(vertices, graph.indptr.astype(np.int64), graph.indices.astype(np.int64)),
            *_fans(triangles, usable, len(vertices)),
            usable,
        )

    def at(self, vertices: Floats, usable: Flags | None = None) -> Sheet:
        """Return the same sheet elsewhere `(N, 3)`, and perhaps with only some of its triangles usable."""
        vertices, triangles = np.array(vertices, order="C"), self.triangles
        starts, fans = (self.fan_starts, self.fans) if usable is None else _fans(triangles, usable, len(vertices))
        return Sheet(
            vertices,
            triangles,
            triangle_normals(vertices, triangles),
            vertex_normals(vertices, triangles),
            _ways(vertices, self.ways.starts, self.ways.ends),
            starts,
            fans,
            self.usable if usable is None else usable,
        )

    @cached_property
    def used(self) -> Ints:
        """The vertices of its triangles."""
        return np.flatnonzero(np.bincount(self.triangles.ravel(), minlength=len(self.vertices)))

    @cached_property
    def ground(self) -> Searchable:
        """Its usable triangles, for closest points."""
        return Searchable(self.vertices, self.triangles[self.usable])

    def graph(self, shortest: float = 0.0) -> sparse.csr_matrix:
        """Return the `(N, N)` lengths of the edges, none of them stored as less than `shortest`."""
        n = len(self.vertices)
        lengths = np.maximum(self.ways.lengths, shortest)
        return sparse.csr_matrix((lengths, self.ways.ends, self.ways.starts), shape=(n, n))

    def order(self, radius: float, landmarks: Ints) -> Floats:
        """Return in which order the vertices are to be laid `(N,)`: larger values first.

        A seam is where skin is near other skin that is far along the surface: between
        lips, lids, behind the ears.  Open skin has its distance from the seams; seams, and
        what lies behind them, the negative of their distance from the open skin.  So each
        side of a seam is reached across its own side.

        Args:
            radius: the face's radius [m].
            landmarks: vertices; the open skin is what is connected to one of them.
        """
        reach, everywhere = SEAM_REACH * radius, np.ones(len(self.vertices))
        at_seams = np.flatnonzero(seams(self.vertices, self.ways, reach, SEAM_RATIO))
        if not len(at_seams):
            return everywhere
        graph = self.graph(shortest=1e-12 * radius)
        from_seams = dijkstra(graph, indices=at_seams, min_only=True)
        clear = np.flatnonzero(from_seams > reach)
        _, part = connected_components(graph[clear][:, clear], directed=False)
        outside = clear[np.isin(part, part[np.isin(clear, landmarks)])]
        if not len(outside):
            return everywhere
        inwards = dijkstra(graph, indices=outside, min_only=True)
        return np.asarray(np.clip(np.where(inwards > 0, -inwards, from_seams), -1e10, 1e10))


def twins_of(vertices: Floats, triangles: Ints) -> Ints:
    """Return `(P, 2)` pairs of vertices that are one point of the skin, stored twice.

    They are in one place, their normals agree, and both lie on a border along which two
    sheets meet edge to edge: a tear film that merely touches the lid is not its skin.
    """
    extent = float(np.ptp(vertices, axis=0).max())
    used = np.flatnonzero(np.bincount(triangles.ravel(), minlength=len(vertices)))
    pairs = used[cKDTree(vertices[used]).query_pairs(1e-7 * extent, output_type="ndarray")]
    if not len(pairs):
        return np.empty((0, 2), dtype=np.int64)
    normals = vertex_normals(vertices, triangles)
    agree = (normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(axis=1) > 0.5
    sewn = np.isin(pairs, _sewn(triangles, pairs, len(vertices))).all(axis=1)
    return np.asarray(pairs[agree & sewn], dtype=np.int64).reshape(-1, 2)


def _sewn(triangles: Ints, pairs: Ints, count: int) -> Ints:
    """Return the vertices of those border edges that another border edge runs along, the other way round."""
    joined = sparse.csr_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, place = connected_components(joined, directed=False)
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]).astype(np.int64)
    doubled = np.zeros(count, np.bool_)
    doubled[pairs] = True
    edges = edges[doubled[edges].any(axis=1)]  # no other edge has one running along it
    border = edges[~np.isin(edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0])]
    ends = place[border].astype(np.int64)
    along = np.isin(ends[:, 0] * count + ends[:, 1], ends[:, 1] * count + ends[:, 0])
    return np.unique(border[along])


def skin_of(triangles: Ints, twins: Ints, count: int, landmarks: Ints) -> Flags:
    """Return which of `count` vertices are connected to a landmark `(N,)`.

    Args:
        triangles: `(T, 3)`.
        twins: `(P, 2)` vertices that are one point.
        count: how many vertices there are.
        landmarks: vertices.
    """
    _, part = connected_components(_adjacency(triangles, twins, count), directed=False)
    return np.asarray(np.isin(part, part[landmarks]))


def _ways(vertices: Floats, starts: Ints, ends: Ints) -> Ways:
    """Return edges with their lengths."""
    rows = np.repeat(np.arange(len(vertices)), np.diff(starts))
    return Ways(starts, ends, np.linalg.norm(vertices[rows] - vertices[ends], axis=1))


def _fans(triangles: Ints, usable: Flags, count: int) -> tuple[Ints, Ints]:
    """Return the usable triangles around each of `count` vertices: where those of each start, and which they are."""
    fan = np.flatnonzero(usable)
    owners = triangles[fan].T.ravel()
    fans = sparse.csr_matrix((np.ones(len(owners)), (owners, np.tile(fan, 3))), shape=(count, len(triangles)))
    return fans.indptr.astype(np.int64), fans.indices.astype(np.int64)


def _adjacency(triangles: Ints, twins: Ints, count: int) -> sparse.csr_matrix:
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)] + [twins])
    joined = sparse.csr_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    return sparse.csr_matrix(joined + joined.T)
