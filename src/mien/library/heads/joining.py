"""Joining points on a skin to triangles: neighbours in the flat disc first, then the better diagonals in space."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from mien.core.arrays import Floats, Ints
from mien.library.heads.unfold import Core, within


def joined(core: Core, holes: list[Floats], points: Floats) -> Ints:
    """Return the `(T, 3)` triangles between points of the left half, outside the holes.

    Args:
        core: the bar that lays the skin flat.
        holes: polygons in the disc.
        points: `(N, 3)` places on the skin.

    Returns:
        counter-clockwise seen from outside.
    """
    flat = core.flat(points)
    triangles = np.asarray(Delaunay(flat).simplices, dtype=np.int64)
    middle = flat[triangles].mean(axis=1)
    kept = (points[triangles][..., 0] != 0).any(axis=1)
    for hole in holes:
        kept &= ~within(hole, middle)
    triangles = triangles[kept]
    clockwise = _turning(flat, *triangles.T) < 0
    triangles[clockwise] = triangles[clockwise][:, ::-1]
    return _with_better_diagonals(points, flat, triangles)


def _with_better_diagonals(points: Floats, flat: Floats, triangles: Ints) -> Ints:
    """Turn the shared edge of two triangles where the angles facing it add up to more than 180° in space."""
    for _ in range(12):
        first, second, a, b, c, d = _pairs(triangles)
        convex = (_turning(flat, c, a, d) > 1e-9) & (_turning(flat, d, b, c) > 1e-9)
        gain = np.where(convex, _facing_angles(points, a, b, c, d), 0.0)
        rank = np.argsort(np.argsort(gain))
        best = np.full(len(triangles), -1)
        np.maximum.at(best, first, rank)
        np.maximum.at(best, second, rank)
        turned = (gain > 1e-6) & (rank == best[first]) & (rank == best[second])
        if not turned.any():
            break
        triangles[first[turned]] = np.stack([a, d, c], axis=1)[turned]
        triangles[second[turned]] = np.stack([d, b, c], axis=1)[turned]
    return triangles


def _pairs(triangles: Ints) -> tuple[Ints, Ints, Ints, Ints, Ints, Ints]:
    """Return for each inner edge its two triangles, its ends in the order of the first, and the corners facing it."""
    start, end, facing = triangles.T.ravel(), np.roll(triangles, -1, 1).T.ravel(), np.roll(triangles, 1, 1).T.ravel()
    triangle = np.tile(np.arange(len(triangles)), 3)
    key = np.minimum(start, end) * (triangles.max() + 1) + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    twice = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    h, k = order[twice], order[twice + 1]
    return triangle[h], triangle[k], start[h], end[h], facing[h], facing[k]


def _facing_angles(points: Floats, a: Ints, b: Ints, c: Ints, d: Ints) -> Floats:
    """Return how far the angles at `c` and `d` that face the edge `ab` exceed 180° together, as minus their sine."""
    cosine, sine = [], []
    for corner in (c, d):
        u, v = points[a] - points[corner], points[b] - points[corner]
        size = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
        cosine.append((u * v).sum(axis=1) / size)
        sine.append(np.linalg.norm(np.cross(u, v), axis=1) / size)
    return np.asarray(-(sine[0] * cosine[1] + cosine[0] * sine[1]))


def _turning(flat: Floats, a: Ints, b: Ints, c: Ints) -> Floats:
    """Return twice the signed areas of triangles in the disc, positive if they run counter-clockwise."""
    u, v = flat[b] - flat[a], flat[c] - flat[a]
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
