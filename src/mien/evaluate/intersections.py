"""Where a posed face runs through itself: pairs of triangles that cross, and did not at rest.

Counted exactly, on the full mesh, by libigl's predicates.  What crosses at rest (an eyeball
that sits in its lid, the two sides of a seam) is no fault of a pose, so it does not count.
"""

from __future__ import annotations

import numpy as np

from mien.core import Rig
from mien.core.arrays import Floats, Ints


def crossing_pairs(vertices: Floats, triangles: Ints) -> Ints:
    """Return a number for each pair of triangles of a mesh that cross, ascending; the same pair has the same number.

    Args:
        vertices: `(N, 3)`, finite.
        triangles: `(T, 3)`.
    """
    from igl.predicates import find_self_intersections

    corners = np.ascontiguousarray(vertices, dtype=np.float64)
    found, pairs, _ = find_self_intersections(corners, np.ascontiguousarray(triangles, dtype=np.int64))
    if not found:
        return np.zeros(0, np.int64)
    pairs = np.sort(np.asarray(pairs, dtype=np.int64), axis=1)
    return np.unique(pairs[:, 0] * len(triangles) + pairs[:, 1])


def new_crossings(rig: Rig, weights: Floats, at_rest: Ints) -> Ints:
    """Return `(F,)` how many pairs of triangles cross in each pose that do not at rest.

    Args:
        rig: the character.
        weights: `(F, K)` the poses.
        at_rest: the pairs of the neutral, see `crossing_pairs`.
    """
    triangles = rig.neutral.triangles
    counts = [np.setdiff1d(crossing_pairs(rig.pose(row), triangles), at_rest).size for row in weights]
    return np.array(counts, dtype=np.int64)
