"""Frames, rings and mirror images: how the parts of an anatomy are put into metres."""

from __future__ import annotations

import numpy as np

from mien.core.anatomy import Muscle
from mien.core.arrays import Floats
from mien.geometry.surface import unit, vertex_normals
from mien.library.generic.measures import front
from mien.library.generic.places import Field

CENTIMETRE = 0.01


def mirrored_muscle(field: Field, muscle: Muscle) -> Muscle:
    """Return the right muscle for a left one."""
    flip = np.diag([-1.0, 1, 1, 1])
    other = [-1.0, 1, 1]
    return Muscle(
        muscle.name.removesuffix("left") + "right",
        muscle.fibre * other,
        muscle.weights[field.head.mirror],
        flip @ muscle.frame @ flip,
        muscle.scale,
        muscle.shortening,
        None if muscle.seam is None else muscle.seam * other,
        None if muscle.pivot is None else muscle.pivot * other,
    )


def frame_at(place: Floats, up: Floats, outward: Floats) -> Floats:
    """Return the `(4, 4)` frame at a place [cm → m] whose y-axis points about up and whose z-axis points out."""
    z = unit(outward)
    x = unit(np.cross(up, z))
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frame[:3, 3] = place * CENTIMETRE
    return frame


def outward_at(field: Field, place: Floats) -> Floats:
    """Return the `(3,)` mean normal of the skin around a place."""
    head = field.head
    near = ((head.vertices - place) ** 2).sum(axis=1) < 1.0
    near &= field.skin > 0
    near[field.group("mouth")] = False
    normals = vertex_normals(head.vertices, head.triangles)
    return unit(normals[near].sum(axis=0)) if near.any() else np.array([0.0, 0, 1])


def on_skin(field: Field, flat: Floats) -> Floats:
    """Return the `(n, 3)` points of the skin seen from the front at these `(n, 2)` places, on both sides [cm]."""
    left = front(field.measures, np.abs(flat) * [1, 0] + flat * [0, 1])
    return np.asarray(left * np.column_stack([np.sign(flat[:, 0]) + (flat[:, 0] == 0), np.ones((len(flat), 2))]))


def ring_muscle(
    field: Field, name: str, fibre: Floats, weights: Floats, frame: Floats, seam: Floats, pivot: Floats | None
) -> Muscle:
    """Return a muscle that draws the skin onto a seam, around a pivot or straight [cm → m]."""
    size = field.mouth_size if pivot is None else field.eye_size
    return Muscle(
        name,
        fibre * CENTIMETRE,
        weights,
        frame,
        size,
        seam=seam * CENTIMETRE,
        pivot=None if pivot is None else pivot * CENTIMETRE,
    )
