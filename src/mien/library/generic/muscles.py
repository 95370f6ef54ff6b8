"""The eleven muscles chiefly responsible for expression (Faigin 1990), laid under the skin of a head.

Frontalis, corrugator, orbicularis oculi, levator palpebrae, levator labii superioris,
zygomaticus major, risorius, triangularis, depressor labii inferioris, mentalis and
orbicularis oris; those that pull on separate places are laid in parts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from mien.core.anatomy import Muscle
from mien.core.arrays import Floats
from mien.geometry.muscles import fibre_length
from mien.geometry.surface import unit
from mien.library.generic.eye_muscles import KNOTS, eye_muscles
from mien.library.generic.frames import CENTIMETRE, frame_at, mirrored_muscle, on_skin, outward_at, ring_muscle
from mien.library.generic.places import Field, Side, places, smooth


class Strand(NamedTuple):
    """A linear muscle of the left side.

    Attributes:
        name: which, without its side.
        path: places from the fixed end to the skin.
        radius: how far around the path the skin follows [cm of a human face].
        grip: shares of the path between which the skin begins to follow and follows fully.
        travel: how far the skin moves at contraction 1 [cm of a human face].
        depth: how deep the fibre lies under the skin at its fixed end and at its other end [cm].
        side: whose skin follows, of the upper lip, the lower, or both.
        ends: share of the path at which the fibre ends: those of the mouth's corner meet beside it, in the modiolus.
    """

    name: str
    path: tuple[str, ...]
    radius: float
    grip: tuple[float, float]
    travel: float
    depth: tuple[float, float] = (0.9, 0.35)
    side: Side = "both"
    ends: float = 1.0


STRANDS = (
    Strand("frontalis_medial", ("forehead_inner", "brow_inner"), 1.6, (0, 0.9), 0.85, (0.3, 0.35)),
    Strand("frontalis_lateral", ("forehead_outer", "brow_side"), 2.05, (0, 0.9), 0.8, (0.3, 0.35)),
    Strand("corrugator", ("glabella", "brow_inner", "brow_peak"), 1.35, (0, 0.45), 0.75, (0.7, 0.35)),
    Strand("levator_labii", ("infraorbital", "lip_side"), 1.45, (0.4, 0.95), 0.75, (0.1, 0.4), "upper"),
    Strand("levator_nasi", ("canthus", "wing"), 1.1, (0, 0.85), 0.85, (0.6, 0.35), "upper"),
    Strand("zygomaticus_major", ("zygion", "smile", "corner"), 1.75, (0.5, 1), 0.9, ends=0.85),
    Strand("risorius", ("masseter", "buccal", "corner"), 1.5, (0.3, 1), 1.0, (0.8, 0.4)),
    Strand("triangularis", ("jaw_side", "corner"), 1.4, (0, 0.9), 0.85, (0.1, 0.8)),
    Strand("depressor_labii", ("jaw_front", "lip_lower"), 1.5, (0, 0.9), 0.75, (0.1, 0.6), "lower"),
    Strand("mentalis", ("chin_root", "chin_side"), 1.3, (0, 0.8), 0.55, (0.9, 0.4), "lower"),
    Strand("orbicularis_oris", ("lips", "lip_bend", "corner"), 1.35, (0, 0.85), 1.15, (0.2, 0.3)),
)
"""All linear muscles that the skin follows freely; lids are laid by themselves."""

ORIS = "orbicularis_oris"
BROW = ("frontalis_medial", "frontalis_lateral", "corrugator")


def muscles(field: Field) -> tuple[Muscle, ...]:
    """Lay all muscles of a head, each side its own [m]."""
    spots = places(field.measures)
    left = [_strand(field, spots, row) for row in STRANDS]
    left += [*eye_muscles(field), _marginal(field)]
    return tuple(muscle for one in left for muscle in (one, mirrored_muscle(field, one)))


def _strand(field: Field, spots: dict[str, Floats], row: Strand) -> Muscle:
    size = field.eye_size if row.name in BROW else field.mouth_size
    path = _smooth_path(np.array([spots[name] for name in row.path]))
    weights = field.along(path, row.radius * size, row.grip, row.side)
    weights *= field.head.vertices[:, 0] > 0 if row.name == ORIS else field.left
    course = _smooth_path(path, row.ends)
    fibre = course - np.linspace(*row.depth, KNOTS)[:, None] * size * _outwards_along(field, course)
    frame = frame_at(fibre[-1], fibre[-2] - fibre[-1], outward_at(field, course[-1]))
    shortening = row.travel * size / fibre_length(fibre)
    return Muscle(f"{row.name}_left", fibre * CENTIMETRE, weights, frame, size, shortening)


def _smooth_path(knots: Floats, until: float = 1.0) -> Floats:
    """Return `KNOTS` points on the smooth curve through a few, up to this share of its length."""
    walked = np.append(0, np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1)))
    curve = make_interp_spline(walked, knots, k=min(3, len(knots) - 1))
    return np.asarray(curve(np.linspace(0, until * walked[-1], KNOTS)))


def _outwards_along(field: Field, path: Floats) -> Floats:
    first, last = outward_at(field, path[0]), outward_at(field, path[-1])
    return unit(np.linspace(first, last, KNOTS))


def _marginal(field: Field) -> Muscle:
    """Lay the left half of the marginal part of the orbicularis oris: it draws the red of the lips in onto their slit."""
    m, head, size = field.measures.mouth, field.head, field.mouth_size
    turn = np.linspace(-1, 1, 2 * KNOTS)
    slit = np.column_stack([m.half_width * turn, m.height + m.lift * np.abs(turn) ** 4])
    seam = on_skin(field, slit)
    tall = np.where(head.vertices[:, 1] > m.height, m.upper, m.lower)
    height = np.abs(head.vertices[:, 1] - np.interp(head.vertices[:, 0], slit[:, 0], slit[:, 1])) / tall
    wide = np.abs(head.vertices[:, 0]) / m.half_width
    near = head.vertices[:, 2] > seam[:, 2].min() - 1.2 * size
    weights = 0.6 * smooth((2.2 - height) / 1.6) * smooth((1.15 - wide) / 0.5) * near * field.skin * field.left
    fibre = np.concatenate([seam + [0, 0.5 * m.upper, -0.2], (seam - [0, 0.5 * m.lower, 0.2])[::-1]])
    middle = seam[len(seam) // 2]
    frame = frame_at(middle, np.array([0.0, 1, 0]), np.array([0.0, 0, 1]))
    return ring_muscle(field, "orbicularis_oris_marginal_left", fibre, weights, frame, seam, None)
