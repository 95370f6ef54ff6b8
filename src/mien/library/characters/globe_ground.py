"""The ground of the globe: its continents and coasts, and the craters in which its mouths are set."""

from __future__ import annotations

from functools import cache

import numpy as np

from mien.core.arrays import Floats
from mien.library.characters.globe_places import EYES, MOUTHS, NOSES, RADIUS, Mouth, seat
from mien.library.characters.parts import Part, geodesic

BRINK = 0.84
"""Where the craters begin in which the mouths are set, over the mouths' outlines."""

CONTINENTS = np.array([
    # x, y, z of the middle, reach
    (-0.62, 0.62, 0.55, 0.30), (-0.80, 0.35, 0.35, 0.26), (-0.75, 0.05, 0.10, 0.26),
    (0.42, 0.82, 0.35, 0.26), (0.78, 0.50, 0.30, 0.30), (0.86, 0.30, 0.02, 0.28),
    (0.62, -0.55, 0.55, 0.24), (0.80, -0.50, 0.15, 0.30), (0.50, -0.80, 0.25, 0.20),
    (-0.30, -0.92, 0.10, 0.26), (-0.70, -0.60, -0.2, 0.30),
    (0.10, 0.35, -0.93, 0.46), (-0.45, 0.15, -0.85, 0.34), (0.40, -0.30, -0.85, 0.30),
])  # fmt: skip
"""Lumps of land."""


@cache
def ground() -> tuple[Part, Floats, Floats, Floats]:
    """Return the unit sphere with its coasts, and per point its share of the land's height, of the spikes, and its depth."""
    sphere = geodesic(4)
    points, edge = sphere.points.copy(), 0.075
    height = _land(points)
    step = 1e-4
    slope = np.stack([(_land(points + step * axis) - height) / step for axis in np.eye(3)], axis=1)
    slope -= (slope * points).sum(axis=1, keepdims=True) * points
    off = height / (slope**2).sum(axis=1)
    shore = np.abs(height) < 0.38 * edge * np.linalg.norm(slope, axis=1)
    points[shore] -= (off[:, None] * slope)[shore]
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points = _with_brinks(points, edge)
    land = shore | (height > 0)
    ice = np.abs(points[:, 1]) > 0.945
    body = Part(points, sphere.triangles).named("sea").named("land", only=np.flatnonzero(land))
    free = _free(points)
    rise = np.clip(height / 0.12, 0, 1) * land * free
    spiky = np.zeros(len(points))
    spiky[:162] = free[:162] * np.clip(1.2 - 0.9 * points[:162, 2], 0.25, 1)
    deep = np.zeros(len(points))
    for m in MOUTHS:
        deep[_over(m, points) < 0.97 * BRINK] = 3.2 * m.size
    return body.named("ice", only=np.flatnonzero(ice)), rise, spiky, deep


def _over(m: Mouth, points: Floats) -> Floats:
    """Return how far points of the unit sphere are from a mouth's middle, over its outline."""
    local = points @ seat(m.x, m.y, m.roll).axes.T
    far = np.arccos(np.clip(local[:, 2], -1, 1))
    flat = RADIUS * far[:, None] * local[:, :2] / np.maximum(np.linalg.norm(local[:, :2], axis=1), 1e-9)[:, None]
    return np.asarray(np.linalg.norm(flat / (m.size * np.array(m.outline)), axis=1))


def _with_brinks(points: Floats, edge: float) -> Floats:
    """Move points of the unit sphere that are near the brink of a mouth's crater onto it."""
    for m in MOUTHS:
        middle = seat(m.x, m.y).axes[2]
        over = _over(m, points)[:, None]
        onto = middle + (points - middle) * BRINK / over
        onto /= np.linalg.norm(onto, axis=1, keepdims=True)
        near = np.linalg.norm(onto - points, axis=1) < 0.5 * edge
        points = np.where(near[:, None], onto, points)
    return points


def _land(points: Floats) -> Floats:
    middle = CONTINENTS[:, :3] / np.linalg.norm(CONTINENTS[:, :3], axis=1, keepdims=True)
    apart = np.linalg.norm(points[:, None] - middle, axis=2) / CONTINENTS[:, 3]
    x, y, z = points.T
    ragged = 0.10 * np.sin(9 * x + 4 * y) + 0.08 * np.sin(13 * y - 7 * z) + 0.06 * np.sin(17 * z + 11 * x)
    return np.asarray(np.log(np.exp(-2.2 * apart**2).sum(axis=1) + 1e-3) * 0.25 + 0.42 + 0.5 * ragged)


def _free(points: Floats) -> Floats:
    """Return 0 for points of the unit sphere under eyes, noses and mouths, and 1 clear of them."""
    free = np.ones(len(points))
    spots = [(m.x, m.y, 6.2 * m.size) for m in MOUTHS] + [(x, y, 2.0 * s) for x, y, s in NOSES]
    spots += [(e.x, e.y, 1.2 * e.radius) for e in EYES if not e.stalk]
    for x, y, reach in spots:
        apart = np.linalg.norm(RADIUS * points - seat(x, y).origin, axis=1)
        free = np.minimum(free, np.clip((apart - reach) / 0.8, 0, 1))
    return free
