"""Questions about a surface: the closest point, the outside, the way along it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import igl
import igl.embree
import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from mien.core.arrays import Flags, Floats, Ints
from mien.core.errors import InputError
from mien.core.mesh import Mesh, SurfacePoints

GRAZING = 0.2
"""Nobody looks at a surface more aslant than this, the cosine to its normal, to tell whether it is hidden."""


def triangle_normals(vertices: Floats, triangles: Ints) -> Floats:
    """Return `(T, 3)` unit normals; zero for a triangle without area."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return unit(np.asarray(np.cross(b - a, c - a)))


def vertex_normals(vertices: Floats, triangles: Ints) -> Floats:
    """Return `(N, 3)` unit normals weighted by area; zero for an unused vertex."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    weighted = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for i in range(3):
        for axis in range(3):
            normals[:, axis] += np.bincount(triangles[:, i], weighted[:, axis], minlength=len(vertices))
    return unit(normals)


def unit(vectors: Floats) -> Floats:
    """Scale `(…, 3)` vectors to length 1; zero stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))


@dataclass(frozen=True, eq=False)
class Searchable:
    """A surface whose closest points are asked for more than once: its tree is built the first time.

    Attributes:
        vertices: `(N, 3)`.
        triangles: `(T, 3)`; degenerate ones are handled.
    """

    vertices: Floats
    triangles: Ints

    def closest(self, queries: Floats) -> tuple[SurfacePoints, Floats, Ints]:
        """Find the nearest points of the surface, as `closest_points` does."""
        if len(self.triangles) == 0:
            raise InputError("the mesh has no triangles to find a closest point on.")
        tree, vertices, triangles = self._tree
        places = np.ascontiguousarray(queries, dtype=np.float64)
        squared, where, found = tree.squared_distance(vertices, triangles, places)
        corners = triangles[where]
        weights = barycentric(found, *(vertices[corners[:, i]] for i in range(3)))
        return SurfacePoints(corners, weights), np.sqrt(np.asarray(squared)), np.asarray(where)

    @cached_property
    def _tree(self) -> tuple[igl.AABB, Floats, Ints]:
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        triangles = np.ascontiguousarray(self.triangles, dtype=np.int64)
        tree = igl.AABB()
        tree.init(vertices, triangles)
        return tree, vertices, triangles


def closest_points(vertices: Floats, triangles: Ints, queries: Floats) -> tuple[SurfacePoints, Floats, Ints]:
    """Find the nearest point of the surface to each query: on the surface, not the nearest vertex.

    Args:
        vertices: `(N, 3)`.
        triangles: `(T, 3)`; degenerate ones are handled.
        queries: `(M, 3)`.

    Returns:
        The points, their distances `(M,)`, and the triangle each lies in `(M,)`.

    Raises:
        InputError: there is no triangle.
    """
    return Searchable(vertices, triangles).closest(queries)


