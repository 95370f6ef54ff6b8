"""The ear and the nostril: rings that fold over themselves, which rays from inside the head cannot find."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mien.core.arrays import Floats, Ints
from mien.library.generic.measures import Ear, Measures, Nostril
from mien.library.modelling.half import Half
from mien.library.modelling.solids import first_hit


class Fold(NamedTuple):
    """A ring of the ear: its share of the outline, and how far it stands off [shares of the ear's width].

    `off` is from the ear's plane, where the ear is free; `lift` from the cheek, where it is not.
    """

    share: float
    off: float
    lift: float


FOLDS = (
    Fold(1.0, -0.09, 0.0),
    Fold(0.985, 0.06, 0.01),
    Fold(0.82, -0.04, 0.06),
    Fold(0.64, 0.05, 0.13),
    Fold(0.38, -0.17, -0.06),
)
"""From the back of the helix over its rim, the scapha and the antihelix (in front, the tragus) into the concha."""


NOSTRIL_RINGS = ((1.45, 0.0), (1.0, 0.12), (0.75, 0.75))
"""Size of each ring over the nostril's, and how deep it lies over the nostril's depth."""


def ear_rings(half: Half, m: Measures, ear: Ear) -> Ints:
    """Lay rings from the root of the ear over its rim into the concha; return the outermost."""
    turn = -np.arange(ear.points) * 2 * np.pi / ear.points
    outline = _ear_outline(ear, turn)
    free = _smooth(0.55 - 0.8 * np.cos(turn - 0.25))[:, None]
    flat = [fold.share * outline for fold in FOLDS]
    on_skin = _beside(m, ear, np.concatenate([outline * (1.1 - 0.3 * free) + [0.0, 0.02 * ear.height], *flat]))
    root, *lying = np.split(on_skin, len(FOLDS) + 1)
    rings = [half.add(root, "face", "ear_left")]
    for fold, place, skin in zip(FOLDS, flat, lying, strict=True):
        above_lobe = _smooth(2.4 + 5 * place[:, 1] / ear.height)
        standing = _in_plane(ear, place, fold.off * above_lobe * ear.width)
        resting = skin + fold.lift * ear.width * _outwards(ear)
        rings.append(half.add(free * standing + (1 - free) * resting, "face", "ear_left"))
    tip = half.add(_in_plane(ear, np.array([[0.08, -0.04]]) * ear.height, -0.2 * ear.width), "face", "ear_left")
    for outer, inner in pairwise(rings):
        half.strip(inner, outer, closed=True)
    half.fan(rings[-1], int(tip[0]), closed=True)
    return rings[0]


def _ear_outline(ear: Ear, turn: Floats) -> Floats:
    """Return `(n, 2)` the auricle's outline, forward and up: round above, narrow at the lobe."""
    up = np.sin(turn)
    wide = 0.5 * ear.width * (0.9 + 0.2 * up - 0.1 * up**2)
    return np.stack([wide * np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** 0.85, 0.5 * ear.height * up], axis=1)


def _outwards(ear: Ear) -> Floats:
    """Return the unit normal of the auricle's plane."""
    return np.array([np.cos(ear.flare), 0.0, np.sin(ear.flare)])


def _in_plane(ear: Ear, flat: Floats, off: Floats | float) -> Floats:
    """Return the points at these `(n, 2)` places of the auricle's plane, forward and up from its middle."""
    forward, up = _leaning(ear, flat)
    behind = 0.5 * ear.width - forward
    x, z = behind * np.sin(ear.flare), 0.5 * ear.width - behind * np.cos(ear.flare)
    return np.asarray(ear.centre + np.stack([x, up, z], axis=1) + np.multiply.outer(off, _outwards(ear)))


def _leaning(ear: Ear, flat: Floats) -> tuple[Floats, Floats]:
    cosine, sine = np.cos(ear.lean), np.sin(ear.lean)
    return cosine * flat[:, 0] - sine * flat[:, 1], sine * flat[:, 0] + cosine * flat[:, 1]


def _beside(m: Measures, ear: Ear, flat: Floats) -> Floats:
    """Return the skin's points at these `(n, 2)` places of the side view, forward and up from the ear's middle."""
    forward, up = _leaning(ear, flat)
    origins = np.stack([np.full(len(flat), 15.0), ear.centre[1] + up, ear.centre[2] + forward], axis=1)
    return first_hit(m.solids, origins, np.broadcast_to([-1.0, 0.0, 0.0], origins.shape))


def nostril_rings(half: Half, m: Measures, nostril: Nostril) -> Ints:
    """Lay rings from the rim of the nostril into it; return the outermost."""
    axis = np.array(nostril.axis) / np.linalg.norm(nostril.axis)
    back = np.array([np.sin(nostril.yaw), 0.0, -np.cos(nostril.yaw)])
    back -= (back @ axis) * axis
    back /= np.linalg.norm(back)
    turn = np.arange(nostril.points) * 2 * np.pi / nostril.points
    side = np.cross(axis, back)
    oval = nostril.long * np.cos(turn)[:, None] * back + nostril.wide * np.sin(turn)[:, None] * side
    origins = np.concatenate([np.array(nostril.centre) + share * oval + 3 * axis for share, _ in NOSTRIL_RINGS])
    skin = np.split(first_hit(m.solids, origins, np.broadcast_to(-axis, origins.shape)), len(NOSTRIL_RINGS))
    rings = []
    for (_, deep), points in zip(NOSTRIL_RINGS, skin, strict=True):
        rings.append(half.add(points - deep * nostril.depth * axis, "face", "nostril_left"))
    tip = half.add(half.vertices[-1].mean(axis=0, keepdims=True) - 0.3 * nostril.depth * axis, "face", "nostril_left")
    for outer, inner in pairwise(rings):
        half.strip(inner, outer, closed=True)
    half.fan(rings[-1], int(tip[0]), closed=True)
    return rings[0]


def _smooth(t: Floats) -> Floats:
    """Return 0 below 0, 1 above 1, and the cubic step between."""
    t = np.clip(t, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))
