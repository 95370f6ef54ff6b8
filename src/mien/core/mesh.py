"""A surface, and points that ride on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mien.core.arrays import Flags, Floats, Ints, floats, indices
from mien.core.errors import InputError


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh in metres.

    Vertices keep the order of the file they came from; a vertex no triangle uses
    is allowed.

    Attributes:
        vertices: `(N, 3)` positions [m].
        triangles: `(T, 3)` vertex indices, counter-clockwise from outside.
        uv: `(T, 3, 2)` texture coordinates per corner, (0, 0) at the top left as in glTF, or None.
        faces: the polygons as the file had them, for writing; None if triangles.
        groups: vertex indices of each named part (`head`, `teeth`, …).

    Raises:
        InputError: wrong shapes, indices out of range, values not finite.
    """

    vertices: Floats
    triangles: Ints
    uv: Floats | None = None
    faces: tuple[tuple[int, ...], ...] | None = None
    groups: Mapping[str, Ints] = field(default_factory=dict)

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "vertices", floats(self.vertices, (None, 3), "mesh vertices"))
        n = len(self.vertices)
        if n == 0:
            raise InputError("the mesh has no vertices.")
        put(self, "triangles", indices(self.triangles, (None, 3), n, "mesh triangles"))
        if self.uv is not None:
            put(self, "uv", floats(self.uv, (len(self.triangles), 3, 2), "mesh texture coordinates"))
        groups = {name: indices(ids, (None,), n, f"vertex group {name!r}") for name, ids in self.groups.items()}
        put(self, "groups", groups)


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points fixed to a mesh, each a weighted mean of three of its vertices.

    A vertex is the special case of weights (1, 0, 0).  Storing corner indices
    instead of a triangle number keeps the points valid for any triangulation.

    Attributes:
        corners: `(M, 3)` vertex indices.
        weights: `(M, 3)` barycentric weights; each row sums to 1.
    """

    corners: Ints
    weights: Floats

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "weights", floats(self.weights, (None, 3), "barycentric weights"))
        top = np.iinfo(np.int64).max
        put(self, "corners", indices(self.corners, (len(self.weights), 3), top, "surface point corners"))
        off = np.abs(self.weights.sum(axis=1) - 1) > 1e-6
        if off.any():
            worst = int(np.argmax(off))
            raise InputError(f"barycentric weights must sum to 1; point {worst} has {self.weights[worst].tolist()}.")

    @classmethod
    def at_vertices(cls, vertices: Ints) -> SurfacePoints:
        """Make the points that are these vertices."""
        ids = np.asarray(vertices, dtype=np.int64)
        weights = np.zeros((len(ids), 3))
        weights[:, 0] = 1
        return cls(np.repeat(ids[:, None], 3, axis=1), weights)

    def __len__(self) -> int:
        return len(self.weights)

    def of(self, values: Floats) -> Floats:
        """Interpolate per-vertex values, `(…, N, C)` to `(…, M, C)`."""
        return np.asarray(np.einsum("...mic,mi->...mc", values[..., self.corners, :], self.weights))

    def take(self, rows: Ints | Flags) -> SurfacePoints:
        """Keep the points at `rows` (indices or a boolean mask)."""
        return SurfacePoints(self.corners[rows], self.weights[rows])
