"""A mouth along any line on the skin: a slit between two lips, and the pocket behind it.

The line runs from the midline to the left corner.  A human's lies across the face; an
animal's turns around the muzzle and runs along its side.  Rings of vertices go around it
as ellipses would if the line were straightened out.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from mien.core.arrays import Floats, Ints
from mien.library.heads.clay import cast
from mien.library.modelling.half import Half
from mien.library.modelling.solids import Point, Solids


class Around(NamedTuple):
    """A ring on the skin: how far beyond the corner, above and below it runs, and how far it stands out [cm]."""

    beyond: float
    above: float
    below: float
    out: float = 0.0


class Within(NamedTuple):
    """A ring of the pocket: share of the way to the throat, and how far it widens, rises and sinks [cm]."""

    inset: float
    beyond: float
    above: float
    below: float


@dataclass(frozen=True)
class Mouth:
    """The mouth [cm].

    Attributes:
        line: points near the skin from the midline to the left corner.
        facing: which way the skin looks at them, as turns to the left [degrees].
        lips: rings from the slit to the border of the lips' own colour; the last one carries the outer landmarks.
        around: further rings into the skin.
        pocket: rings from the throat to the slit.
        throat: where the pocket ends.
        points: number of vertices around half the slit, odd.
        taper: how ring heights fall off to the corner: below 1 they are full and round, above 1 they run out flat.
    """

    line: tuple[Point, ...]
    facing: tuple[float, ...]
    lips: tuple[Around, ...]
    around: tuple[Around, ...]
    pocket: tuple[Within, ...]
    throat: Point
    points: int = 25
    taper: float = 1.0


def mouth_rings(half: Half, mouth: Mouth, solids: Solids, marks: dict[str, int]) -> Ints:
    """Lay rings from the throat over the lips into the skin, mark the lips; return the outermost, from below."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, mouth.points)
    cosine, sine = np.cos(angles), np.sin(angles)
    cosine[[0, -1]], sine[mouth.points // 2] = 0, 0
    line = _Line(mouth, solids)
    slit = line.ring(cosine, sine, Around(0.0, 0.005, 0.005), 1.0)
    throat = np.array(mouth.throat)
    pocket = []
    for row in mouth.pocket:
        place, up, along = line.at(line.length * cosine)
        rise = np.where(sine > 0, row.above, -row.below) * np.abs(sine) ** 0.7
        inside = place + row.inset * (throat - place) + row.beyond * cosine[:, None] * along
        pocket.append(inside + rise[:, None] * up)
    lips = [line.ring(cosine, sine, row, mouth.taper) for row in mouth.lips]
    skin = [line.ring(cosine, sine, row, mouth.taper if row is mouth.lips[-1] else 0.85) for row in mouth.around]
    rings = [half.add(_on_midline(points), "face", "mouth") for points in pocket]
    rings += [half.add(_on_midline(points), "face", "lips") for points in (slit, *lips)]
    for ids in rings[len(pocket) :]:
        for part, chosen in (("upper_lip", sine > 0), ("lower_lip", sine < 0), ("lip_corner_left", sine == 0)):
            half.label(ids[chosen], part)
    rings += [half.add(_on_midline(points), "face") for points in skin]
    tip = half.add(throat[None], "face", "mouth")
    half.fan(rings[0], int(tip[0]), closed=False)
    for inner, outer in pairwise(rings):
        half.strip(inner, outer, closed=False)
    _mark(marks, rings[len(pocket)], rings[len(pocket) + len(lips)], angles)
    return rings[-1]


def _mark(marks: dict[str, int], inner: Ints, outer: Ints, angles: Floats) -> None:
    """Name the lips' landmarks at these angles around the mouth [degrees]."""
    for ring, names in ((outer, OUTER), (inner, INNER)):
        for number, degrees in names.items():
            marks[f"ibug_{number}"] = int(ring[np.argmin(np.abs(angles - np.radians(degrees)))])


OUTER = {51: 90, 52: 73, 53: 48, 54: 0, 55: -46, 56: -63, 57: -90}
"""Angles whose cosines are the shares of half the mouth at which human lips have these landmarks [degrees]."""
INNER = {62: 90, 63: 62, 64: 0, 65: -62, 66: -90}


def _on_midline(points: Floats) -> Floats:
    points[[0, -1], 0] = 0
    return points


class _Line:
    """The mouth's line by its length from the midline, running on straight beyond the corner."""

    def __init__(self, mouth: Mouth, solids: Solids) -> None:
        self.solids = solids
        knots = np.array(mouth.line)
        facing = np.array(mouth.facing)
        coarse = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
        fine = np.linspace(0, coarse[-1], 60)
        # mirrored knots make the line cross the midline smoothly
        both = np.concatenate([-coarse[:0:-1], coarse])
        path = CubicSpline(both, np.concatenate([knots[:0:-1] * [-1, 1, 1], knots]))(fine)
        turn = CubicSpline(both, np.concatenate([-facing[:0:-1], facing]))(fine)
        out = _looking(turn)
        skin = cast(solids, path + 12 * out, -out)
        self.s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(skin, axis=0), axis=1))])
        self.length = self.s[-1]
        self.skin, self.turn = CubicSpline(self.s, skin), CubicSpline(self.s, turn)

    def at(self, s: Floats) -> tuple[Floats, Floats, Floats]:
        """Return place, up and forward along the line at these lengths."""
        inside = np.minimum(s, self.length)
        along = self.skin(inside, 1)
        along[inside < 1e-9] = [1, 0, 0]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        up = np.cross(_looking(self.turn(inside)), along)
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        return self.skin(inside) + (s - inside)[:, None] * along, up, along

    def ring(self, cosine: Floats, sine: Floats, row: Around, taper: float) -> Floats:
        """Return a ring's points on the skin."""
        s = (self.length + row.beyond) * cosine
        place, up, _ = self.at(s)
        rise = np.where(sine > 0, row.above, -row.below) * np.abs(sine) ** taper
        out = _looking(self.turn(np.minimum(s, self.length)))
        hit = cast(self.solids, place + rise[:, None] * up + 6 * out, -out)
        return np.asarray(hit + (row.out * np.abs(sine) ** 0.6)[:, None] * out)


def _looking(turn: Floats) -> Floats:
    angle = np.radians(turn)
    return np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
