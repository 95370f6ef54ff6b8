"""Where on a face muscles attach, and how far over the skin their pull is felt.

Everything is told from the measures of a head, on the subject's left, in centimetres,
so that the same muscles fit every head of the kit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mien.core.arrays import Floats, Ints
from mien.geometry.muscles import fibre_length, on_polyline
from mien.library.generic.measures import Measures, front
from mien.library.generic.proportions import GENERIC
from mien.library.generic.skin import side_of_slit
from mien.library.modelling.half import Head

Side = Literal["both", "upper", "lower"]
"""Which lip's skin follows: muscles of one lip must not drag the other across the slit."""

FAINT = 0.02
"""Weights below this are left out, so that every part of the face follows few muscles."""
DEPTH_SHARE = 0.6
"""Distances in depth count for less: the skin in front of a muscle follows it."""
HALVES = 0.4
"""Within this share of the mouth's half width from the midline, left and right muscles share the skin."""


def places(m: Measures) -> dict[str, Floats]:
    """Return named places on the left of the skin [cm]."""
    mouth, eye, wide = m.mouth, m.eye, m.mouth.half_width
    chin, (inner, peak, outer, _) = m.places["chin_tip"], m.brow
    under = eye.centre[1] - eye.lower
    xy = {
        "corner": (wide, mouth.height + mouth.lift),
        "lips": (0.0, mouth.height),
        "lip_bend": (0.6 * wide, mouth.height + 0.13 * mouth.lift),
        "lip_upper": (0.22 * wide, mouth.height + 0.6 * mouth.upper),
        "lip_lower": (0.22 * wide, mouth.height - 0.6 * mouth.lower),
        "lip_side": (0.6 * wide, 0.55 * mouth.height + 0.45 * m.places["subnasale"][1]),
        "cheek": (1.5 * wide, 0.62 * mouth.height + 0.38 * under),
        "buccal": (1.45 * wide, mouth.height),
        "smile": (1.7 * wide, 0.55 * mouth.height + 0.45 * under),
        "cheekbone": (eye.centre[0] + 0.3, under - 1.3 * eye.half_width),
        "malar": (eye.centre[0] + 1.05 * eye.half_width, under - 1.6 * eye.half_width),
        "infraorbital": (0.85 * eye.centre[0], under - 0.45 * eye.half_width),
        "canthus": (0.45 * eye.centre[0], eye.centre[1] + 0.1 * eye.half_width),
        "wing": m.places["wing"][:2],
        "chin": chin[:2],
        "chin_side": (0.3 * wide, 0.75 * chin[1] + 0.25 * mouth.height),
        "chin_root": (0.3 * wide, 0.3 * chin[1] + 0.7 * (mouth.height - mouth.lower)),
        "jaw_front": (0.7 * wide, 0.95 * chin[1] + 0.05 * mouth.height),
        "jaw_side": (1.25 * wide, 0.85 * chin[1] + 0.15 * mouth.height),
        "glabella": (0.7 * inner[0], inner[1] - 0.9 * eye.half_width),
        "brow_inner": inner,
        "brow_peak": peak,
        "brow_side": (0.3 * peak[0] + 0.7 * outer[0], 0.4 * peak[1] + 0.6 * outer[1]),
        "brow_outer": outer,
        "forehead_inner": (inner[0], inner[1] + 2.9 * eye.half_width),
        "forehead_outer": (outer[0] - 0.3 * eye.half_width, peak[1] + 2.5 * eye.half_width),
    }
    found = dict(zip(xy, front(m, np.array(list(xy.values()))), strict=True))
    zygion, gonion = np.array(m.places["zygion_left"]), np.array(m.places["gonion_left"])
    found |= {"zygion": zygion, "masseter": 0.5 * (gonion + found["corner"] * [1.25, 1, 0.75])}
    return found


@dataclass(frozen=True, eq=False)
class Field:
    """Smooth weights over one head.

    Attributes:
        measures, head: whose.
        skin: `(N,)` 1 on everything that muscles move, 0 on eyes, teeth and tongue.
        above: `(N,)` from -1 below the mouth to 1 above it, 0 beside its corners.
    """

    measures: Measures
    head: Head
    skin: Floats
    above: Floats

    @classmethod
    def of(cls, measures: Measures, head: Head) -> Field:
        """Work out what all weights of a head share."""
        skin = np.ones(len(head.vertices))
        for part in ("eye_left", "eye_right", "teeth", "tongue"):
            skin[head.groups.get(part, np.zeros(0, np.int64))] = 0
        return cls(measures, head, skin, side_of_slit(measures, head.vertices))

    @property
    def mouth_size(self) -> float:
        """Size of the mouth as a share of the generic one, that radii are told for."""
        return self.measures.mouth.half_width / GENERIC.mouth.half_width

    @property
    def eye_size(self) -> float:
        """Size of the eyes as a share of the generic ones, that radii are told for."""
        return self.measures.eye.half_width / GENERIC.eye.half_width

    def along(self, path: Floats, radius: float, grip: tuple[float, float], side: Side = "both") -> Floats:
        """Return how fully the skin follows a path: more towards its end, less away from it.

        Args:
            path: `(P, 3)` on the skin, from the fixed end [cm].
            radius: distance at which the weight has fallen to 0.37 [cm].
            grip: shares of the path between which the weight grows from nothing to full.
            side: whose skin follows.
        """
        squash = np.array([1, 1, DEPTH_SHARE])
        segment, share, nearest = on_polyline(path * squash, self.head.vertices * squash)
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        walked = (np.append(0, np.cumsum(steps))[segment] + share * steps[segment]) / fibre_length(path)
        offset = (self.head.vertices * squash - nearest) / radius
        held = np.sin(np.pi / 2 * np.clip((walked - grip[0]) / (grip[1] - grip[0]), 0, 1))
        return self._kept(np.exp(-(offset**2).sum(axis=1)) * held, side)

    def around(self, place: Floats, radii: ArrayLike, side: Side = "both") -> Floats:
        """Return 1 at a place, fading to 0.37 at these distances along x, y and z [cm]."""
        offset = (self.head.vertices - place) / np.asarray(radii)
        return self._kept(np.exp(-(offset**2).sum(axis=1)), side)

    def _kept(self, weights: Floats, side: Side) -> Floats:
        clear = np.maximum(weights - FAINT, 0) / (1 - FAINT)
        if side != "both":
            clear *= smooth(self.above if side == "upper" else -self.above)
        return np.asarray(clear * self.skin * self.off_eyes)

    @property
    def off_eyes(self) -> Floats:
        """`(N,)` 0 between the lids and at their edges, 1 away from the eyes: only the lids' own muscles move lids."""
        eye, points = self.measures.eye, self.head.vertices
        x = (np.abs(points[:, 0]) - eye.centre[0]) / eye.half_width
        y = points[:, 1] - eye.centre[1] - eye.tilt * x
        reach = np.hypot(x, y / np.where(y > 0, eye.upper, eye.lower))
        return np.maximum(smooth((reach - 1) / 0.7), points[:, 2] < eye.centre[2])

    @property
    def left(self) -> Floats:
        """`(N,)` the left muscles' share of the skin: with its mirror image it sums to 1."""
        wide = HALVES * self.measures.mouth.half_width
        return smooth((self.head.vertices[:, 0] / wide + 1) / 2)

    def group(self, name: str) -> Ints:
        """Return the vertices of a group, none if the head lacks it."""
        return self.head.groups.get(name, np.zeros(0, np.int64))


def smooth(t: Floats) -> Floats:
    """Return 0 below 0, 1 above 1, and the cubic step between."""
    t = np.clip(t, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))
