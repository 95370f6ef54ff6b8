"""The pieces a character is put together from: closed surfaces of rings, each with its named places.

Every piece is a stack of rings of points between two tips, whatever it is: a ball, a
lid, a tube, a box, a mouth with its lips and its inside.  A piece keeps its topology in
every pose, so that a pose of a character is the same code run with other numbers.
Lengths here are centimetres.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from mien.core import Mesh
from mien.core.arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class Part:
    """A closed surface.

    Attributes:
        points: `(n, 3)` [cm].
        triangles: `(t, 3)` indices into the points; which way they turn is seen to when parts are put together.
        groups: the points of each named place.
    """

    points: Floats
    triangles: Ints
    groups: Mapping[str, Ints] = field(default_factory=dict)

    def named(self, *groups: str, only: Ints | None = None) -> Part:
        """Return the part with all its points, or only these, in further groups."""
        ids = np.arange(len(self.points)) if only is None else only
        return replace(self, groups={**self.groups, **dict.fromkeys(groups, ids)})

    def moved(self, field: Callable[[Floats], Floats]) -> Part:
        """Return the part with its points sent elsewhere."""
        return replace(self, points=field(self.points))

    def shifted(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Part:
        """Return the part moved as it is."""
        return replace(self, points=self.points + [x, y, z])


@dataclass(frozen=True, eq=False)
class Frame:
    """A place and three directions: right, up and out, one a row."""

    origin: Floats
    axes: Floats

    @classmethod
    def facing(cls, origin: Floats, out: Floats) -> Frame:
        """Make the frame at a place that looks along `out` with its right level; `out` is not vertical."""
        out = out / np.linalg.norm(out)
        right = np.array([out[2], 0.0, -out[0]]) / np.hypot(out[0], out[2])
        return cls(origin, np.stack([right, np.cross(out, right), out]))

    def place(self, points: Floats) -> Floats:
        """Return points given in this frame where they are in the world."""
        return np.asarray(self.origin + points @ self.axes)

    def carried(self, field: Callable[[Floats], Floats]) -> Frame:
        """Return the frame as a rigid thing goes along with a deformation of the space around it."""
        step = 1e-4
        ends = field(
            np.concatenate([self.origin + step * self.axes, self.origin - step * self.axes, self.origin[None]])
        )
        left, _, right = np.linalg.svd((ends[:3] - ends[3:6]) / (2 * step))
        return Frame(ends[6], left @ right)


def rolled(angle: float) -> Frame:
    """Return the frame at the origin that is turned about z by an angle [degrees]."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return Frame(np.zeros(3), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))


def moved(parts: Sequence[Part], field: Callable[[Floats], Floats]) -> list[Part]:
    """Return parts with all their points sent elsewhere at once."""
    ends = np.cumsum([len(part.points) for part in parts])
    points = np.split(field(np.concatenate([part.points for part in parts])), ends[:-1])
    return [replace(part, points=own) for part, own in zip(parts, points, strict=True)]


def rings(stack: Floats, tips: Floats) -> Part:
    """Make a closed surface of `(R, C, 3)` rings between two tips `(2, 3)`, which come last."""
    points = np.concatenate([stack.reshape(-1, 3), tips])
    return Part(points, _net(*stack.shape[:2]))


def ring_ids(columns: int, first: int, last: int | None = None) -> Ints:
    """Return the points of some rings of a part, by number from `first` to before `last`."""
    return np.arange(first * columns, (first + 1 if last is None else last) * columns)


@cache
def _net(rows: int, columns: int) -> Ints:
    inner = np.arange((rows - 1) * columns).reshape(rows - 1, columns)
    following = np.roll(inner, -1, axis=1)
    quads = [
        np.stack([inner, inner + columns, following + columns], -1),
        np.stack([inner, following + columns, following], -1),
    ]
    first, last = np.arange(columns), (rows - 1) * columns + np.arange(columns)
    ends = np.full(columns, rows * columns)
    fans = [np.stack([ends, first, np.roll(first, -1)], -1), np.stack([ends + 1, np.roll(last, -1), last], -1)]
    return np.concatenate([quads[0].reshape(-1, 3), quads[1].reshape(-1, 3), *fans])


@cache
def circle(columns: int) -> Floats:
    """Return `(C, 2)` points around the unit circle."""
    turn = 2 * np.pi * np.arange(columns) / columns
    return np.stack([np.cos(turn), np.sin(turn)], axis=1)


def ball(polar: Floats, columns: int, radius: float | Floats = 1.0) -> Part:
    """Make a ball about the origin with rings at these angles from +Z [rad]; `radius` may differ by ring."""
    around = circle(columns)
    size = np.broadcast_to(radius, polar.shape)
    flat = (size * np.sin(polar))[:, None, None] * around
    deep = np.broadcast_to((size * np.cos(polar))[:, None, None], (*flat.shape[:2], 1))
    return rings(np.concatenate([flat, deep], axis=2), np.array([[0, 0, size[0]], [0, 0, -size[-1]]]))


