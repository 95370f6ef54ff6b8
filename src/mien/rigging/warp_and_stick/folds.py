"""Folds of a stuck skin, and turning them back (Orvalho et al., §4.3, leave this open).

A triangle is folded if sticking turned it over.  The corners of folded triangles slide over
the ground until they are not; where that does not suffice, more is asked of the triangles
around, so that those give way too.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from mien.core import SurfacePoints
from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import triangle_normals
from mien.rigging.warp_and_stick.sheet import Sheet
from mien.rigging.warp_and_stick.stick import plain
from mien.rigging.warp_and_stick.unfold import Fans, Places, containing, unfold

LEASH = 0.15
"""No point slides farther than this share of the face's radius: a fold is better than a point on another feature."""
STAGES = ((1, 0.05), (2, 0.2), (3, 0.4), (2, 0.1), (4, 0.3), (3, 0.1))
"""How many rings around the folds may move, and the share of its area every triangle there is to keep, in turn."""


def folded(before: Floats, after: Floats, triangles: Ints) -> Flags:
    """Return which triangles were turned over `(T,)`."""
    turned = (triangle_normals(before, triangles) * triangle_normals(after, triangles)).sum(axis=1)
    return np.asarray(turned < 0)


def smooth_out(
    film: Sheet, twins: Ints, ground: Sheet, points: SurfacePoints, held: Ints, radius: float
) -> SurfacePoints:
    """Turn back the folds of a stuck sheet.

    Args:
        film: the sheet, where the warp has brought it.
        twins: `(P, 2)` vertices of it that are one point.
        ground: the sheet it lies on.
        points: `(N,)` where its vertices are on it.
        held: vertices that stay: landmarks.
        radius: the size of the ground's face [m].

    Returns:
        The same, with no more folds than before.
    """
    point, fans = _fans(film, twins)
    first = fans.members[fans.starts_of_members[:-1]]
    rock = plain(ground)
    at = points.take(first)
    position = np.ascontiguousarray(at.of(ground.vertices))
    places = Places(containing(at.corners, at.weights, rock), np.zeros((len(first), 3)), position.copy(), position)
    held_points = point[held]
    best, folds = points, folded(film.vertices, points.of(ground.vertices), film.triangles)
    fewest = int(folds.sum())
    for rings, wanted in STAGES:
        if not folds.any():
            break
        free = _around(fans.triangle_points, folds, rings, len(first))
        free[held_points] = False
        unfold(fans, rock, places, free, wanted, LEASH * radius)
        moved = (places.position != position).any(axis=1)[point][:, None]
        corners = np.where(moved, ground.triangles[places.triangle[point]], points.corners)
        trial = SurfacePoints(corners, np.where(moved, places.weights[point], points.weights))
        folds = folded(film.vertices, trial.of(ground.vertices), film.triangles)
        if folds.sum() < fewest:
            best, fewest = trial, int(folds.sum())
    return best


def _around(triangles: Ints, chosen: Flags, rings: int, count: int) -> Flags:
    """Return the points of some triangles and of so many rings around them `(P,)`."""
    reached = np.zeros(count, dtype=np.bool_)
    reached[triangles[chosen]] = True
    for _ in range(rings):
        reached[triangles[reached[triangles].any(axis=1)]] = True
    return reached


def _fans(film: Sheet, twins: Ints) -> tuple[Ints, Fans]:
    """Return which point each vertex is, and what surrounds the points."""
    n = len(film.vertices)
    joined = sparse.csr_matrix((np.ones(len(twins)), (twins[:, 0], twins[:, 1])), shape=(n, n))
    count, point = connected_components(joined, directed=False)
    members = np.argsort(point, kind="stable")
    corners = point[film.triangles].astype(np.int64)
    order = np.argsort(corners.ravel(), kind="stable")
    a, b, c = (film.vertices[film.triangles[:, i]] for i in range(3))
    doubled = np.cross(b - a, c - a)
    power = (doubled**2).sum(axis=1, keepdims=True)
    return point.astype(np.int64), Fans(
        np.searchsorted(point[members], np.arange(count + 1)),
        members,
        np.searchsorted(corners.ravel()[order], np.arange(count + 1)),
        order // 3,
        corners,
        np.divide(2 * doubled, power, out=np.zeros_like(doubled), where=power > 0),
        film.facing[members[np.searchsorted(point[members], np.arange(count))]],
    )
