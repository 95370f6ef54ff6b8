"""A head modelled by code: skin, lids, lips, eyeballs, teeth and brows from one table of measures.

The skin is where rays first meet the blended solids.  Closed rings of vertices run
around each eye and the mouth, so that lids and lips slide along their own edges; the
rest of the head is the spherical Delaunay triangulation of a polar grid around them.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from mien.core.arrays import Floats, Ints
from mien.library.features import brow, eye_rings, eyeball, mouth_rings, teeth
from mien.library.half import Half, Head, mirrored
from mien.library.measures import LID_RINGS, Measures
from mien.library.solids import first_hit


def build(measures: Measures) -> Head:
    """Model the head that these measures describe."""
    half = Half()
    borders = [eye_rings(half, measures), mouth_rings(half, measures)]
    _shell(half, measures, borders)
    eyeball(half, measures.eye)
    brow(half, measures)
    teeth(half, measures)
    return mirrored(half)


def _shell(half: Half, m: Measures, borders: list[Ints]) -> None:
    """Cover the rest of the head from the rings' borders to the neck."""
    known = np.concatenate(half.vertices)
    turn = np.linspace(0, np.pi, 17)
    ring = np.stack([np.sin(turn), np.zeros(17), np.cos(turn)], axis=1)
    ring[[0, -1], 0] = 0
    level = np.array([0.0, m.neck, 0.3 * m.centre[2] - 2])
    neck = half.add(first_hit(m.solids, level + 15 * ring, -ring), "face", "neck")
    taken = np.concatenate([known[np.concatenate(borders)], half.vertices[-1]]) - m.centre
    taken /= np.linalg.norm(taken, axis=1, keepdims=True)
    rays, points = _free(_polar_grid(*m.spacing), taken, m)
    grid = half.add(points, "face")
    ids = np.concatenate([*borders, neck, grid])
    rim = np.concatenate([np.full(len(b), i) for i, b in enumerate([*borders, neck])] + [np.full(len(grid), -1)])
    triangles = ConvexHull(np.concatenate([taken, rays])).simplices
    label = rim[triangles]
    in_hole = (label[:, 0] >= 0) & (label == label[:, :1]).all(axis=1)
    points = np.concatenate(half.vertices)[ids]
    on_midline = (points[triangles][..., 0] == 0).all(axis=1)
    triangles = triangles[~in_hole & ~on_midline]
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = (normal * (corners.mean(axis=1) - m.centre)).sum(axis=1) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    half.triangles.append(ids[triangles])


def _polar_grid(near: float, far: float) -> Floats:
    """Return directions on rings around the nose, widening towards the back of the head."""
    rings, polar = [np.array([[0.0, 0.0, 1.0]])], 0.0
    while True:
        step = np.radians(near + (far - near) * (polar / np.pi) ** 1.2)
        polar += step
        if polar > np.pi - step / 2:
            return np.concatenate([*rings, [[0.0, 0.0, -1.0]]])
        turn = np.linspace(0, np.pi, max(3, round(np.pi * np.sin(polar) / step) + 1))
        sine = np.sin(turn)
        sine[[0, -1]] = 0
        rings.append(np.stack([np.sin(polar) * sine, np.sin(polar) * np.cos(turn), 0 * turn + np.cos(polar)], axis=1))


def _free(rays: Floats, taken: Floats, m: Measures) -> tuple[Floats, Floats]:
    """Keep the directions that are clear of the rings and of what they enclose, with their points on the skin."""
    angle = np.degrees(np.arccos(np.clip(rays[:, 2], -1, 1)))
    room = np.radians(0.6 * (m.spacing[0] + (m.spacing[1] - m.spacing[0]) * (angle / 180) ** 1.2))
    clear = (rays @ taken.T).max(axis=1) < np.cos(room)
    rays = rays[clear]
    points = first_hit(m.solids, np.array(m.centre) + 20 * rays, -rays)
    eye, mouth = m.eye, m.mouth
    wide = eye.half_width * (1 + LID_RINGS[-1])
    x, y = points[:, 0] - eye.centre[0], points[:, 1] - eye.centre[1]
    tall = eye.half_width * LID_RINGS[-1] + np.where(y > 0, eye.upper, eye.lower)
    in_eye = (x / wide) ** 2 + (y / tall) ** 2 < 1
    x, y = points[:, 0], points[:, 1] - mouth.height
    tall = np.where(y > 0, 1.6 * mouth.upper, 1.7 * mouth.lower) + 0.35
    in_mouth = (x / (mouth.half_width + 0.75)) ** 2 + (y / tall) ** 2 < 1
    kept = ~((in_eye | in_mouth) & (points[:, 2] > 0)) & (points[:, 1] > m.neck + 0.8)
    return rays[kept], points[kept]
