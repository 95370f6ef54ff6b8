"""Smooth solids that a head is modelled from.

A head is a blend of balls and bars, like clay lumps smoothed together; its skin is
where the blended distance is zero.  A table of twenty lumps then says all there is
to say about one person, and another table is another person.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Ball:
    """An ellipsoid, added to what stands before it in the table or carved out of it.

    Attributes:
        centre: its centre [cm]; off the midline it stands for itself and its mirror image.
        radii: its half-axes along x, y and z [cm].
        blend: the width over which it melts into the rest [cm].
        carve: whether it is taken away instead of added.
    """

    centre: Point
    radii: Point
    blend: float
    carve: bool = False

    def distance(self, points: Floats) -> Floats:
        """Return the approximate signed distance of `(N, 3)` points, negative inside."""
        q = (points - self.centre) / self.radii
        length = _lengths(q)
        gradient = _lengths(q / self.radii)
        return np.asarray(length * (length - 1) / np.maximum(gradient, 1e-9))


@dataclass(frozen=True)
class Bar:
    """A rounded bar from `start` to `end`, with the radii of its two ends [cm]."""

    start: Point
    end: Point
    radii: tuple[float, float]
    blend: float
    carve: bool = False

    def distance(self, points: Floats) -> Floats:
        """Return the approximate signed distance of `(N, 3)` points, negative inside."""
        start, axis = np.array(self.start), np.subtract(self.end, self.start)
        along = np.clip((points - start) @ axis / (axis @ axis), 0, 1)
        radius = self.radii[0] + along * (self.radii[1] - self.radii[0])
        return np.asarray(_lengths(points - start - along[:, None] * axis) - radius)


Solids = Sequence[Ball | Bar]


def skin_distance(solids: Solids, points: Floats) -> Floats:
    """Return the signed distance of `(N, 3)` points from the blended skin [cm].

    Points must have `x >= 0`; the other half of the head is their mirror image.
    """
    total = np.full(len(points), 1e3)
    mirrored = points * [-1, 1, 1]
    for solid in solids:
        first = solid.centre if isinstance(solid, Ball) else solid.start
        second = first if isinstance(solid, Ball) else solid.end
        sides = (points, mirrored) if first[0] or second[0] else (points,)
        for side in sides:
            d = solid.distance(side)
            total = -_blended(-total, d, solid.blend) if solid.carve else _blended(total, d, solid.blend)
    return total


def first_hit(solids: Solids, origins: Floats, directions: Floats) -> Floats:
    """Return where rays from outside first meet the skin, `(N, 3)`.

    The step is shortened because blended distances overestimate a little.
    """
    points, moving = origins.copy(), np.arange(len(origins))
    for _ in range(60):
        distance = skin_distance(solids, points[moving])
        points[moving] += 0.85 * distance[:, None] * directions[moving]
        moving = moving[np.abs(distance) > 1e-4]
        if not moving.size:
            break
    return points


def _lengths(vectors: Floats) -> Floats:
    """Return the lengths of `(n, 3)` vectors, faster than `np.linalg.norm` along an axis."""
    return np.asarray(np.sqrt(np.einsum("ni,ni->n", vectors, vectors)))


def _blended(a: Floats, b: Floats, width: float) -> Floats:
    """Return the smooth minimum: equal to the smaller where they differ by more than `width`."""
    h = np.maximum(width - np.abs(a - b), 0) / width
    return np.asarray(np.minimum(a, b) - h * h * width / 4)
