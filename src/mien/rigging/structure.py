"""Muscles and bones carried by the dense correspondence (Orvalho et al., §4.4).

What lies under the skin goes where the warp of the *whole* skin takes it, not the warp
of the landmarks alone, so that it keeps its place under the skin (their figure 4).

The skin is the one that is seen: a muscle of the lips lies close to the lining of the
mouth, which many faces lack and no two have alike.  And the warp follows the skin as a
stiff sheet would rather than through every vertex: where the correspondence is rough, a
fibre must not be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.distance import cdist

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
STEEPEST = 1.25
"""What skin does may become so many times as steep on another face as it is on the rig's own."""
DEGREE = 13
"""The warp bends a fibre by a polynomial of this degree along it: enough for a ring around a mouth of another shape."""


@dataclass(frozen=True, eq=False)
class Structure:
    """The warp of what lies under the skin.

    Attributes:
        warp: the thin-plate warp of the dense pairs.
        vertices: `(P,)` the vertices of the source that are pairs.
        sources, targets: `(P, 3)` the dense pairs.
        triangles: `(T, 3)` of the source, between its pairs, as rows of these.
        left_over: the root-mean-square distance by which it misses a pair [m].
        reach: the radius around a frame whose skin says how it turns and grows [m].
    """

    warp: ThinPlate
    vertices: Ints
    sources: Floats
    targets: Floats
    triangles: Ints
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
        number = np.full(len(fit.source.vertices), -1)
        number[kept] = np.arange(len(kept))
        triangles = number[fit.source.triangles]
        triangles = triangles[(triangles >= 0).all(axis=1)]
        return cls(warp, kept, sources, targets, triangles, missed, REACH_CM * centimetre)

    def frame(self, frame: Floats) -> Floats:
        """Carry rigid frames `(…, 4, 4)`: their place by the warp, their turn by the skin around them.

        The derivative of a warp is as rough as the mesh.  The similarity that fits the
        surrounding skin best is not.
        """
        moved = np.zeros(np.shape(frame))
        moved[..., :3, :3] = self.around(frame[..., :3, 3])[0] @ frame[..., :3, :3]
        moved[..., :3, 3] = self.warp(frame[..., :3, 3])
        moved[..., 3, 3] = 1
        return moved

    def around(self, places: Floats) -> tuple[Floats, Floats]:
        """Return rotation `(…, 3, 3)` and scale `(…)` of the similarity that fits the skin around places `(…, 3)` best."""
        apart = cdist(np.reshape(places, (-1, 3)), self.sources, "sqeuclidean")
        near = np.exp(-(apart - apart.min(axis=1, keepdims=True)) / self.reach**2)
        return self._similarity(near.reshape(*np.shape(places)[:-1], -1))

    def lines(self, lines: Sequence[Floats]) -> list[Floats]:
        """Carry fibres `(P, 3)`: with the skin around each, and bent by the warp no less smoothly than it was."""
        if not lines:
            return []
        turns, scales = self.around(np.stack([line.mean(axis=0) for line in lines]))
        there = np.split(self.warp(np.concatenate(lines)), np.cumsum([len(line) for line in lines])[:-1])
        return [_bent(*each) for each in zip(lines, there, turns, scales, strict=True)]

    def growth(self, weights: Floats) -> Floats:
        """Return by how much the skin that bears weights `(…, Ns)` grows, `(…)`."""
        shares = weights[..., self.vertices]
        few = np.count_nonzero(shares, axis=-1) < 4
        _, before, after = self._spread(np.where(few[..., None], 1.0, shares))
        overall = self._similarity(np.ones(len(self.vertices)))[1]
        return np.where(few, overall, np.sqrt(after / before))

    def bearable(self, weights: Floats) -> Floats:
        """Return by how much movements with weights `(…, Ns)` may grow before the skin cannot bear them, `(…)`.

        Skin that is stretched one way only, as the lips of a wide mouth are, lets a movement
        fall off over no longer a way than before.  One that grew with it would be too steep
        there, and turn the skin over.
        """
        shares = weights[..., self.vertices][..., self.triangles]
        before, after = (_breadth(shares, points[self.triangles]) for points in (self.sources, self.targets))
        most: Floats = np.full(np.shape(before), np.inf)
        return np.asarray(np.divide(STEEPEST * after, before, out=most, where=before > 0))

    def _similarity(self, weights: Floats) -> tuple[Floats, Floats]:
        """Return rotations and scales of the similarities that fit the pairs best by weights `(…, P)`."""
        together, power, _ = self._spread(weights)
        left, stretch, right = np.linalg.svd(together)
        mirror = np.ones(np.shape(stretch))
        mirror[..., 2] = np.sign(np.linalg.det(left @ right))
        return left * mirror[..., None, :] @ right, (stretch * mirror).sum(axis=-1) / power

    def _spread(self, weights: Floats) -> tuple[Floats, Floats, Floats]:
        """Return how the pairs vary together `(…, 3, 3)`, the targets in rows, and the sources and the targets alone."""
        mean = weights @ self._moments / weights.sum(axis=-1, keepdims=True)
        source, target = mean[..., :3], mean[..., 3:6]
        together = mean[..., 8:].reshape(*mean.shape[:-1], 3, 3) - target[..., :, None] * source[..., None, :]
        before, after = (mean[..., 6 + i] - (middle**2).sum(axis=-1) for i, middle in enumerate((source, target)))
        return together, before, after

    @cached_property
    def _moments(self) -> Floats:
        """First and second moments of every pair `(P, 17)` about the middle of them all."""
        a, b = (points - points.mean(axis=0) for points in (self.sources, self.targets))
        squares = [(points**2).sum(axis=1)[:, None] for points in (a, b)]
        return np.hstack([a, b, *squares, (b[:, :, None] * a[:, None, :]).reshape(-1, 9)])


def _bent(line: Floats, there: Floats, turn: Floats, scale: float) -> Floats:
    """Return a line `(P, 3)` turned and scaled, and then bent towards where the warp takes it."""
    moved = scale * (line - line.mean(axis=0)) @ turn.T
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    along = np.append(0, np.cumsum(steps)) / max(fibre_length(line), 1e-300)
    basis = np.polynomial.legendre.legvander(2 * along - 1, min(DEGREE, len(line) - 1))
    return np.asarray(moved + basis @ np.linalg.lstsq(basis, there - moved, rcond=None)[0])


def _breadth(shares: Floats, corners: Floats) -> Floats:
    """Return over how long a way weights fall off: their integral over the skin, over that of the size of their slope.

    Of a patch of one weight that is its area over its outline, whatever its shape.  Zero if they have no slope.

    Args:
        shares: `(…, T, 3)` weights at the corners of triangles.
        corners: `(T, 3, 3)` where these are.
    """
    edges = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)  # opposite each corner
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    slope = np.linalg.norm(np.einsum("...tk,tkc->...tc", shares, edges), axis=-1).sum(axis=-1) / 2
    total = shares.mean(axis=-1) @ area
    return np.asarray(np.divide(total, slope, out=np.zeros(np.shape(total)), where=slope > 1e-12 * np.sqrt(area.sum())))


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
