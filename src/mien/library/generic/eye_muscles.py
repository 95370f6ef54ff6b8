"""The muscles around the eyes: they close the lids over the eyeball, raise them, and gather the skin around."""

from __future__ import annotations

import numpy as np

from mien.core.anatomy import Muscle
from mien.core.arrays import Floats
from mien.geometry.muscles import across, fibre_length
from mien.library.generic.frames import CENTIMETRE, frame_at, on_skin, ring_muscle
from mien.library.generic.places import Field, smooth

KNOTS = 13
"""Points of a fibre."""
UP, OUT = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def eye_muscles(field: Field) -> list[Muscle]:
    """Lay the muscles of the left eye [m]."""
    return [*_lids(field), _levator_palpebrae(field), _orbital(field)]


def _lids(field: Field) -> list[Muscle]:
    """Lay the palpebral part of the orbicularis oculi: the upper and the lower lid close onto one seam."""
    eye, head, pivot = field.measures.eye, field.head, np.array(field.measures.eye.centre)
    seam = _lid_seam(field)
    found = []
    for lid, sign in (("upper", 1), ("lower", -1)):
        edge = field.group(f"{lid}_lid_left")
        turn = np.where(head.vertices[:, 0] > 0, sign * head.lid, 0)
        weights = _share_of_way(head.vertices, turn, seam, pivot)
        weights[edge] = 1
        fibre = np.concatenate([seam[:1], head.vertices[edge[np.argsort(head.vertices[edge, 0])]], seam[-1:]])
        frame = frame_at(pivot + [0, 0, eye.radius], UP, OUT)
        name = f"orbicularis_oculi_{lid}_left"
        found.append(ring_muscle(field, name, fibre, weights, frame, seam, pivot))
    return found


def _lid_seam(field: Field) -> Floats:
    """Return the `(S, 3)` line on which the left lids' edges meet, from the inner corner to the outer one [cm]."""
    head, pivot = field.head, np.array(field.measures.eye.centre)
    edges = np.concatenate([field.group("upper_lid_left"), field.group("lower_lid_left")])
    offset = head.vertices[edges] - pivot
    cosine, sine = np.cos(head.lid[edges]), np.sin(head.lid[edges])
    y, z = cosine * offset[:, 1] - sine * offset[:, 2], sine * offset[:, 1] + cosine * offset[:, 2]
    closed = pivot + np.stack([offset[:, 0], y, z], axis=1)
    line = np.concatenate([closed, field.measures.eye.rim(np.array([np.pi, 0.0]))])
    line = line[np.argsort(line[:, 0], kind="stable")]
    place, inverse = np.unique(np.round(line[:, 0], 6), return_inverse=True)
    total = np.zeros((len(place), 3))
    np.add.at(total, inverse, line)
    return np.asarray(total / np.bincount(inverse)[:, None])


def _share_of_way(points: Floats, turn: Floats, seam: Floats, pivot: Floats) -> Floats:
    """Return which share of their way to the seam points go when they turn by these angles about the eye."""
    weights = np.zeros(len(points))
    ids = np.flatnonzero(turn > 1e-6)
    start, end = points[ids] - pivot, across(seam, points[ids]) - pivot
    angle = np.arctan2(np.linalg.norm(np.cross(start, end), axis=1), (start * end).sum(axis=1))
    weights[ids] = np.clip(turn[ids] / np.maximum(angle, 1e-9), 0, 1)
    return weights


def _levator_palpebrae(field: Field) -> Muscle:
    """Lay the muscle that raises the upper lid, from deep in the orbit over the eyeball to the lid's edge."""
    eye, head = field.measures.eye, field.head
    radius, centre = eye.radius + eye.clearance, np.array(eye.centre)
    turn = np.linspace(np.radians(100), np.arcsin(eye.upper / radius), KNOTS)
    fibre = centre + radius * np.stack([0 * turn, np.sin(turn), np.cos(turn)], axis=1)
    lifted = (head.vertices[:, 0] > 0) * np.maximum(head.lid, 0)
    travel = 0.65 * eye.upper
    frame = frame_at(fibre[-1], UP, OUT)
    return Muscle(
        "levator_palpebrae_left",
        fibre * CENTIMETRE,
        lifted / max(float(lifted.max()), 1e-9),
        frame,
        field.eye_size,
        travel / fibre_length(fibre),
    )


def _orbital(field: Field) -> Muscle:
    """Lay the orbital part of the orbicularis oculi: it gathers the skin around the eye and lifts the cheek."""
    eye, size = field.measures.eye, field.eye_size
    centre = np.array(eye.centre)
    offset = (field.head.vertices - centre) / eye.half_width
    x, y = offset[:, 0], offset[:, 1]
    reach = np.hypot(x / 1.15, np.where(y > 0, y / 1.0, y / 1.15))
    ring = smooth((reach - 0.75) / 1.0) * smooth((2.6 - reach) / 1.2)
    share = np.where(y < 0, 0.21, 0.21 - 0.17 * smooth(y / 0.8))
    in_front = smooth(offset[:, 2] / 0.6)
    weights = ring * share * in_front * field.skin * field.left * field.off_eyes
    weights[field.head.vertices[:, 0] < 0] = 0
    turn = np.linspace(0, 2 * np.pi, 2 * KNOTS)
    out = 1.75 * eye.half_width
    around = np.column_stack([1.1 * out * np.cos(turn), out * np.sin(turn)]) + centre[:2]
    fibre = on_skin(field, around) - [0, 0, 0.3 * size]
    low = reach < 2.2
    radius = float(np.linalg.norm(offset[(weights > 0.1) & low], axis=1).mean()) * eye.half_width
    flat = np.column_stack([np.linspace(-1, 1, KNOTS) * eye.half_width, np.zeros(KNOTS)])
    seam = centre + np.column_stack([flat, np.sqrt(np.maximum(radius**2 - (flat**2).sum(axis=1), 0))])
    frame = frame_at(centre + [0, -eye.half_width, radius], UP, OUT)
    return ring_muscle(field, "orbicularis_oculi_orbital_left", fibre, weights, frame, seam, centre)