def barycentric(points: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """Return `(M, 3)` weights of points known to lie in triangles `abc`: non-negative, summing to 1."""
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    uw, vw = (u * w).sum(1), (v * w).sum(1)
    area = uu * vv - uv * uv
    flat = area <= 1e-14 * np.maximum(uu, vv) ** 2
    area = np.where(flat, 1, area)
    beta = np.where(flat, 0, (vv * uw - uv * vw) / area)
    gamma = np.where(flat, 0, (uu * vw - uv * uw) / area)
    if flat.any():  # the nearest corner stands in for a triangle that is a line
        distances = np.stack([np.linalg.norm(points - p, axis=1) for p in (a, b, c)], axis=1)
        nearest = np.eye(3)[np.argmin(distances, axis=1)]
        beta, gamma = np.where(flat, nearest[:, 1], beta), np.where(flat, nearest[:, 2], gamma)
    weights = np.clip(np.stack([1 - beta - gamma, beta, gamma], axis=1), 0, 1)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def distances_along(mesh: Mesh, sources: Ints) -> Floats:
    """Return `(S, N)` shortest path lengths along edges from each source vertex; infinite if unreachable.

    Vertices that a file doubled along a texture seam count as one; lips that merely
    touch do not, because their normals oppose.
    """
    n = len(mesh.vertices)
    a, b = np.concatenate([mesh.triangles[:, [i, (i + 1) % 3]] for i in range(3)]).T
    length = np.linalg.norm(mesh.vertices[a] - mesh.vertices[b], axis=1)
    tiny = 1e-9 * float(length.max(initial=1.0))  # a stored zero would mean "no edge"
    twin_a, twin_b = _seam_twins(mesh)
    rows, columns = np.concatenate([a, twin_a]), np.concatenate([b, twin_b])
    lengths = np.concatenate([np.maximum(length, tiny), np.full(len(twin_a), tiny)])
    key, first = np.unique(np.minimum(rows, columns) * n + np.maximum(rows, columns), return_index=True)
    graph = sparse.csr_matrix((lengths[first], (key // n, key % n)), shape=(n, n))
    return np.asarray(dijkstra(graph, directed=False, indices=np.asarray(sources)))


def _seam_twins(mesh: Mesh) -> tuple[Ints, Ints]:
    extent = float(np.ptp(mesh.vertices, axis=0).max())
    pairs = cKDTree(mesh.vertices).query_pairs(1e-7 * extent, output_type="ndarray")
    normals = vertex_normals(mesh.vertices, mesh.triangles)
    agree = (normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(axis=1) > 0.5
    return pairs[agree, 0], pairs[agree, 1]


def exposed(mesh: Mesh, points: Floats, normals: Floats, ahead: Floats | None = None) -> Flags:
    """Tell which points of a surface can be seen from outside, `(M,)`: not so the inside of a closed mouth.

    Args:
        mesh: what may hide them.
        points, normals: `(M, 3)` on the surface.
        ahead: `(3,)` the direction of the half of space they are looked at from; all of it if None.
    """
    scene = igl.embree.EmbreeIntersector()
    scene.init(np.asfortranarray(mesh.vertices, np.float32), np.asfortranarray(mesh.triangles, np.int32), True)
    around = unit(np.array([axis for axis in np.ndindex(3, 3, 3) if axis != (1, 1, 1)], np.float64) - 1)
    if ahead is not None:
        around = around[around @ ahead > GRAZING * np.linalg.norm(ahead)]
    lift = 1e-4 * float(np.ptp(mesh.vertices, axis=0).max())
    origins, rays = (points + lift * normals).astype(np.float32), list(around.astype(np.float32))
    facing = normals @ around.T
    order, counts = np.argsort(-facing, axis=1, kind="stable"), (facing > GRAZING).sum(axis=1)
    found, first_hit = np.zeros(len(points), np.bool_), scene.intersectRay_first
    for i, origin in enumerate(origins):
        for j in order[i, : counts[i]].tolist():
            if first_hit(origin, rays[j])[0] < 0:
                found[i] = True
                break
    return found


def visible_from(mesh: Mesh, points: Floats, normals: Floats, directions: Floats) -> Floats:
    """Return, for each point, the share of directions from which nothing hides it.

    Args:
        points, normals: `(M, 3)` on the surface.
        directions: `(D, 3)` unit vectors from the surface towards the viewers.
    """
    scene = igl.embree.EmbreeIntersector()
    scene.init(np.asfortranarray(mesh.vertices, np.float32), np.asfortranarray(mesh.triangles, np.int32), True)
    lift = 1e-4 * float(np.ptp(mesh.vertices, axis=0).max())
    origins = (points + lift * normals).astype(np.float32)
    rays = directions.astype(np.float32)
    clear = np.zeros((len(points), len(directions)))
    for i, origin in enumerate(origins):
        for j in np.flatnonzero(directions @ normals[i] > 0):
            clear[i, j] = scene.intersectRay_first(origin, rays[j])[0] < 0
    return np.asarray(clear.mean(axis=1))
