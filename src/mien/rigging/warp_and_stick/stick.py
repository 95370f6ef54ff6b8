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

import numpy as np
from numba import njit

from mien.core import SurfacePoints
from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import closest_points
from mien.rigging.warp_and_stick.sheet import Sheet

STRETCH = 3.0
"""A neighbour's place is sought within this many times its distance before sticking."""
DETOUR = 2.0
"""A place must be reachable from the neighbour's in at most this many times the straight way."""
FACING = 0.2
"""Least cosine between the normals of a vertex and of the triangle it is put on."""


@dataclass(frozen=True, eq=False)
class Stuck:
    """Where the vertices of one sheet lie on another.

    Attributes:
        points: the places.
        aside: `(N,)` where the closest point in space was on the wrong side, and another was taken.
        adrift: `(N,)` where no triangle within reach faces the right way; the nearest of them was taken.
    """

    points: SurfacePoints
    aside: Flags
    adrift: Flags


def stick(film: Sheet, ground: Sheet, first: Floats, places: SurfacePoints, seeds: Ints, fixed: Flags, far: float) -> Stuck:
    """Lay a sheet on another.

    Args:
        film: the sheet that is laid, where the warp has brought it.
        ground: the sheet it is laid on.
        first: `(N,)` the order: larger values lie first.
        places: `L` points on the ground.
        seeds: `(L,)` the vertices of the film whose place each is, or is near.
        fixed: `(L,)` whether the vertex is to lie exactly there.
    """
    nearest, distance, where = closest_points(ground.vertices, ground.triangles[ground.usable], film.vertices)
    where = np.flatnonzero(ground.usable)[where]
    corners, weights, state = _flood(
        film.vertices,
        film.vertex_normals,
        film.starts,
        film.ends,
        np.clip(first, -1e10, 1e10),
        ground.vertices,
        ground.triangles,
        ground.normals,
        ground.starts,
        ground.ends,
        ground.lengths,
        ground.fan_starts,
        ground.fans,
        np.array(nearest.corners),
        np.array(nearest.weights),
        where.astype(np.int64),
        distance,
        far,
        np.array(places.corners),
        np.array(places.weights),
        seeds,
        fixed,
    )
    return Stuck(SurfacePoints(corners, weights), state == 2, state == 3)


@njit(cache=True, nogil=True)
def _flood(
    film: Floats,
    facing: Floats,
    film_starts: Ints,
    film_ends: Ints,
    first: Floats,
    vertices: Floats,
    triangles: Ints,
    normals: Floats,
    starts: Ints,
    ends: Ints,
    lengths: Floats,
    fan_starts: Ints,
    fans: Ints,
    near_corners: Ints,
    near_weights: Floats,
    near_triangle: Ints,
    near_distance: Floats,
    far: float,
    place_corners: Ints,
    place_weights: Floats,
    seeds: Ints,
    fixed: Flags,
) -> tuple[Ints, Floats, Ints]:
    """Corners, weights and state of each vertex: 0 not reached, 1 at the closest point, 2 aside, 3 adrift."""
    n = len(film)
    corners, weights, state = near_corners.copy(), near_weights.copy(), np.zeros(n, np.int64)
    along, touched = np.full(len(vertices), np.inf), np.empty(len(vertices), np.int64)
    seed_of = np.full(n, -1, np.int64)
    queue = [(0.0, -1)]
    for s in range(len(seeds)):
        v = seeds[s]
        if seed_of[v] < 0 or fixed[s]:
            seed_of[v] = s
        heappush(queue, (-first[v], v))
    while len(queue) > 0:
        _, v = heappop(queue)
        if v < 0 or state[v] > 0:
            continue
        if seed_of[v] >= 0 and fixed[seed_of[v]]:
            corners[v], weights[v], state[v] = place_corners[seed_of[v]], place_weights[seed_of[v]], 1
        else:
            best, step = -1, 0.0
            for e in range(film_starts[v], film_starts[v + 1]):
                u = film_ends[e]
                if state[u] == 0:
                    continue
                sure, better = state[u] != 3, best < 0 or first[u] > first[best]
                if best < 0 or (sure and state[best] == 3) or (better and (sure or state[best] == 3)):
                    best = u
            if best >= 0:
                from_corners, from_weights = corners[best], weights[best]
                step = np.sqrt(((film[v] - film[best]) ** 2).sum())
            else:
                from_corners, from_weights = place_corners[seed_of[v]], place_weights[seed_of[v]]
                here = _at(vertices, from_corners, from_weights)
                step = np.sqrt(((film[v] - here) ** 2).sum())
            _lay_one(
                v, film[v], facing[v], step, from_corners, from_weights,
                vertices, triangles, normals, starts, ends, lengths, fan_starts, fans,
                near_triangle, near_distance, far, corners, weights, state, along, touched,
            )  # fmt: skip
        for e in range(film_starts[v], film_starts[v + 1]):
            u = film_ends[e]
            if state[u] == 0:
                late = 1e100 if state[v] == 3 else 0.0
                heappush(queue, (late - first[u], u))
    return corners, weights, state


