"""The data of the layered problem, `c_l = Bᵀ M_l x̂` and `‖x̂‖²`, compiled: all that grows with the number of points.

A dense face has more extremes times points than a cache holds, so a window of points of all extremes
stays there while many frames pass, a frame is read once, and each number that is loaded serves four
products.  The sums of a frame are made in the same order however many frames there are, and wherever
it stands among them: a stream gives what the take gives, to the bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints

WINDOW = 512
"""Points at a time."""
PASSING = 256
"""Frames that pass a window before the next window is loaded."""
GROUP = 16
"""Frames whose window is laid out at a time."""
TILE = 4
"""Frames and extremes whose products are made together."""


class Layout(NamedTuple):
    """Points in the order in which they are added up: window by window, in each region by region.

    Attributes:
        order: `(P,)` the points.
        pieces: `(Q, 3)` region, and where it begins and ends in that order; none reaches across a window.
        root: `(P,)` what each point, in that order, is multiplied by.
        basis: `(N', 3 P)` the extremes in that order, multiplied likewise; `N'` is a multiple of `TILE`.
    """

    order: Ints
    pieces: Ints
    root: Floats
    basis: Floats


def lay_out(basis: Floats, regions: Ints, importance: Floats) -> Layout:
    """Return the layout of a face.

    Args:
        basis: `(N, P, 3)` extremes.
        regions: `(P,)` the region of each point.
        importance: `(P,)` how much each point counts; sums become means over the points.
    """
    count = len(regions)
    window = np.arange(count) // WINDOW
    order = np.lexsort((regions, window))
    changes = np.flatnonzero((np.diff(regions[order]) != 0) | (np.diff(window) != 0)) + 1
    begins = np.concatenate([[0], changes, [count]]).astype(np.int64)
    pieces = np.stack([regions[order][begins[:-1]], begins[:-1], begins[1:]], axis=1)
    root = np.sqrt(importance / count)[order]
    padded = np.zeros((-(-len(basis) // TILE) * TILE, 3 * count))
    padded[: len(basis)] = (basis[:, order] * root[:, None]).reshape(len(basis), -1)
    return Layout(order, np.ascontiguousarray(pieces), root, padded)


@njit(cache=True, nogil=True)
def project_frames(layout: Layout, moved: Floats, data: Floats, energy: Floats, whole: Flags) -> None:
    """Set `c_l = Bᵀ M_l x̂` and `‖x̂‖²` of frames.

    Args:
        layout: of the face.
        moved: `(F, P, 3)`; a NaN point is left out.
        data: `(F, m, N)` filled.
        energy: `(F,)` filled.
        whole: `(F,)` filled with whether every point is seen.
    """
    data[:] = 0.0
    energy[:] = 0.0
    whole[:] = True
    pieces, shown = layout.pieces, np.zeros((GROUP, 3 * WINDOW))
    for passing in range(0, len(moved), PASSING):
        last = 0
        while last < len(pieces):
            first = last
            begin = pieces[first, 1]
            while last < len(pieces) and pieces[last, 2] <= begin - begin % WINDOW + WINDOW:
                last += 1
            for f in range(passing, min(len(moved), passing + PASSING), GROUP):
                end = min(f + GROUP, passing + PASSING, len(moved))
                gather(layout, begin, pieces[last - 1, 2], moved[f:end], shown, energy[f:end], whole[f:end])
                for piece in range(first, last):
                    add_piece(layout, piece, begin, shown, data[f:end])


@njit(cache=True, nogil=True)
def gather(layout: Layout, begin: int, end: int, moved: Floats, shown: Floats, energy: Floats, whole: Flags) -> None:
    """Lay out some frames' points `begin … end`, 0 where not seen, and add to their energies."""
    order, root = layout.order[begin:end], layout.root[begin:end]
    for f in range(len(moved)):
        points, row = moved[f], shown[f, : 3 * len(order)]
        for n in range(len(order)):
            p, w = order[n], root[n]
            row[3 * n] = w * points[p, 0]
            row[3 * n + 1] = w * points[p, 1]
            row[3 * n + 2] = w * points[p, 2]
        power = square_sum(row)
        if np.isnan(power):
            whole[f] = False
            for n in range(len(order)):
                if np.isnan(row[3 * n]):
                    row[3 * n : 3 * n + 3] = 0.0
            power = square_sum(row)
        energy[f] += power


@njit(cache=True, nogil=True)
def add_piece(layout: Layout, piece: int, begin: int, shown: Floats, data: Floats) -> None:
    """Add the products of a piece of all extremes with some frames, of which `shown` has the points from `begin` on."""
    region, a, b = layout.pieces[piece]
    for f in range(0, len(data), TILE):
        for k in range(0, len(layout.basis), TILE):
            found = tile(shown, f, 3 * (a - begin), layout.basis, k, 3 * a, 3 * (b - a))
            for i in range(min(TILE, len(data) - f)):
                for j in range(min(TILE, data.shape[2] - k)):
                    data[f + i, region, k + j] += found[i][j]


Row = tuple[float, float, float, float]


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def square_sum(x: Floats) -> float:
    """Return `‖x‖²`."""
    power = 0.0
    for i in range(len(x)):
        power += x[i] * x[i]
    return power


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def tile(x: Floats, f: int, x_begin: int, b: Floats, k: int, b_begin: int, width: int) -> tuple[Row, Row, Row, Row]:
    """Return the products of four rows of `x` from `f` on with four of `b` from `k` on, `width` numbers of each."""
    x_end, b_end = x_begin + width, b_begin + width
    x0, x1, x2, x3 = x[f, x_begin:x_end], x[f + 1, x_begin:x_end], x[f + 2, x_begin:x_end], x[f + 3, x_begin:x_end]
    b0, b1, b2, b3 = b[k, b_begin:b_end], b[k + 1, b_begin:b_end], b[k + 2, b_begin:b_end], b[k + 3, b_begin:b_end]
    s00, s01, s02, s03, s10, s11, s12, s13 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s20, s21, s22, s23, s30, s31, s32, s33 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(width):
        s00 += x0[i] * b0[i]
        s01 += x0[i] * b1[i]
        s02 += x0[i] * b2[i]
        s03 += x0[i] * b3[i]
        s10 += x1[i] * b0[i]
        s11 += x1[i] * b1[i]
        s12 += x1[i] * b2[i]
        s13 += x1[i] * b3[i]
        s20 += x2[i] * b0[i]
        s21 += x2[i] * b1[i]
        s22 += x2[i] * b2[i]
        s23 += x2[i] * b3[i]
        s30 += x3[i] * b0[i]
        s31 += x3[i] * b1[i]
        s32 += x3[i] * b2[i]
        s33 += x3[i] * b3[i]
    return (s00, s01, s02, s03), (s10, s11, s12, s13), (s20, s21, s22, s23), (s30, s31, s32, s33)
