"""What belongs into a mouth kept inside the head: teeth must not show through closed lips."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from mien.core.arrays import Floats, Ints
from mien.core.units import human_centimetre
from mien.geometry.surface import Searchable, exposed, triangle_normals, unit, vertex_normals
from mien.rigging.dense import DenseFit

CLEAR_CM = 0.1
"""Teeth and tongue stay this far behind the skin, on a human face."""
NEAR = 1.0
"""Skin this far around them, in sizes of theirs, is looked at."""
SHRINK = 0.98
"""They shrink by this factor with every step back."""
ROUNDS = 40


def tucked_in(parts: list[Floats], fit: DenseFit) -> tuple[list[Floats], float]:
    """Draw parts of the mouth back together, and make them smaller, until none stands out of the skin.

    Args:
        parts: the places `(P, 3)` of each.
        fit: the correspondence to the face they are for.

    Returns:
        The places, and the factor by which they shrank.
    """
    if not parts:
        return parts, 1.0
    points, shrunk = np.concatenate(parts), 1.0
    triangles, normals, ahead = _skin_around(points, fit)
    skin = Searchable(fit.target.vertices, triangles)
    clear = CLEAR_CM * human_centimetre(fit.warp(fit.warp.centres))
    for _ in range(ROUNDS if len(triangles) else 0):
        nearest, _, which = skin.closest(points)
        out = ((points - nearest.of(fit.target.vertices)) * normals[which]).sum(axis=1)
        excess = float(out.max()) + clear
        if excess <= 0:
            break
        centre = points.mean(axis=0)
        points = centre + SHRINK * (points - centre) - 0.5 * excess * ahead
        shrunk *= SHRINK
    return np.split(points, np.cumsum([len(part) for part in parts])[:-1]), shrunk


def _skin_around(points: Floats, fit: DenseFit) -> tuple[Ints, Floats, Floats]:
    """Return the triangles of the outer skin near some points, their normals, and where the face looks."""
    mesh, skin = fit.target, fit.target_skin
    normals = vertex_normals(mesh.vertices, mesh.triangles)
    own = np.flatnonzero(skin)
    landmarks = fit.warp(fit.warp.centres)
    ahead = unit(normals[own][cKDTree(mesh.vertices[own]).query(landmarks)[1]].mean(axis=0))
    low, high = points.min(axis=0), points.max(axis=0)
    reach = NEAR * float((high - low).max())
    around = own[((mesh.vertices[own] > low - reach) & (mesh.vertices[own] < high + reach)).all(axis=1)]
    seen = np.zeros(len(skin), np.bool_)
    seen[around] = exposed(mesh, mesh.vertices[around], normals[around], ahead)
    triangles = mesh.triangles[seen[mesh.triangles].all(axis=1)]
    return triangles, triangle_normals(mesh.vertices, triangles), ahead
