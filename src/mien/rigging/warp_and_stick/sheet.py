"""A mesh as walks along it need it: who is next to whom, and how far along the skin."""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np
from numba import njit
from scipy import sparse
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import triangle_normals, vertex_normals

SEAM_REACH = 0.06
"""Two sides of a seam are nearer to each other than this share of the face's radius …"""
SEAM_RATIO = 2.2
"""… and the way along the skin is longer by this factor."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """The skin of a mesh, ready to walk on.

    Vertices that a file doubled along a texture seam are joined by edges without length.

    Attributes:
        vertices: `(N, 3)` positions.
        triangles: `(T, 3)` those of the skin.
        normals: `(T, 3)` unit normals of the triangles.
        vertex_normals: `(N, 3)` of the vertices.
        starts, ends, lengths: the edges of vertex `v` are rows `starts[v]` to `starts[v + 1]`.
        fan_starts, fans: the usable triangles around vertex `v`, the same way.
        usable: `(T,)` which triangles may be stuck to.
    """

    vertices: Floats
    triangles: Ints
    normals: Floats
    vertex_normals: Floats
    starts: Ints
    ends: Ints
    lengths: Floats
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
        n, t = len(vertices), len(triangles)
        edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)] + [twins])
        joined = sparse.csr_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
        graph = sparse.csr_matrix(joined + joined.T)
        rows = np.repeat(np.arange(n), np.diff(graph.indptr))
        lengths = np.linalg.norm(vertices[rows] - vertices[graph.indices], axis=1)
        usable = np.ones(t, dtype=np.bool_) if usable is None else usable
        fan = np.flatnonzero(usable)
        owners = triangles[fan].T.ravel()
        around = sparse.csr_matrix((np.ones(len(owners)), (owners, np.tile(fan, 3))), shape=(n, t))
        return cls(
            np.array(vertices),
            np.array(triangles, dtype=np.int64),
            triangle_normals(vertices, triangles),
            vertex_normals(vertices, triangles),
            graph.indptr.astype(np.int64),
            graph.indices.astype(np.int64),
            lengths,
            around.indptr.astype(np.int64),
            around.indices.astype(np.int64),
            usable,
        )

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
        reach = SEAM_REACH * radius
        n = len(self.vertices)
        gap = _gaps(self.vertices, self.starts, self.ends, self.lengths, reach, SEAM_RATIO)
        graph = sparse.csr_matrix((self.lengths + 1e-12 * radius, self.ends, self.starts), shape=(n, n))
        seams = np.flatnonzero(np.isfinite(gap))
        if not len(seams):
            return np.ones(n)
        from_seams = dijkstra(graph, indices=seams, min_only=True)
        clear = np.flatnonzero(from_seams > reach)
        _, part = connected_components(graph[clear][:, clear], directed=False)
        outside = clear[np.isin(part, part[np.isin(clear, landmarks)])]
        if not len(outside):
            return np.ones(n)
        inwards = dijkstra(graph, indices=outside, min_only=True)
        return np.where(inwards > 0, -inwards, from_seams)


def twins_of(vertices: Floats, triangles: Ints) -> Ints:
    """Return `(P, 2)` pairs of vertices in one place whose normals agree: one point, stored twice."""
    extent = float(np.ptp(vertices, axis=0).max())
    used = np.unique(triangles)
    pairs = used[cKDTree(vertices[used]).query_pairs(1e-7 * extent, output_type="ndarray")]
    normals = vertex_normals(vertices, triangles)
    agree = (normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(axis=1) > 0.5
    return np.asarray(pairs[agree], dtype=np.int64).reshape(-1, 2)


@njit(cache=True, nogil=True)
def _gaps(vertices: Floats, starts: Ints, ends: Ints, lengths: Floats, reach: float, ratio: float) -> Floats:
    """`(N,)` distance to the nearest vertex that is `ratio` times as far along the skin; infinite beyond reach."""
    n = len(vertices)
    cells = np.empty((n, 3), np.int64)
    for v in range(n):
        for i in range(3):
            cells[v, i] = int(np.floor(vertices[v, i] / reach))
    low = np.array([cells[:, i].min() for i in range(3)])
    size = np.array([cells[:, i].max() - low[i] + 1 for i in range(3)])
    key = ((cells[:, 0] - low[0]) * size[1] + cells[:, 1] - low[1]) * size[2] + cells[:, 2] - low[2]
    order = np.argsort(key)
    ranked = key[order]
    gap = np.full(n, np.inf)
    along = np.full(n, np.inf)
    touched = np.empty(n, np.int64)
    for v in range(n):
        if starts[v] == starts[v + 1]:
            continue
        count, edge = _walk(v, starts, ends, lengths, ratio * reach, along, touched)
        for dx in range(-1, 2):
            for dy in range(-1, 2):
                x, y, z = cells[v, 0] - low[0] + dx, cells[v, 1] - low[1] + dy, cells[v, 2] - low[2]
                if x < 0 or y < 0 or x >= size[0] or y >= size[1]:
                    continue
                row = (x * size[1] + y) * size[2]
                first = np.searchsorted(ranked, row + max(z - 1, 0))
                last = np.searchsorted(ranked, row + min(z + 1, size[2] - 1), side="right")
                for k in range(first, last):
                    w = order[k]
                    apart = np.sqrt(((vertices[v] - vertices[w]) ** 2).sum())
                    if apart < min(reach, gap[v]) and starts[w] < starts[w + 1]:
                        if along[w] > ratio * apart + 2 * edge:
                            gap[v] = apart
        for k in range(count):
            along[touched[k]] = np.inf
    return gap


@njit(cache=True, nogil=True)
def _walk(
    origin: int, starts: Ints, ends: Ints, lengths: Floats, limit: float, along: Floats, touched: Ints
) -> tuple[int, float]:
    """Fill `along` with the ways from a vertex up to a limit; say how many it reached and the mean first edge."""
    along[origin] = 0.0
    touched[0] = origin
    count = 1
    queue = [(0.0, origin)]
    while len(queue) > 0:
        way, v = heappop(queue)
        if way > along[v]:
            continue
        for e in range(starts[v], starts[v + 1]):
            w, further = ends[e], way + lengths[e]
            if further < along[w] and further <= limit:
                if along[w] == np.inf:
                    touched[count] = w
                    count += 1
                along[w] = further
                heappush(queue, (further, w))
    return count, lengths[starts[origin] : starts[origin + 1]].mean()
