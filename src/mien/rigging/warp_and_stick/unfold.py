"""Turning folded triangles back by moving their corners over the ground: the inner loop of the repair.

A triangle's share is the area it has after sticking as seen against its normal before, over
its area before: 1 as it was, negative if it was turned over.  Corners are moved, a step at a
time and always on the ground, to where the shares around them fall short of what is wanted
by less (an untangling by local descent, as Freitag & Knupp 2002 do for volume meshes).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.rigging.warp_and_stick.stick import FACING, Ground
from mien.rigging.warp_and_stick.triangle import Place, distance, dot, nearest

SWEEPS = 30
"""How often each corner is tried."""
DIRECTIONS = 8
SHORTEST = 0.02
"""A corner rests when steps of this share of the edges around it no longer help."""
EVENNESS = 0.02
"""How much a place amid the neighbours counts beside the shares."""


class Fans(NamedTuple):
    """What surrounds each point of the film.

    Attributes:
        starts_of_members, members: point `p` is the vertices `members[starts_of_members[p]:starts_of_members[p + 1]]`.
        starts, triangles: the triangles around it, likewise.
        triangle_points: `(T, 3)` the points of the triangles.
        area_normals: `(T, 3)` their normals before, over their areas before.
        facing: `(P, 3)` the normals of the points before.
    """

    starts_of_members: Ints
    members: Ints
    starts: Ints
    triangles: Ints
    triangle_points: Ints
    area_normals: Floats
    facing: Floats


class Places(NamedTuple):
    """Where the points are on the ground: triangle, weights, position; and where they were laid."""

    triangle: Ints
    weights: Floats
    position: Floats
    laid: Floats


@njit(cache=True, nogil=True)
def unfold(fans: Fans, ground: Ground, places: Places, free: Flags, wanted: float, leash: float) -> None:
    """Move free points of the film until the triangles around them have the wanted share, or no step helps.

    Args:
        fans: the film.
        ground: what it lies on.
        places: where its points are; changed in place.
        free: `(P,)` which points may move.
        wanted: the share below which a triangle counts as lacking.
        leash: no point goes farther than this from where it was laid [m].
    """
    steps = np.ones(len(free))
    for _ in range(SWEEPS):
        moved = False
        for p in range(len(free)):
            if free[p] and steps[p] >= SHORTEST and _lack(p, fans, places.position, _own(places, p), wanted) > 0:
                if _try_around(p, fans, ground, places, steps[p], wanted, leash):
                    moved = True
                else:
                    steps[p] *= 0.5
                    moved = moved or steps[p] >= SHORTEST
        if not moved:
            return


@njit(cache=True, nogil=True)
def _own(places: Places, p: int) -> Place:
    return (places.position[p, 0], places.position[p, 1], places.position[p, 2])


@njit(cache=True, nogil=True)
def _lack(p: int, fans: Fans, position: Floats, place: Place, wanted: float) -> float:
    """Return by how much the shares around a point fall short if it is at a place, squared and summed."""
    total = 0.0
    for k in range(fans.starts[p], fans.starts[p + 1]):
        t = fans.triangles[k]
        i, j = 1, 2
        if fans.triangle_points[t, 1] == p:
            i, j = 2, 0
        elif fans.triangle_points[t, 2] == p:
            i, j = 0, 1
        a, b = position[fans.triangle_points[t, i]], position[fans.triangle_points[t, j]]
        n = fans.area_normals[t]
        ux, uy, uz = a[0] - place[0], a[1] - place[1], a[2] - place[2]
        vx, vy, vz = b[0] - place[0], b[1] - place[1], b[2] - place[2]
        share = 0.5 * ((uy * vz - uz * vy) * n[0] + (uz * vx - ux * vz) * n[1] + (ux * vy - uy * vx) * n[2])
        if share < wanted:
            total += min(wanted - share, 10.0) ** 2
    return total


@njit(cache=True, nogil=True)
def _try_around(p: int, fans: Fans, ground: Ground, places: Places, step: float, wanted: float, leash: float) -> bool:
    """Move a point to the best of some places around it, if one is better than its own."""
    x, y, z = _own(places, p)
    mx, my, mz, edge, count = 0.0, 0.0, 0.0, 0.0, 0
    for k in range(fans.starts[p], fans.starts[p + 1]):
        for q in fans.triangle_points[fans.triangles[k]]:
            if q != p:
                mx, my, mz = mx + places.position[q, 0], my + places.position[q, 1], mz + places.position[q, 2]
                edge += distance(places.position[q], (x, y, z))
                count += 1
    if count == 0 or edge == 0.0:
        return False
    mx, my, mz, edge = mx / count, my / count, mz / count, edge / count
    uneven = EVENNESS / edge**2
    normal = ground.normals[places.triangle[p]]
    faces = dot(normal, fans.facing[p]) > FACING
    ax, ay, az = normal[1] - normal[2], normal[2] - normal[0], normal[0] - normal[1]
    length = max(np.sqrt(ax * ax + ay * ay + az * az), 1e-300)
    ax, ay, az = ax / length, ay / length, az / length
    bx, by, bz = normal[1] * az - normal[2] * ay, normal[2] * ax - normal[0] * az, normal[0] * ay - normal[1] * ax
    best = _lack(p, fans, places.position, (x, y, z), wanted) + uneven * distance((x, y, z), (mx, my, mz)) ** 2
    best -= 1e-6 * best
    found, chosen, chosen_weights, chosen_place = False, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for d in range(DIRECTIONS + 1):
        if d == DIRECTIONS:
            goal = (x + step * (mx - x), y + step * (my - y), z + step * (mz - z))
        else:
            turn, size = 2 * np.pi * d / DIRECTIONS, step * edge
            c, s = np.cos(turn), np.sin(turn)
            goal = (x + size * (c * ax + s * bx), y + size * (c * ay + s * by), z + size * (c * az + s * bz))
        t, u, v, w = _slid(goal, places.triangle[p], ground)
        if faces and dot(ground.normals[t], fans.facing[p]) <= FACING:
            continue
        place = _at(ground, t, u, v, w)
        if distance(place, places.laid[p]) > leash:
            continue
        value = _lack(p, fans, places.position, place, wanted) + uneven * distance(place, (mx, my, mz)) ** 2
        if value < best:
            best, found, chosen, chosen_weights, chosen_place = value, True, t, (u, v, w), place
    if found:
        places.triangle[p] = chosen
        for i in range(3):
            places.weights[p, i] = chosen_weights[i]
            places.position[p, i] = chosen_place[i]
    return found


@njit(cache=True, nogil=True)
def _at(ground: Ground, t: int, u: float, v: float, w: float) -> Place:
    """Return the point of a triangle with these weights."""
    a, b, c = ground.triangles[t]
    points = ground.vertices
    return (
        u * points[a, 0] + v * points[b, 0] + w * points[c, 0],
        u * points[a, 1] + v * points[b, 1] + w * points[c, 1],
        u * points[a, 2] + v * points[b, 2] + w * points[c, 2],
    )


@njit(cache=True, nogil=True)
def _slid(goal: Place, start: int, ground: Ground) -> tuple[int, float, float, float]:
    """Slide from a triangle over its neighbours to the closest point that can be come by without moving away."""
    best, corners = start, ground.triangles
    u, v, w, away = nearest(goal, ground.vertices, corners[start, 0], corners[start, 1], corners[start, 2])
    better = True
    while better and min(u, v, w) <= 0:  # what is closest within a triangle has no closer neighbour
        better, around = False, best
        c = corners[around, 0] if u >= max(v, w) else corners[around, 1] if v >= w else corners[around, 2]
        for k in range(ground.fan_starts[c], ground.fan_starts[c + 1]):
            t = ground.fans[k]
            if t == around:
                continue
            u2, v2, w2, off = nearest(goal, ground.vertices, corners[t, 0], corners[t, 1], corners[t, 2])
            if off < away * (1 - 1e-9):
                best, u, v, w, away, better = t, u2, v2, w2, off, True
    return best, u, v, w


@njit(cache=True, nogil=True)
def containing(corners: Ints, weights: Floats, ground: Ground) -> Ints:
    """Return a triangle of the ground that each place `(corners, weights)` lies in `(P,)`."""
    found = np.zeros(len(corners), np.int64)
    for p in range(len(corners)):
        c = corners[p, np.argmax(weights[p])]
        for k in range(ground.fan_starts[c], ground.fan_starts[c + 1]):
            t = ground.fans[k]
            lies = True
            for i in range(3):
                if weights[p, i] > 0 and not (ground.triangles[t] == corners[p, i]).any():
                    lies = False
            if lies or k == ground.fan_starts[c]:
                found[p] = t
            if lies:
                break
    return found
