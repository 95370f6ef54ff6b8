"""Sticking one skin to another without tearing it (Orvalho et al., eq. 4).

The closest point in space can be on the wrong lip: lips that touch are neighbours in space
and strangers along the skin.  So the skin is laid down like a sheet of film, from the
landmarks outward: the place of a vertex is the closest point that can be reached along the
target from the place of a neighbour that already lies.  Seams come last, so that each side
of a lip or lid is reached from its own side.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np
from numba import njit

from mien.core import SurfacePoints
from mien.core.arrays import Flags, Floats, Ints
from mien.rigging.warp_and_stick.sheet import Sheet
from mien.rigging.warp_and_stick.triangle import distance, dot, nearest, point_at
from mien.rigging.warp_and_stick.walk import Ways, arrives, forget, walk

STRETCH = 3.0
"""A place is sought within this many times the way between the two neighbours before sticking …"""
DETOUR = 2.0
"""… and must be reached from the neighbour's in at most this many times the straight way."""
FACING = 0.2
"""Least cosine between the normals of a vertex and of the triangle it is put on."""

UNLAID, NEAREST, ASIDE, ADRIFT = 0, 1, 2, 3


@dataclass(frozen=True, eq=False)
class Anchors:
    """Where the laying starts.

    Attributes:
        vertices: `(A,)` vertices of the film.
        places: `A` points of the ground.
        exact: `(A,)` whether the vertex is to lie there, or only near there.
    """

    vertices: Ints
    places: SurfacePoints
    exact: Flags


@dataclass(frozen=True, eq=False)
class Stuck:
    """Where the vertices of one sheet lie on another.

    Attributes:
        points: the places.
        aside: `(N,)` where the closest point in space was on the wrong side, and another was taken.
        adrift: `(N,)` where nothing near faces the right way (the inside of a mouth on a face without one).
    """

    points: SurfacePoints
    aside: Flags
    adrift: Flags


class Film(NamedTuple):
    """What is laid: positions and normals `(N, 3)`, edges, and the order `(N,)`, larger first."""

    vertices: Floats
    facing: Floats
    ways: Ways
    order: Floats


class Ground(NamedTuple):
    """What it is laid on: a `Sheet` in plain arrays."""

    vertices: Floats
    triangles: Ints
    normals: Floats
    ways: Ways
    fan_starts: Ints
    fans: Ints


def plain(sheet: Sheet) -> Ground:
    """Return a sheet as compiled code takes it."""
    return Ground(sheet.vertices, sheet.triangles, sheet.normals, sheet.ways, sheet.fan_starts, sheet.fans)


class Lying(NamedTuple):
    """Where each vertex lies, and how it came there; at first, the closest point in space and how far that is."""

    corners: Ints
    weights: Floats
    triangle: Ints
    distance: Floats
    state: Ints


def stick(film: Sheet, order: Floats, ground: Sheet, anchors: Anchors, radius: float) -> Stuck:
    """Lay a sheet on another.

    Args:
        film: the sheet that is laid, where the warp has brought it.
        order: `(N,)` its vertices with larger values are laid first.
        ground: the sheet it is laid on.
        anchors: where to start; every connected part of the film needs one.
        radius: the size of the ground's face [m].
    """
    n = len(film.vertices)
    lying = Lying(
        corners=np.zeros((n, 3), np.int64),
        weights=np.tile([1.0, 0.0, 0.0], (n, 1)),
        triangle=np.zeros(n, np.int64),
        distance=np.zeros(n),
        state=np.zeros(n, np.int64),
    )
    sought = np.setdiff1d(film.used, anchors.vertices[anchors.exact])
    nearest, away, which = ground.ground.closest(film.vertices[sought])
    lying.corners[sought], lying.weights[sought] = nearest.corners, nearest.weights
    lying.triangle[sought], lying.distance[sought] = np.flatnonzero(ground.usable)[which], away
    _lay(
        Film(film.vertices, film.facing, film.ways, order),
        plain(ground),
        lying,
        np.array(anchors.vertices),
        np.array(anchors.places.corners),
        np.array(anchors.places.weights),
        np.array(anchors.exact),
        0.25 * radius,
    )
    return Stuck(SurfacePoints(lying.corners, lying.weights), lying.state == ASIDE, lying.state == ADRIFT)


@njit(cache=True, nogil=True)
def _lay(
    film: Film, ground: Ground, lying: Lying, anchors: Ints, corners: Ints, weights: Floats, exact: Flags, far: float
) -> None:
    """Lay the film from its anchors outward, the vertices of the highest order first."""
    along, touched = np.full(len(ground.vertices), np.inf), np.empty(len(ground.vertices), np.int64)
    anchor_of = np.full(len(film.vertices), -1, np.int64)
    queue = [(0.0, -1)]
    heappop(queue)
    for a in range(len(anchors)):
        v = anchors[a]
        if anchor_of[v] < 0 or exact[a]:
            anchor_of[v] = a
        heappush(queue, (-film.order[v], v))
    while len(queue) > 0:
        _, v = heappop(queue)
        if lying.state[v] != UNLAID:
            continue
        a = anchor_of[v]
        if a >= 0 and exact[a]:
            lying.corners[v], lying.weights[v], lying.state[v] = corners[a], weights[a], NEAREST
        else:
            u = _best_neighbour(film, lying.state, v)
            if u >= 0:
                step = distance(film.vertices[v], film.vertices[u])
                _lay_one(
                    v, film, ground, lying, lying.corners[u].copy(), lying.weights[u].copy(), step, far, along, touched
                )
            else:
                step = distance(film.vertices[v], point_at(ground.vertices, corners[a], weights[a]))
                _lay_one(v, film, ground, lying, corners[a].copy(), weights[a].copy(), step, far, along, touched)
        late = 1e100 if lying.state[v] == ADRIFT else 0.0  # what drifts must not lead the others
        for e in range(film.ways.starts[v], film.ways.starts[v + 1]):
            w = film.ways.ends[e]
            if lying.state[w] == UNLAID:
                heappush(queue, (late - film.order[w], w))