@njit(cache=True, nogil=True)
def _lay_one(
    v: int,
    query: Floats,
    normal: Floats,
    step: float,
    from_corners: Ints,
    from_weights: Floats,
    vertices: Floats,
    triangles: Ints,
    normals: Floats,
    starts: Ints,
    ends: Ints,
    lengths: Floats,
    fan_starts: Ints,
    fans: Ints,
    near_triangle: Ints,
    near_distance: Floats,
    far: float,
    corners: Ints,
    weights: Floats,
    state: Ints,
    along: Floats,
    touched: Ints,
) -> None:
    origin = _at(vertices, from_corners, from_weights)
    slack = 0.0
    for i in range(3):
        slack = max(slack, np.sqrt(((vertices[from_corners[i]] - vertices[from_corners[(i + 1) % 3]]) ** 2).sum()))
    if slack == 0.0:
        e = starts[from_corners[0]]
        slack = lengths[e : starts[from_corners[0] + 1]].max()
    limit = STRETCH * step + slack
    count = _walk_from(origin, from_corners, vertices, starts, ends, lengths, limit, along, touched)

    t = near_triangle[v]
    if normals[t] @ normal > FACING:
        found = _at(vertices, corners[v], weights[v])
        way = np.inf
        for i in range(3):
            c = triangles[t, i]
            way = min(way, along[c] + np.sqrt(((vertices[c] - found) ** 2).sum()))
        if way <= DETOUR * np.sqrt(((found - origin) ** 2).sum()) + slack:
            state[v] = 1
            for k in range(count):
                along[touched[k]] = np.inf
            return

    best, best_any = np.inf, ((origin - query) ** 2).sum()
    held_corners, held_weights = from_corners.copy(), from_weights.copy()
    for k in range(count):
        c = touched[k]
        if along[c] > DETOUR * np.sqrt(((vertices[c] - origin) ** 2).sum()) + slack:
            continue
        off, reach = np.sqrt(((vertices[c] - query) ** 2).sum()), lengths[starts[c] : starts[c + 1]].max()
        if off - reach > min(np.sqrt(best), near_distance[v] + far):
            continue
        for f in range(fan_starts[c], fan_starts[c + 1]):
            t = fans[f]
            a, b, d, squared = _closest_on(
                query, vertices[triangles[t, 0]], vertices[triangles[t, 1]], vertices[triangles[t, 2]]
            )
            if normals[t] @ normal > FACING and squared < best:
                best = squared
                corners[v] = triangles[t]
                weights[v, 0], weights[v, 1], weights[v, 2] = a, b, d
            if squared < best_any:
                best_any = squared
                held_corners[:] = triangles[t]
                held_weights[0], held_weights[1], held_weights[2] = a, b, d
    astray = np.sqrt(best) > near_distance[v] + far
    if astray:
        corners[v], weights[v] = held_corners, held_weights
    state[v] = 3 if astray else 2
    for k in range(count):
        along[touched[k]] = np.inf


@njit(cache=True, nogil=True)
def _at(vertices: Floats, corners: Ints, weights: Floats) -> Floats:
    return vertices[corners[0]] * weights[0] + vertices[corners[1]] * weights[1] + vertices[corners[2]] * weights[2]


@njit(cache=True, nogil=True)
def _walk_from(
    origin: Floats,
    corners: Ints,
    vertices: Floats,
    starts: Ints,
    ends: Ints,
    lengths: Floats,
    limit: float,
    along: Floats,
    touched: Ints,
) -> int:
    """Fill `along` with the ways from a point in a triangle up to a limit; say how many vertices it reached."""
    count = 0
    queue = [(0.0, -1)]
    heappop(queue)
    for i in range(3):
        c = corners[i]
        way = np.sqrt(((vertices[c] - origin) ** 2).sum())
        if way < along[c]:
            if along[c] == np.inf:
                touched[count] = c
                count += 1
            along[c] = way
            heappush(queue, (way, c))
    while len(queue) > 0:
        way, v = heappop(queue)
        if way > along[v]:
            continue
        for e in range(starts[v], starts[v + 1]):
            w, further = ends[e], way + lengths[e]
            if further < along[w] and further <= limit:
                if along[w] == np.inf:
                    touched[count] = w
                    count += 1
                along[w] = further
                heappush(queue, (further, w))
    return count


@njit(cache=True, nogil=True)
def _closest_on(q: Floats, a: Floats, b: Floats, c: Floats) -> tuple[float, float, float, float]:
    """Barycentric weights of the point of a triangle closest to `q`, and its squared distance (Ericson 2005, §5.1.5)."""
    ab, ac, ap = b - a, c - a, q - a
    d1, d2 = ab @ ap, ac @ ap
    bp = q - b
    d3, d4 = ab @ bp, ac @ bp
    cp = q - c
    d5, d6 = ab @ cp, ac @ cp
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0 and d2 <= 0:
        v, w = 0.0, 0.0
    elif d3 >= 0 and d4 <= d3:
        v, w = 1.0, 0.0
    elif d6 >= 0 and d5 <= d6:
        v, w = 0.0, 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        v, w = d1 / (d1 - d3) if d1 > d3 else 0.0, 0.0
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        v, w = 0.0, d2 / (d2 - d6) if d2 > d6 else 0.0
    elif va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        edge = (d4 - d3) + (d5 - d6)
        w = (d4 - d3) / edge if edge > 0 else 0.0
        v = 1 - w
    else:
        total = va + vb + vc
        v, w = (vb / total, vc / total) if total > 0 else (0.0, 0.0)
    off = ap - v * ab - w * ac
    return 1 - v - w, v, w, off @ off
