"""Eyes that may look anywhere: lids around a ball, rings from their edge into the skin, and the ball itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from mien.core.arrays import Floats, Ints
from mien.library.heads.clay import cast, rotation
from mien.library.modelling.half import Half
from mien.library.modelling.solids import Point, Solids


@dataclass(frozen=True)
class Eye:
    """The left eye [cm].

    Attributes:
        centre, radius: of the eyeball.
        half_width, upper, lower, tilt: the opening between the lids, and how much higher its outer corner stands.
        iris: radius of the iris.
        pupil: half width and half height of the pupil, as shares of the iris.
        clearance: how far the lids' inner edge stands off the eyeball.
        yaw, pitch: where it looks: turned to the left, and down [degrees].
        widths: distances of the rings from the lid's edge, over the opening's half width.
        points: number of vertices around the opening, a multiple of twelve.
    """

    centre: Point
    radius: float
    half_width: float
    upper: float
    lower: float
    tilt: float
    iris: float
    pupil: tuple[float, float] = (0.45, 0.45)
    clearance: float = 0.06
    yaw: float = 0.0
    pitch: float = 0.0
    widths: tuple[float, ...] = (0.0, 0.07, 0.18, 0.36, 0.62)
    points: int = 24

    @cached_property
    def frame(self) -> Floats:
        """`(3, 3)` rows: towards the outer corner, up, and out of the eye."""
        return rotation(self.pitch, self.yaw).T

    def edge(self, angles: Floats) -> Floats:
        """Return `(n, 2)` places on the lid's edge, sideways and up from the centre."""
        sine = np.sin(angles)
        height = np.where(sine > 0, self.upper, self.lower) * sine * np.abs(sine) ** 0.25
        return np.stack([self.half_width * np.cos(angles), self.tilt * np.cos(angles) + height], axis=1)


def eye_rings(half: Half, eye: Eye, solids: Solids, marks: dict[str, int]) -> Ints:
    """Lay rings from the lids' inner edge outwards, mark the corners and lids; return the outermost ring."""
    angles = np.arange(eye.points) * 2 * np.pi / eye.points
    edge, frame = eye.edge(angles), eye.frame
    depth = np.sqrt((eye.radius + eye.clearance) ** 2 - (edge**2).sum(axis=1))
    inner = half.add(np.column_stack([edge, depth]) @ frame + eye.centre, "face")
    sac = half.add(_sac(eye, edge) @ frame + eye.centre, "face")
    for name, chosen in (("upper_lid_left", np.sin(angles) > 1e-9), ("lower_lid_left", np.sin(angles) < -1e-9)):
        half.label(inner[chosen], name)
    away = np.stack([np.cos(angles), np.sin(angles)], axis=1) * eye.half_width
    flat = np.concatenate([edge + width * away for width in eye.widths])
    origins = np.column_stack([flat, np.full(len(flat), 2.5 * eye.radius + 3)]) @ frame + eye.centre
    skin = cast(solids, origins, np.broadcast_to(-frame[2], origins.shape))
    skin[:, 0] = np.maximum(skin[:, 0], 0.15)
    rings = [sac, inner, *(half.add(points, "face") for points in np.split(skin, len(eye.widths)))]
    for inside, outside in pairwise(rings):
        half.strip(inside, outside, closed=True)
    sixth = eye.points // 6
    marks |= {f"ibug_{n}": int(rings[2][sixth * k]) for n, k in ((45, 0), (44, 1), (43, 2), (42, 3), (47, 4), (46, 5))}
    return rings[-1]


def _sac(eye: Eye, edge: Floats) -> Floats:
    """Return a ring behind the lids, close to the ball, so that no gap is seen between lid and ball."""
    off = np.linalg.norm(edge, axis=1)
    reach = eye.radius + 0.2 * eye.clearance
    polar = np.arcsin(np.minimum(off / (eye.radius + eye.clearance), 1)) + 0.2
    return reach * np.column_stack([edge / off[:, None] * np.sin(polar)[:, None], np.cos(polar)])


def eyeball(half: Half, eye: Eye) -> None:
    """Add the left eyeball; its iris is a shallow bowl and its pupil may be a slot."""
    limbus = np.arcsin(eye.iris / eye.radius)
    turn = np.arange(24) * np.pi / 12
    wide, tall = eye.pupil
    hole = limbus / np.sqrt((np.cos(turn) / wide) ** 2 + (np.sin(turn) / tall) ** 2)
    out = np.array([0.9, 0.95, 0.95, 1.05, 1.5])
    polar = [0.9 * hole, hole, *(np.full(24, limbus * o) for o in out[2:]), *_rest(limbus)]
    bowl = np.concatenate([[0.94, 0.94, 0.975, 1.0, 1.0], np.ones(len(polar) - 5)]) * eye.radius
    parts = [("pupil_left",), ("iris_left",), ("iris_left",)] + [("sclera_left",)] * (len(polar) - 3)
    tip = half.add(np.array([[0, 0, bowl[0]]]) @ eye.frame + eye.centre, "eye_left", "pupil_left")
    rings = []
    for p, r, names in zip(polar, bowl, parts, strict=True):
        xyz = np.stack([np.sin(p) * np.cos(turn), np.sin(p) * np.sin(turn), np.cos(p)], axis=1)
        rings.append(half.add(r * xyz @ eye.frame + eye.centre, "eye_left", *names))
    half.fan(rings[0], int(tip[0]), closed=True)
    for inner, outer in pairwise(rings):
        half.strip(inner, outer, closed=True)
    back = half.add(np.array([[0, 0, -eye.radius]]) @ eye.frame + eye.centre, "eye_left", "sclera_left")
    half.fan(rings[-1][::-1], int(back[0]), closed=True)


def _rest(limbus: float) -> list[Floats]:
    return [np.full(24, polar) for polar in np.linspace(1.9 * limbus, 0.95 * np.pi, 7)]
