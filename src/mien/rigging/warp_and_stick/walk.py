"""Walks along a skin, edge by edge, as far as a limit: the inner loops of sticking."""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.rigging.warp_and_stick.triangle import distance

ANSWERS = 0.3
"""A vertex answers for those within this share of the reach."""


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
def forget(along: Floats, touched: Ints, count: int) -> None:
    """Make the distances of the touched vertices unknown again."""
    for k in range(count):
        along[touched[k]] = np.inf


@njit(cache=True, nogil=True)
def seams(vertices: Floats, ways: Ways, reach: float, ratio: float) -> Flags:
    """Tell which vertices are near others that are far along the skin `(N,)`.

    On a fine mesh one vertex answers for all that are a small part of the reach from it
    along the skin, so that the cost grows as the number of vertices, not as its square.

    Args:
        vertices: `(N, 3)`.
        ways: the edges.
        reach: the largest distance that counts as near.
        ratio: how many times longer the way along the skin must be.
    """
    order, ranked, cells, size = _boxes(vertices, reach)
    found, answered = np.zeros(len(vertices), np.bool_), np.zeros(len(vertices), np.bool_)
    along, touched = np.full(len(vertices), np.inf), np.empty(len(vertices), np.int64)
    for v in range(len(vertices)):
        first, last = ways.starts[v], ways.starts[v + 1]
        if first == last or answered[v]:
            continue
        slack = 2 * ways.lengths[first:last].mean()  # an edge path zigzags over short distances
        along[v], touched[0] = 0.0, v
        count = walk(ways, ratio * reach, along, touched, 1)
        at_seam = False
        for row in range(9):
            x, y, z = cells[v, 0] + row // 3 - 1, cells[v, 1] + row % 3 - 1, cells[v, 2]
            if x < 0 or y < 0 or x >= size[0] or y >= size[1]:
                continue
            box = (x * size[1] + y) * size[2]
            low = np.searchsorted(ranked, box + max(z - 1, 0))
            high = np.searchsorted(ranked, box + min(z + 1, size[2] - 1), side="right")
            for w in order[low:high]:
                apart = distance(vertices[v], vertices[w])
                if apart < reach and along[w] > ratio * apart + slack and ways.starts[w] < ways.starts[w + 1]:
                    at_seam = True
                    break
            if at_seam:
                break
        for w in touched[:count]:
            if along[w] <= ANSWERS * reach:
                answered[w] = True
                found[w] = found[w] or at_seam
        forget(along, touched, count)
    return found


@njit(cache=True, nogil=True)
def _boxes(vertices: Floats, side: float) -> tuple[Ints, Ints, Ints, Ints]:
    """Sort vertices into cubes: their order, the sorted numbers of their cubes, their cubes, and the grid's size."""
    n = len(vertices)
    cells, low, size = np.empty((n, 3), np.int64), np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(3):
        cells[:, i] = np.floor((vertices[:, i] - vertices[:, i].min()) / side).astype(np.int64)
        low[i] = cells[:, i].min()
        size[i] = cells[:, i].max() - low[i] + 1
    number = (cells[:, 0] * size[1] + cells[:, 1]) * size[2] + cells[:, 2]
    order = np.argsort(number)
    return order, number[order], cells, size
