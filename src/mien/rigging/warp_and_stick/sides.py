"""The sides of slits: nothing of an upper lip or lid may land on the lower one.

Two landmarks that are near in space and far along the skin face each other over a slit.
Those of one slit fall into two sides, and every point of the skin near it is on the side
whose landmarks are nearer along the skin.  Laying keeps to sides by itself wherever the
ground has a place for what is laid; where it has none, as for a lining that only one of
two faces has, this is what keeps it from drifting around a corner.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import dijkstra

from mien.core import SurfacePoints
from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.correspond import SEAM_RATIO, SEAM_REACH, seam_pairs
from mien.geometry.surface import closest_points
from mien.rigging.warp_and_stick.sheet import Sheet
from mien.rigging.warp_and_stick.stick import FACING

NEAR = 0.25
"""Skin within this share of the face's radius of a slit's landmarks has a side."""
CLEAR = 0.03
"""What is laid is on a side if that side's landmarks are nearer by this share of the face's radius …"""
ASTRAY = 0.02
"""… and it went astray if at its place the other side's are nearer by this share."""

Slit = tuple[Ints, Ints]
"""The landmarks on the two sides of a slit."""


def slits_of(sheet: Sheet, landmarks: SurfacePoints, radius: float) -> list[Slit]:
    """Find the slits of a face and which landmarks are on which side of them.

    Args:
        sheet: the skin.
        landmarks: `L` points of it.
        radius: the face's radius [m].
    """
    graph, ends = sheet.graph(shortest=1e-12 * radius), _vertices(landmarks)
    places = landmarks.of(sheet.vertices)
    along = dijkstra(graph, indices=ends, limit=SEAM_RATIO * SEAM_REACH * radius)[:, ends]
    along[np.isinf(along)] = 2 * SEAM_RATIO * SEAM_REACH * radius  # the skin is one piece
    pairs = seam_pairs(places, along, radius)
    apart = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    return _two_sides(pairs[np.argsort(apart / along[pairs[:, 0], pairs[:, 1]], kind="stable")])


def _two_sides(pairs: Ints) -> list[Slit]:
    """Split landmarks into sides so that paired ones are on different sides; of pairs that contradict, the first count."""
    slit: dict[int, int] = {}
    side: dict[int, int] = {}
    for number, (a, b) in enumerate(pairs.tolist()):
        for end in (a, b):
            if end not in slit:
                slit[end], side[end] = len(pairs) + 2 * number + (end == b), 1
        if slit[a] == slit[b]:
            continue
        turned = side[a] == side[b]
        for end in [end for end, own in slit.items() if own == slit[b]]:
            slit[end], side[end] = slit[a], -side[end] if turned else side[end]
    slits = []
    for number in dict.fromkeys(slit.values()):
        members = [end for end, own in slit.items() if own == number]
        slits.append(tuple(np.array([e for e in members if side[e] == s], np.int64) for s in (1, -1)))
    return [(first, second) for first, second in slits]


def sides(sheet: Sheet, landmarks: SurfacePoints, slits: list[Slit], radius: float) -> Floats:
    """Return by how much the first side of each slit is nearer than the second `(S, N)`, in radii; 0 far from it."""
    graph, ends = sheet.graph(shortest=1e-12 * radius), _vertices(landmarks)
    rows = np.zeros((len(slits), len(sheet.vertices)))
    for row, slit in zip(rows, slits, strict=True):
        first, second = (
            np.minimum(dijkstra(graph, indices=ends[side], min_only=True, limit=2 * NEAR * radius), 2 * NEAR * radius)
            for side in slit
        )
        row[:] = np.where(np.minimum(first, second) < NEAR * radius, second - first, 0) / radius
    return rows


def righted(
    film: Sheet, film_sides: Floats, ground: Sheet, ground_sides: Floats, points: SurfacePoints, wanted: Flags
) -> tuple[SurfacePoints, int]:
    """Bring vertices that are on the wrong side of a slit to the closest point on the right side.

    Args:
        film: what was laid, where the warp has brought it.
        film_sides: `(S, N)` its sides.
        ground: what it was laid on.
        ground_sides: `(S, M)` its sides.
        points: `(N,)` the places.
        wanted: `(N,)` which vertices may be moved.

    Returns:
        The places, and how many were changed.
    """
    corners, weights = points.corners.copy(), points.weights.copy()
    changed = 0
    for own, theirs in zip(film_sides, ground_sides, strict=True):
        for sign in (1, -1):
            astray = sign * (theirs[corners] * weights).sum(axis=1) < -ASTRAY
            rows = np.flatnonzero(wanted & (sign * own > CLEAR) & astray)
            right = np.flatnonzero(ground.usable & (sign * theirs[ground.triangles] >= 0).all(axis=1))
            if not len(right):
                continue
            for v in rows.tolist():
                facing = right[ground.normals[right] @ film.facing[v] > FACING]
                among = ground.triangles[facing if len(facing) else right]
                place, _, _ = closest_points(ground.vertices, among, film.vertices[v : v + 1])
                corners[v], weights[v] = place.corners[0], place.weights[0]
                changed += 1
    return SurfacePoints(corners, weights), changed


def _vertices(landmarks: SurfacePoints) -> Ints:
    return np.asarray(landmarks.corners[np.arange(len(landmarks)), np.argmax(landmarks.weights, axis=1)])
