"""Walks along a skin, edge by edge, as far as a limit: the inner loops of sticking."""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints


class Ways(NamedTuple):
    """The edges of a skin: those of vertex `v` are rows `starts[v]` to `starts[v + 1]` of `ends` and `lengths`."""

    starts: Ints
    ends: Ints
    lengths: Floats


@njit(cache=True, nogil=True)
def arrives(
    ways: Ways, limit: float, along: Floats, touched: Ints, count: int, goals: Ints, beyond: Floats
) -> tuple[bool, int]:
    """Extend the distances of the first `count` touched vertices over the skin, but stop as soon as a goal is in reach.

    Args:
        ways: the edges.
        limit: how far to go.
        along: `(N,)` distances, infinite where not yet known; changed in place.
        touched: `(N,)` the vertices whose distance is known, in its first rows; changed in place.
        count: how many those are.
        goals: `(G,)` vertices.
        beyond: `(G,)` how much farther than each of them the way still goes.

    Returns:
        Whether one is, and how many vertices are known now.
    """
    queue = [(0.0, -1)]
    heappop(queue)
    for k in range(count):
        heappush(queue, (along[touched[k]], touched[k]))
    while len(queue) > 0:
        way, v = heappop(queue)
        if way > along[v]:
            continue
        for g in range(len(goals)):
            if goals[g] == v and way + beyond[g] <= limit:
                return True, count
        for e in range(ways.starts[v], ways.starts[v + 1]):
            w, further = ways.ends[e], way + ways.lengths[e]
            if further < along[w] and further <= limit:
                if along[w] == np.inf:
                    touched[count] = w
                    count += 1
                along[w] = further
                heappush(queue, (further, w))
    return False, count


@njit(cache=True, nogil=True)
def walk(ways: Ways, limit: float, along: Floats, touched: Ints, count: int) -> int:
    """Extend the distances of touched vertices as `arrives` does, with no goal to stop at.

    Returns:
        How many vertices are known now.
    """
    return arrives(ways, limit, along, touched, count, np.empty(0, np.int64), np.empty(0))[1]


@njit(cache=True, nogil=True)
def reach_all(ways: Ways, start: int, limit: float, along: Floats, touched: Ints, wanted: Flags, missing: int) -> int:
    """Walk from a vertex until all that are wanted are reached, or as far as the limit.

    Args:
        ways: the edges.
        start: the vertex.
        limit: how far to go.
        along: `(N,)` distances, all infinite; changed in place.  Those of wanted vertices are final.
        touched: `(N,)` in its first rows, the vertices whose distance is known; changed in place.
        wanted: `(N,)` vertices to be reached; those that are not any more; changed in place.
        missing: how many those are.

    Returns:
        How many vertices are known now.
    """
    along[start], touched[0], count = 0.0, start, 1
    queue = [(0.0, start)]
    while missing > 0 and len(queue) > 0:
        way, v = heappop(queue)
        if way > along[v]:
            continue
        if wanted[v]:
            wanted[v] = False
            missing -= 1
        for e in range(ways.starts[v], ways.starts[v + 1]):
            w, further = ways.ends[e], way + ways.lengths[e]
            if further < along[w] and further <= limit:
                if along[w] == np.inf:
                    touched[count] = w
                    count += 1
                along[w] = further
                heappush(queue, (further, w))
    return count


def within(ways: Ways, starts: Ints, goals: Ints, limits: Floats) -> Flags:
    """Tell which pairs of vertices are joined by a way no longer than a limit `(P,)`.

    Args:
        ways: the edges.
        starts, goals: `(P,)` vertices.  One walk serves all the goals of a start.
        limits: `(P,)`.
    """
    order = np.argsort(starts, kind="stable")
    ends = np.flatnonzero(np.append(np.diff(starts[order]) != 0, len(order) > 0)) + 1
    near = np.empty(len(starts), np.bool_)
    near[order] = _within(ways, starts[order], goals[order], limits[order], ends)
    return near


@njit(cache=True, nogil=True)
def _within(ways: Ways, starts: Ints, goals: Ints, limits: Floats, ends: Ints) -> Flags:
    """Do what `within` says for pairs that are grouped by their start, the groups ending at `ends`."""
    vertices = len(ways.starts) - 1
    along, touched = np.full(vertices, np.inf), np.empty(vertices, np.int64)
    wanted, near = np.zeros(vertices, np.bool_), np.empty(len(starts), np.bool_)
    first = 0
    for end in ends:
        group, missing = goals[first:end], 0
        for v in group:
            missing += not wanted[v]
            wanted[v] = True
        count = reach_all(ways, starts[first], limits[first:end].max(), along, touched, wanted, missing)
        wanted[group] = False
        for k in range(first, end):
            near[k] = along[goals[k]] <= limits[k]
        forget(along, touched, count)
        first = end
    return near


@njit(cache=True, nogil=True)
def surroundings(ways: Ways, sources: Ints, limit: float) -> tuple[Ints, Ints, Floats]:
    """Find what is near each of some vertices along the skin.

    Returns:
        `(S + 1,)` ends, the vertices `(R,)` within the limit of source `s` in rows `ends[s]` to `ends[s + 1]`, and
        how far they are from it.
    """
    along, touched = np.full(len(ways.starts) - 1, np.inf), np.empty(len(ways.starts) - 1, np.int64)
    ends, found, far = np.zeros(len(sources) + 1, np.int64), np.empty(1024, np.int64), np.empty(1024)
    for s in range(len(sources)):
        along[sources[s]], touched[0] = 0.0, sources[s]
        count = walk(ways, limit, along, touched, 1)
        ends[s + 1] = ends[s] + count
        if ends[s + 1] > len(found):
            room = 2 * ends[s + 1]
            found, far = np.append(found, np.empty(room, np.int64)), np.append(far, np.empty(room))
        found[ends[s] : ends[s + 1]] = touched[:count]
        far[ends[s] : ends[s + 1]] = along[touched[:count]]
        forget(along, touched, count)
    return ends, found[: ends[-1]], far[: ends[-1]]


@njit(cache=True, nogil=True)
def forget(along: Floats, touched: Ints, count: int) -> None:
    """Make the distances of the touched vertices unknown again."""
    for k in range(count):
        along[touched[k]] = np.inf
