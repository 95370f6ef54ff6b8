"""Places on the way back that the way there confirms.

A point of the target, and the place on the source that was stuck nearest to it, lie both
on the target's surface.  If the way between them along that surface is much longer than
the straight one, they are on two sides of a seam, and the place is sought again among
what was stuck on the right side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import SurfacePoints
from mien.core.arrays import Flags, Ints
from mien.geometry.surface import closest_points
from mien.rigging.warp_and_stick.sheet import Sheet
from mien.rigging.warp_and_stick.stick import DETOUR
from mien.rigging.warp_and_stick.walk import walk, within

WIDENINGS = 6
"""How often the way around a point is doubled until something stuck is found along it."""


def confirmed(
    target: Sheet, there: SurfacePoints, stuck: Sheet, back: SurfacePoints, wanted: Flags
) -> tuple[SurfacePoints, int]:
    """Put right the places that are on the other side of a seam.

    Args:
        target: the sheet that was stuck to.
        there: `(Ns,)` where each vertex of the source is on it.
        stuck: the source, stuck.
        back: `(Nt,)` where each vertex of the target is on the source.
        wanted: `(Nt,)` which vertices to look at.

    Returns:
        The places, and how many were changed.
    """
    rows = np.flatnonzero(wanted)
    landed = _heaviest(there)
    agree = _same_side(target, rows, landed[_heaviest(back)[rows]])
    corners, weights = back.corners.copy(), back.weights.copy()
    arrivals = _Arrivals.of(landed, stuck, len(target.vertices))
    changed = 0
    for v in rows[~agree].tolist():
        fan = arrivals.around(v, target, stuck)
        if len(fan):
            place, _, _ = closest_points(stuck.vertices, stuck.triangles[fan], target.vertices[v : v + 1])
            corners[v], weights[v] = place.corners[0], place.weights[0]
            changed += 1
    return SurfacePoints(corners, weights), changed


@dataclass(frozen=True, eq=False)
class _Arrivals:
    """Which vertices of the source landed at which vertex of the target: `sources[starts[v]:starts[v + 1]]`."""

    sources: Ints
    starts: Ints

    @classmethod
    def of(cls, landed: Ints, stuck: Sheet, count: int) -> _Arrivals:
        used = np.unique(stuck.triangles[stuck.usable])
        order = used[np.argsort(landed[used], kind="stable")]
        return cls(order, np.searchsorted(landed[order], np.arange(count + 1)))

    def around(self, vertex: int, target: Sheet, stuck: Sheet) -> Ints:
        """Return the stuck triangles nearest to a vertex along the target; none if there are none near."""
        along, touched = np.full(len(target.vertices), np.inf), np.empty(len(target.vertices), np.int64)
        along[vertex], touched[0] = 0.0, vertex
        edges = target.ways.lengths[target.ways.starts[vertex] : target.ways.starts[vertex + 1]]
        limit, count = float(edges.max(initial=0.0)), 1
        for _ in range(WIDENINGS):
            count = walk(target.ways, limit, along, touched, count)
            found = [self.sources[self.starts[w] : self.starts[w + 1]] for w in touched[:count]]
            fans = [stuck.fans[stuck.fan_starts[s] : stuck.fan_starts[s + 1]] for s in np.concatenate(found)]
            if fans:
                return np.unique(np.concatenate(fans))
            limit *= 2
        return np.empty(0, np.int64)


def _heaviest(points: SurfacePoints) -> Ints:
    return np.asarray(points.corners[np.arange(len(points)), np.argmax(points.weights, axis=1)])


def _same_side(target: Sheet, rows: Ints, others: Ints) -> Flags:
    """Tell of pairs of vertices whether the way between them is about as short as the straight one."""
    ways = target.ways
    around = np.add.reduceat(np.append(ways.lengths, 0.0), ways.starts[:-1]) / np.maximum(np.diff(ways.starts), 1)
    apart = np.linalg.norm(target.vertices[rows] - target.vertices[others], axis=1)
    return within(ways, others, rows, DETOUR * apart + 2 * around[rows])
