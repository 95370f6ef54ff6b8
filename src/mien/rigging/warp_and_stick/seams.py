"""Where a skin is near itself: between lips, lids, behind the ears."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.rigging.warp_and_stick.triangle import distance
from mien.rigging.warp_and_stick.walk import Ways, forget, reach_all

ANSWERS = 0.3
"""A vertex answers for those within this share of the reach."""


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
    boxes = _boxes(vertices, reach)
    found, answered = np.zeros(len(vertices), np.bool_), np.zeros(len(vertices), np.bool_)
    along, touched = np.full(len(vertices), np.inf), np.empty(len(vertices), np.int64)
    near, wanted = np.empty(len(vertices), np.int64), np.zeros(len(vertices), np.bool_)
    for v in range(len(vertices)):
        first, last = ways.starts[v], ways.starts[v + 1]
        if first == last or answered[v]:
            continue
        slack = 2 * ways.lengths[first:last].mean()  # an edge path zigzags over short distances
        others = near[: _around(v, vertices, ways, boxes, reach, near)]
        wanted[others] = True
        count = reach_all(ways, v, ratio * reach, along, touched, wanted, len(others))
        at_seam = False
        for w in others:
            at_seam = at_seam or along[w] > ratio * distance(vertices[v], vertices[w]) + slack
            wanted[w] = False
        for w in touched[:count]:
            if along[w] <= ANSWERS * reach:
                answered[w] = True
                found[w] = found[w] or at_seam
        forget(along, touched, count)
    return found


class Boxes(NamedTuple):
    """Vertices sorted into cubes: their order, the sorted numbers of their cubes, their cubes, and the grid's size."""

    order: Ints
    ranked: Ints
    cells: Ints
    size: Ints


@njit(cache=True, nogil=True)
def _around(v: int, vertices: Floats, ways: Ways, boxes: Boxes, reach: float, near: Ints) -> int:
    """Fill in the vertices of the skin that are near one; return how many they are."""
    order, ranked, cells, size = boxes
    count = 0
    for row in range(9):
        x, y, z = cells[v, 0] + row // 3 - 1, cells[v, 1] + row % 3 - 1, cells[v, 2]
        if x < 0 or y < 0 or x >= size[0] or y >= size[1]:
            continue
        box = (x * size[1] + y) * size[2]
        low = np.searchsorted(ranked, box + max(z - 1, 0))
        high = np.searchsorted(ranked, box + min(z + 1, size[2] - 1), side="right")
        for w in order[low:high]:
            if ways.starts[w] < ways.starts[w + 1] and distance(vertices[v], vertices[w]) < reach:
                near[count] = w
                count += 1
    return count


@njit(cache=True, nogil=True)
def _boxes(vertices: Floats, side: float) -> Boxes:
    """Sort vertices into cubes."""
    n = len(vertices)
    cells, low, size = np.empty((n, 3), np.int64), np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(3):
        cells[:, i] = np.floor((vertices[:, i] - vertices[:, i].min()) / side).astype(np.int64)
        low[i] = cells[:, i].min()
        size[i] = cells[:, i].max() - low[i] + 1
    number = (cells[:, 0] * size[1] + cells[:, 1]) * size[2] + cells[:, 2]
    order = np.argsort(number)
    return Boxes(order, number[order], cells, size)