@njit(cache=True, nogil=True)
def _best_neighbour(film: Film, state: Ints, v: int) -> int:
    """Return the laid neighbour of the highest order, one that drifts only if there is no other; -1 if none."""
    best, value = -1, -np.inf
    for e in range(film.ways.starts[v], film.ways.starts[v + 1]):
        u = film.ways.ends[e]
        if state[u] != UNLAID:
            worth = film.order[u] - (1e100 if state[u] == ADRIFT else 0.0)
            if worth > value:
                best, value = u, worth
    return best


@njit(cache=True, nogil=True)
def _lay_one(
    v: int,
    film: Film,
    ground: Ground,
    lying: Lying,
    corners: Ints,
    weights: Floats,
    step: float,
    far: float,
    along: Floats,
    touched: Ints,
) -> None:
    """Lay one vertex near a place `(corners, weights)` that is `step` away on the film."""
    vertices, ways = ground.vertices, ground.ways
    origin = point_at(vertices, corners, weights)
    slack, count = 0.0, 0
    for c in corners:
        slack = max(slack, distance(vertices[c], vertices[corners[0]]), distance(vertices[c], vertices[corners[1]]))
        if along[c] == np.inf:
            touched[count] = c
            count += 1
        along[c] = distance(vertices[c], origin)
    if slack == 0.0 and ways.starts[corners[0]] < ways.starts[corners[0] + 1]:
        slack = ways.lengths[ways.starts[corners[0]] : ways.starts[corners[0] + 1]].max()
    limit = STRETCH * step + slack
    near, count = _nearest_is_near(v, film, ground, lying, origin, slack, limit, along, touched, count)
    if near:
        lying.state[v] = NEAREST
    else:
        count = walk(ways, limit, along, touched, count)
        found = _search(v, film, ground, lying, corners, weights, slack, far, along, touched[:count])
        lying.state[v] = ASIDE if found else ADRIFT
    forget(along, touched, count)


@njit(cache=True, nogil=True)
def _nearest_is_near(
    v: int,
    film: Film,
    ground: Ground,
    lying: Lying,
    origin: Floats,
    slack: float,
    limit: float,
    along: Floats,
    touched: Ints,
    count: int,
) -> tuple[bool, int]:
    """Tell whether the closest point in space faces the right way and is reached without a detour."""
    t = lying.triangle[v]
    if dot(ground.normals[t], film.facing[v]) <= FACING:
        return False, count
    found = point_at(ground.vertices, lying.corners[v], lying.weights[v])
    goals = ground.triangles[t]
    beyond = np.empty(3)
    for i in range(3):
        beyond[i] = distance(ground.vertices[goals[i]], found)
    detour = DETOUR * distance(found, origin) + slack
    return arrives(ground.ways, min(detour, limit), along, touched, count, goals, beyond)


@njit(cache=True, nogil=True)
def _search(
    v: int,
    film: Film,
    ground: Ground,
    lying: Lying,
    corners: Ints,
    weights: Floats,
    slack: float,
    far: float,
    along: Floats,
    touched: Ints,
) -> bool:
    """Put a vertex on the closest reached point that faces the right way; without one, on the closest reached."""
    query, origin = film.vertices[v], point_at(ground.vertices, corners, weights)
    limit = lying.distance[v] + far
    best, closest = limit, distance(query, origin)
    lying.corners[v], lying.weights[v] = corners, weights
    found, place = False, np.empty(3)
    for c in touched:
        off = distance(ground.vertices[c], query)
        reach = 0.0
        for e in range(ground.ways.starts[c], ground.ways.starts[c + 1]):
            reach = max(reach, ground.ways.lengths[e])
        if off - reach > best or along[c] > DETOUR * distance(ground.vertices[c], origin) + slack:
            continue
        for t in ground.fans[ground.fan_starts[c] : ground.fan_starts[c + 1]]:
            p, q, r = ground.triangles[t]
            place[0], place[1], place[2], squared = nearest(query, ground.vertices, p, q, r)
            away = np.sqrt(squared)
            faces = dot(ground.normals[t], film.facing[v]) > FACING
            if (faces and away < best) or (not found and not faces and away < closest):
                lying.corners[v], lying.weights[v] = ground.triangles[t], place
                found = found or faces
                best, closest = (away, closest) if faces else (best, away)
    return found
