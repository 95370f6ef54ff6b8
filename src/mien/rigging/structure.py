"""Muscles and bones carried by the dense correspondence (Orvalho et al., §4.4).

What lies under the skin goes where the warp of the *whole* skin takes it, not the warp
of the landmarks alone, so that it keeps its place under the skin (their figure 4).  That
warp has as many centres as the skin has vertices; beyond a few thousand it is fitted to
a subset spread over the face, and what the subset leaves over is measured.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from mien.core.arrays import Floats, Ints
from mien.core.units import human_centimetre
from mien.geometry.tps import ThinPlate, fit_thin_plate
from mien.rigging.dense import DenseFit

MOST_CENTRES = 2000
"""Up to this many centres the warp is exact; solving more costs the cube of their number."""
CLOSE_MM = 0.1
"""Centres are added until what is left over is below this on a human face."""
FIRST_CENTRES = 500
REACH_CM = 2.5
"""A frame turns and grows as the skin within about this distance of it does, on a human face."""


@dataclass(frozen=True, eq=False)
class Structure:
    """The warp of what lies under the skin.

    Attributes:
        warp: the thin-plate warp of the dense pairs.
        sources, targets: `(P, 3)` the dense pairs.
        left_over: the largest distance by which it misses a pair [m].
        reach: the radius around a frame whose skin says how it turns and grows [m].
    """

    warp: ThinPlate
    sources: Floats
    targets: Floats
    left_over: float
    reach: float

    @classmethod
    def of(cls, fit: DenseFit, most: int = MOST_CENTRES) -> Structure:
        """Fit the warp to the pairs of a correspondence."""
        paired = np.flatnonzero(fit.paired)
        distinct = paired[np.unique(fit.source.vertices[paired].round(7), axis=0, return_index=True)[1]]
        sources, targets = fit.source.vertices[distinct], fit.stuck[distinct]
        centimetre = human_centimetre(fit.warp.centres)
        goal = 0.1 * CLOSE_MM * human_centimetre(fit.warp(fit.warp.centres))
        warp, left_over = _within(sources, targets, goal, most)
        return cls(warp, sources, targets, left_over, REACH_CM * centimetre)

    def frame(self, frame: Floats) -> tuple[Floats, float]:
        """Carry a rigid frame `(4, 4)`: its place by the warp, its turn by the skin around it.

        The derivative of a warp that runs through every vertex is as rough as the mesh.
        The similarity that fits the surrounding skin best is not.

        Returns:
            The frame on the target, and by how much lengths grow there.
        """
        turn, scale = self.around(frame[:3, 3])
        moved = np.eye(4)
        moved[:3, :3] = turn @ frame[:3, :3]
        moved[:3, 3] = self.warp(frame[None, :3, 3])[0]
        return moved, scale

    def around(self, place: Floats) -> tuple[Floats, float]:
        """Return the rotation `(3, 3)` and scale of the similarity that fits the skin around a place best."""
        apart = ((self.sources - place) ** 2).sum(axis=1)
        weights = np.exp(-(apart - apart.min()) / self.reach**2)
        weights /= weights.sum()
        a, b = (points - weights @ points for points in (self.sources, self.targets))
        left, stretch, right = np.linalg.svd((b * weights[:, None]).T @ a)
        mirror = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        power = weights @ (a**2).sum(axis=1)
        return np.asarray(left * mirror @ right), float(stretch @ mirror / power)


def _within(sources: Floats, targets: Floats, goal: float, most: int) -> tuple[ThinPlate, float]:
    """Fit a warp to as few centres as bring all pairs within `goal`, or to `most` of them."""
    chosen = np.arange(len(sources)) if len(sources) <= most else _spread(sources, FIRST_CENTRES)
    while True:
        warp = fit_thin_plate(sources[chosen], targets[chosen])
        missed = np.linalg.norm(warp(sources) - targets, axis=1)
        worst = float(missed.max())
        if worst <= goal or len(chosen) >= min(most, len(sources)):
            return warp, worst
        extra = _worst_apart(sources, missed, min(len(chosen), most - len(chosen)))
        chosen = np.union1d(chosen, extra)


def _spread(points: Floats, count: int) -> Ints:
    """Return points spread evenly: always the farthest from those chosen."""
    chosen = [int(np.argmin(points[:, 1]))]
    gap = np.full(len(points), np.inf)
    while len(chosen) < count:
        gap = np.minimum(gap, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(gap)))
    return np.array(chosen, dtype=np.int64)


def _worst_apart(points: Floats, missed: Floats, count: int) -> Ints:
    """Return the worst missed points that are not each other's neighbours, at most `count`."""
    near = cKDTree(points).query(points, min(9, len(points)))[1]
    peak = np.flatnonzero(missed >= missed[near].max(axis=1))
    order = np.argsort(-missed, kind="stable")
    ranked = np.concatenate([peak[np.argsort(-missed[peak], kind="stable")], order])
    return np.asarray(ranked[: max(count, 1)])
