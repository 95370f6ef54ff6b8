"""Muscles and bones carried by the dense correspondence (Orvalho et al., §4.4).

What lies under the skin goes where the warp of the *whole* skin takes it, not the warp
of the landmarks alone, so that it keeps its place under the skin (their figure 4).

The skin is the one that is seen: a muscle of the lips lies close to the lining of the
mouth, which many faces lack and no two have alike.  And the warp follows the skin as a
stiff sheet would rather than through every vertex: where the correspondence is rough, a
fibre must not be.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mien.core.arrays import Floats, Ints
from mien.core.units import human_centimetre
from mien.geometry.muscles import fibre_length
from mien.geometry.surface import exposed, vertex_normals
from mien.geometry.tps import ThinPlate, fit_thin_plate
from mien.rigging.dense import DenseFit

MOST_CENTRES = 1000
"""With more pairs than this, as many of them are the centres; solving costs the cube of their number."""
STIFF_CM = 1.0
"""How far the warp gives up closeness for smoothness, on a human face."""
REACH_CM = 2.5
"""A frame turns and grows as the skin within about this distance of it does, on a human face."""
BITS = 10
"""Points are ordered along a curve through as many halvings of space."""
DEGREE = 13
"""The warp bends a fibre by a polynomial of this degree along it: enough for a ring around a mouth of another shape."""


@dataclass(frozen=True, eq=False)
class Structure:
    """The warp of what lies under the skin.

    Attributes:
        warp: the thin-plate warp of the dense pairs.
        vertices: `(P,)` the vertices of the source that are pairs.
        sources, targets: `(P, 3)` the dense pairs.
        left_over: the root-mean-square distance by which it misses a pair [m].
        reach: the radius around a frame whose skin says how it turns and grows [m].
    """

    warp: ThinPlate
    vertices: Ints
    sources: Floats
    targets: Floats
    left_over: float
    reach: float

    @classmethod
    def of(cls, fit: DenseFit, most: int = MOST_CENTRES) -> Structure:
        """Fit the warp to the pairs of a correspondence."""
        paired = np.flatnonzero(fit.paired)
        paired = paired[np.unique(fit.source.vertices[paired].round(7), axis=0, return_index=True)[1]]
        normals = vertex_normals(fit.source.vertices, fit.source.triangles)[paired]
        seen = paired[exposed(fit.source, fit.source.vertices[paired], normals)]
        kept = np.sort(seen if len(seen) >= len(paired) // 4 else paired)
        sources, targets = fit.source.vertices[kept], fit.stuck[kept]
        centimetre = human_centimetre(fit.warp.centres)
        chosen = np.arange(len(kept)) if len(kept) <= most else _some(sources, most)
        stiffness = STIFF_CM * centimetre * len(chosen) / len(kept)  # fewer centres each stand for more skin
        warp = fit_thin_plate(sources[chosen], targets[chosen], stiffness)
        missed = float(np.sqrt(((warp(sources) - targets) ** 2).sum(axis=1).mean()))
        return cls(warp, kept, sources, targets, missed, REACH_CM * centimetre)

    def frame(self, frame: Floats) -> Floats:
        """Carry a rigid frame `(4, 4)`: its place by the warp, its turn by the skin around it.

        The derivative of a warp is as rough as the mesh.  The similarity that fits the
        surrounding skin best is not.
        """
        moved = np.eye(4)
        moved[:3, :3] = self.around(frame[:3, 3])[0] @ frame[:3, :3]
        moved[:3, 3] = self.warp(frame[None, :3, 3])[0]
        return moved

    def around(self, place: Floats) -> tuple[Floats, float]:
        """Return the rotation `(3, 3)` and scale of the similarity that fits the skin around a place best."""
        apart = ((self.sources - place) ** 2).sum(axis=1)
        return self._similarity(np.exp(-(apart - apart.min()) / self.reach**2))

    def line(self, line: Floats) -> Floats:
        """Carry a fibre `(P, 3)`: with the skin around it, and bent by the warp no less smoothly than it was."""
        middle = line.mean(axis=0)
        turn, scale = self.around(middle)
        moved = scale * (line - middle) @ turn.T
        steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
        along = np.append(0, np.cumsum(steps)) / max(fibre_length(line), 1e-300)
        basis = np.polynomial.legendre.legvander(2 * along - 1, min(DEGREE, len(line) - 1))
        bent = np.linalg.lstsq(basis, self.warp(line) - moved, rcond=None)[0]
        return np.asarray(moved + basis @ bent)

    def growth(self, weights: Floats) -> float:
        """Return by how much the skin that bears these weights `(Ns,)` grows."""
        shares = weights[self.vertices]
        if np.count_nonzero(shares) < 4:
            return self._similarity(np.ones(len(shares)))[1]
        _, before, after = self._spread(shares)
        return float(np.sqrt(after / before))

    def _similarity(self, weights: Floats) -> tuple[Floats, float]:
        """Return rotation and scale of the similarity that fits the pairs best."""
        together, power, _ = self._spread(weights)
        left, stretch, right = np.linalg.svd(together)
        mirror = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        return np.asarray(left * mirror @ right), float(stretch @ mirror / power)

    def _spread(self, weights: Floats) -> tuple[Floats, float, float]:
        """Return how the pairs vary together `(3, 3)`, the targets in rows, and the sources and the targets alone."""
        mean = weights @ self._moments / weights.sum()
        source, target = mean[:3], mean[3:6]
        together = mean[8:].reshape(3, 3) - np.outer(target, source)
        return together, float(mean[6] - source @ source), float(mean[7] - target @ target)

    @cached_property
    def _moments(self) -> Floats:
        """First and second moments of every pair `(P, 17)` about the middle of them all."""
        a, b = (points - points.mean(axis=0) for points in (self.sources, self.targets))
        squares = [(points**2).sum(axis=1)[:, None] for points in (a, b)]
        return np.hstack([a, b, *squares, (b[:, :, None] * a[:, None, :]).reshape(-1, 9)])


def _some(points: Floats, count: int) -> Ints:
    """Return so many points spread as densely as all are: where a rig is fine, its features are."""
    walk = _along_curve(points)
    return np.sort(walk[np.unique(np.linspace(0, len(points) - 1, count).round().astype(np.int64))])


def _along_curve(points: Floats) -> Ints:
    """Return the order of points along a curve through space that visits neighbours one after the other (Morton 1966)."""
    extent = float(np.ptp(points, axis=0).max())
    cells = ((points - points.min(axis=0)) / extent * (2**BITS - 1)).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(BITS):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")
