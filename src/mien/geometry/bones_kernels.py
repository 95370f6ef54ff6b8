"""The compiled inside of posed bones: motions of joints, and how points change with their turns.

Joints come parents first; `parents` are rows among them, -1 where the parent stays at rest.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Floats, Ints

SMALL = 1e-4
"""Below this angle [rad] quotients of sines are told by their series, exact to rounding."""


@njit(cache=True, nogil=True)
def crossing(v: Floats) -> Floats:
    """Return the `(3, 3)` matrix that takes the cross product with `v` from the left."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


@njit(cache=True, nogil=True)
def exponential(v: Floats) -> tuple[Floats, Floats]:
    """Return the rotation `R` of a rotation vector `(3,)`, and `L` with `dR Rᵀ = [L dv]×` (Rodrigues' formula)."""
    angle = np.sqrt((v * v).sum())
    if angle < SMALL:
        a, b, c = 1 - angle**2 / 6, 0.5 - angle**2 / 24, 1 / 6 - angle**2 / 120
    else:
        a, b, c = np.sin(angle) / angle, (1 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
    cross = crossing(v)
    twice = cross @ cross
    return np.eye(3) + a * cross + b * twice, np.eye(3) + b * cross + c * twice


@njit(cache=True, nogil=True)
def motions(turns: Floats, moves: Floats, places: Floats, parents: Ints) -> tuple[Floats, Floats]:
    """Return how joints are moved from rest, and how their turns change with their rotation vectors.

    Args:
        turns, moves: `(F, B, 3)` rotation vectors and displacements, in the world at rest.
        places: `(B, 3)` where the joints are at rest.
        parents: `(B,)` rows.

    Returns:
        `(F, B, 3, 4)` rigid motions in the world, and `(F, B, 3, 3)` left Jacobians.
    """
    frames, count = turns.shape[:2]
    found, changes = np.empty((frames, count, 3, 4)), np.empty((frames, count, 3, 3))
    for f in range(frames):
        for b in range(count):
            turn, changes[f, b] = exponential(turns[f, b])
            shift = places[b] + moves[f, b]
            for i in range(3):
                for j in range(3):
                    shift[i] -= turn[i, j] * places[b, j]
            if parents[b] < 0:
                found[f, b, :, :3], found[f, b, :, 3] = turn, shift
                continue
            above = found[f, parents[b]]
            for i in range(3):
                found[f, b, i, :3] = above[i, 0] * turn[0] + above[i, 1] * turn[1] + above[i, 2] * turn[2]
                found[f, b, i, 3] = (
                    above[i, 0] * shift[0] + above[i, 1] * shift[1] + above[i, 2] * shift[2] + above[i, 3]
                )
    return found, changes


@njit(cache=True, nogil=True)
def derivatives(motion: Floats, change: Floats, places: Floats, parents: Ints, shares: Floats) -> tuple[Floats, Floats]:
    """Return where points are carried, and their derivatives by each joint's turn and displacement.

    Args:
        motion, change: of one frame, see `motions`.
        places, parents: of the joints.
        shares: `(B, M, 4)` each point's place and 1 at rest, times the joint's weight there.

    Returns:
        `(M, 3)` sums over the joints, and `(2, B, 3, M, 3)` by component of the turn, and of the displacement.
    """
    count, points = shares.shape[:2]
    held = np.zeros((count, points, 4))  # what hangs on each joint: weighted places, and weights
    total = np.zeros((points, 3))
    slopes = np.zeros((2, count, 3, points, 3))
    by_turn, by_move = slopes
    for b in range(count - 1, -1, -1):
        for m in range(points):
            share = shares[b, m]
            if share[3] != 0:
                for a in range(3):
                    at = motion[b, a, 0] * share[0] + motion[b, a, 1] * share[1] + motion[b, a, 2] * share[2]
                    at += motion[b, a, 3] * share[3]
                    total[m, a] += at
                    held[b, m, a] += at
                held[b, m, 3] += share[3]
        pivot = motion[b, :, :3].copy() @ places[b] + motion[b, :, 3]
        above = np.eye(3)
        if parents[b] >= 0:
            above = motion[parents[b], :, :3].copy()
        spin = above @ change[b]
        for m in range(points):
            weight = held[b, m, 3]
            if weight == 0:
                continue
            if parents[b] >= 0:
                held[parents[b], m] += held[b, m]
            x, y, z = (
                held[b, m, 0] - weight * pivot[0],
                held[b, m, 1] - weight * pivot[1],
                held[b, m, 2] - weight * pivot[2],
            )
            for c in range(3):
                by_turn[b, c, m, 0] = spin[1, c] * z - spin[2, c] * y
                by_turn[b, c, m, 1] = spin[2, c] * x - spin[0, c] * z
                by_turn[b, c, m, 2] = spin[0, c] * y - spin[1, c] * x
                for a in range(3):
                    by_move[b, c, m, a] = above[a, c] * weight
    return total, slopes
