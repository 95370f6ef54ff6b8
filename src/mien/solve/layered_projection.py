"""The data of the layered problem, `c_l = Bᵀ M_l x̂` and `‖x̂‖²`, compiled: all that grows with the number of points.

A dense face has more extremes times points than a cache holds, so a piece of all extremes stays
there while many frames pass, and each number that is loaded serves four products.  The sums of a
frame are made in the same order however many frames there are, and wherever it stands among them:
a stream gives what the take gives, to the bit.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints

CHUNK = 768
"""Coordinates at a time."""
BLOCK = 64
"""Frames that pass together."""
TILE = 4
"""Frames and extremes whose products are made together."""


@njit(cache=True, nogil=True)
def project_frames(
    basis: Floats, borders: Ints, order: Ints, root: Floats, moved: Floats, data: Floats, energy: Floats
) -> None:
    """Set `c_l = Bᵀ M_l x̂` and `‖x̂‖²` of frames.

    Args:
        basis: `(N, D)` the extremes, points in the order of their regions, times `root`.
        borders: `(m + 1,)` where each region's coordinates begin.
        order: `(P,)` the points in that order.
        root: `(D,)` what each coordinate is multiplied by.
        moved: `(F, P, 3)`; a NaN point is left out.
        data: `(F, m, N)` filled.
        energy: `(F,)` filled.
    """
    data[:] = 0.0
    energy[:] = 0.0
    frames, rows = len(moved), len(basis)
    held = -(-min(BLOCK, max(frames, 1)) // TILE) * TILE
    shown = np.zeros((held, CHUNK))
    extremes = np.zeros((-(-rows // TILE) * TILE, CHUNK))
    for first in range(0, frames, BLOCK):
        count = min(BLOCK, frames - first)
        for r in range(len(borders) - 1):
            for begin in range(borders[r], borders[r + 1], CHUNK):
                width = min(CHUNK, borders[r + 1] - begin)
                for k in range(rows):
                    extremes[k, :width] = basis[k, begin : begin + width]
                for f in range(count):
                    gather(moved[first + f], order, root, begin, shown[f, :width])
                    energy[first + f] += square_sum(shown[f, :width])
                for f in range(0, count, TILE):
                    for k in range(0, rows, TILE):
                        tile(shown, extremes, f, k, width, data[first:, r], min(count, f + TILE), rows)


@njit(cache=True, nogil=True)
def gather(points: Floats, order: Ints, root: Floats, begin: int, out: Floats) -> None:
    """Set the weighted coordinates from `begin` on of one frame, 0 where not seen."""
    for n in range(len(out) // 3):
        at, point = 3 * n, points[order[begin // 3 + n]]
        x, y, z = point[0] * root[begin + at], point[1] * root[begin + at + 1], point[2] * root[begin + at + 2]
        unseen = np.isnan(x)
        out[at] = 0.0 if unseen else x
        out[at + 1] = 0.0 if unseen else y
        out[at + 2] = 0.0 if unseen else z


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def square_sum(x: Floats) -> float:
    """Return `‖x‖²`."""
    power = 0.0
    for i in range(len(x)):
        power += x[i] * x[i]
    return power


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def tile(shown: Floats, extremes: Floats, f: int, k: int, width: int, out: Floats, frames: int, rows: int) -> None:
    """Add the products of four frames from `f` with four extremes from `k` to `out`, those that there are."""
    x0, x1, x2, x3 = shown[f], shown[f + 1], shown[f + 2], shown[f + 3]
    b0, b1, b2, b3 = extremes[k], extremes[k + 1], extremes[k + 2], extremes[k + 3]
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
    found = ((s00, s01, s02, s03), (s10, s11, s12, s13), (s20, s21, s22, s23), (s30, s31, s32, s33))
    for i in range(f, frames):
        for j in range(k, min(k + TILE, rows)):
            out[i, j] += found[i - f][j - k]