@cache
def blob(radii: tuple[float, float, float], rows: int = 9, columns: int = 16) -> Part:
    """Make an ellipsoid about the origin."""
    return ball(polar_angles(rows), columns).moved(lambda p: p * radii)


def polar_angles(rows: int) -> Floats:
    """Return angles for the rings of a ball, or of a lid from corner to corner, spread evenly between its tips [rad]."""
    return np.asarray(np.pi * (np.arange(rows) + 0.7) / (rows + 0.4), dtype=np.float64)


def turned(profile: Sequence[tuple[float, float]], outline: Floats) -> Part:
    """Make what a profile of (reach, height) draws when its reach scales an outline `(C, 2)` about the z-axis.

    The outermost edge of the part is the outline itself where the reach is 1.
    """
    reach, height = np.array(profile).T
    flat = reach[:, None, None] * outline
    deep = np.broadcast_to(height[:, None, None], (*flat.shape[:2], 1))
    return rings(np.concatenate([flat, deep], axis=2), np.array([[0, 0, height[0]], [0, 0, height[-1]]]))


@cache
def rounded(half_width: float, half_height: float, corner: float, columns: int = 48) -> Floats:
    """Return the `(C, 2)` outline of a rectangle with round corners, its points spread evenly."""
    dense = circle(1024)
    inner = np.array([half_width - corner, half_height - corner])
    path = np.sign(dense) * inner + corner * dense
    path = np.concatenate([path, path[:1]])
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    even = np.linspace(0, along[-1], columns, endpoint=False)
    return np.stack([np.interp(even, along, path[:, axis]) for axis in range(2)], axis=1)


def slab(outline: Floats, back: float, front: float, bevel: float = 0.2, steps: int = 2) -> Part:
    """Make a plate with an outline and bevelled edges from `back` to `front` along z."""
    reach = float(np.abs(outline).max(axis=0).min())
    inset = 1 - bevel / reach
    face = [(inset * k / steps, front) for k in range(1, steps + 1)]
    edge = [(1 - 0.3 * bevel / reach, front - 0.3 * bevel), (1.0, front - bevel), (1.0, back + bevel)]
    return turned([*face, *edge, (1 - 0.3 * bevel / reach, back + 0.3 * bevel), (inset, back)], outline)


def tube(path: Floats, radii: Floats, columns: int = 12) -> Part:
    """Sweep a circle along a path `(n, 3)` that never runs along z; `radii` by point."""
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    around = circle(columns)
    ring = around[None, :, :1] * side[:, None] + around[None, :, 1:] * up[:, None]
    reach = 0.4 * radii[[0, -1], None] * along[[0, -1]] * [[-1], [1]]
    return rings(path[:, None] + radii[:, None, None] * ring, path[[0, -1]] + reach)


def geodesic(divisions: int) -> Part:
    """Make a unit sphere of an icosahedron whose triangles are divided in four so many times.

    The points of every coarser sphere come before those of the finer.
    """
    golden = (1 + 5**0.5) / 2
    corners = [(s, t * golden, 0.0) for s in (1.0, -1.0) for t in (1.0, -1.0)]
    points = np.array([np.roll(c, turn) for turn in range(3) for c in corners])
    points /= np.linalg.norm(points[0])
    near = points @ points.T > 0.4
    triangles = np.array(
        [(i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[i, k]]
    )
    normal = np.linalg.det(points[triangles])
    triangles[normal < 0] = triangles[normal < 0][:, ::-1]
    for _ in range(divisions):
        points, triangles = _divided(points, triangles)
    return Part(points, triangles)


def _divided(points: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    sides = np.sort(np.stack([triangles[:, [1, 2]], triangles[:, [2, 0]], triangles[:, [0, 1]]], axis=1), axis=2)
    edges, number = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
    middle = points[edges].sum(axis=1)
    a, b, c = triangles.T
    p, q, r = (len(points) + number.reshape(-1, 3)).T
    four = np.concatenate([np.stack(t, axis=1) for t in ((a, r, q), (r, b, p), (q, p, c), (p, q, r))])
    return np.concatenate([points, middle / np.linalg.norm(middle, axis=1, keepdims=True)]), four


def joined(parts: Sequence[Part]) -> Mesh:
    """Return one mesh of all parts, each turned to face outwards [cm]."""
    groups: dict[str, list[Ints]] = {}
    triangles, first = [], 0
    for part in parts:
        volume = np.linalg.det(part.points[part.triangles] - part.points.mean(axis=0)).sum()
        triangles.append(first + (part.triangles if volume > 0 else part.triangles[:, ::-1]))
        for name, ids in part.groups.items():
            groups.setdefault(name, []).append(first + ids)
        first += len(part.points)
    vertices = np.concatenate([part.points for part in parts])
    return Mesh(vertices, np.concatenate(triangles), groups={name: np.concatenate(ids) for name, ids in groups.items()})
