"""The features of a face beside its mouth: lids, eyeballs, brows, teeth and tongue, each added to the left half."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mien.core.arrays import Floats, Ints
from mien.library.generic.measures import LID_RINGS, Eye, Measures, front
from mien.library.modelling.half import Half

LID_THICKNESS = (0.1, 0.2, np.inf, np.inf, np.inf)
"""How far the rings around an eye may stand before the lid's edge, over the opening's half width."""

LID_FOLD = (0.0, 0.0, -1.0, 0.6, 0.0)
"""How far the rings around an eye follow the upper lid's crease."""


def eye_rings(half: Half, m: Measures) -> Ints:
    """Lay rings from the lids' inner edge to the brow and cheek; return the outermost."""
    eye, angles = m.eye, np.arange(m.eye.points) * 2 * np.pi / m.eye.points
    edge, closing = eye.edge(angles), eye.closing(angles)
    upper = np.sin(angles) > 1e-9
    lower = np.sin(angles) < -1e-9
    rim = eye.rim(angles)
    inner = half.add(rim, "face", lid=closing)
    half.label(inner[upper], "upper_lid_left")
    half.label(inner[lower], "lower_lid_left")
    outwards = np.stack([np.cos(angles), np.sin(angles)], axis=1) * eye.half_width
    skin = front(m, np.concatenate([edge + distance * outwards for distance in LID_RINGS]))
    fold = eye.crease * np.clip(np.sin(angles), 0, 1)[:, None] * [0, 0, 1]
    rings = np.split(skin, len(LID_RINGS))
    for distance, thickness, share, points in zip(LID_RINGS, LID_THICKNESS, LID_FOLD, rings, strict=True):
        points[:, 2] = np.minimum(points[:, 2], rim[:, 2] + thickness * eye.half_width)
        points += share * fold
        ring = half.add(points, "face", lid=closing * (1 - distance / LID_RINGS[-1]) ** 1.4)
        half.strip(inner, ring, closed=True)
        inner = ring
    return inner


def eyeball(half: Half, eye: Eye) -> None:
    """Add the left eyeball, with a hollow iris."""
    limbus = np.arcsin(eye.iris / eye.radius)
    polar = np.concatenate([limbus * np.array([0.45, 0.5, 0.95, 1.05]), np.linspace(limbus * 1.5, np.pi * 0.94, 8)])
    bowl = np.concatenate([[0.93, 0.94, 0.97, 1.0], np.ones(8)]) * eye.radius
    turn = np.arange(16) * np.pi / 8
    parts = [("pupil_left", "iris_left"), ("iris_left",), ("iris_left",)] + [("sclera_left",)] * 9
    tip = half.add(np.array([[0.0, 0.0, bowl[0]]]) + eye.centre, "eye_left", "pupil_left")
    rings = []
    for p, r, names in zip(polar, bowl, parts, strict=True):
        xyz = np.stack([np.sin(p) * np.cos(turn), np.sin(p) * np.sin(turn), np.full(16, np.cos(p))], axis=1)
        rings.append(half.add(r * xyz + eye.centre, "eye_left", *names))
    half.fan(rings[0], int(tip[0]), closed=True)
    for inner, outer in pairwise(rings):
        half.strip(inner, outer, closed=True)
    back = half.add(np.array([[0.0, 0.0, -eye.radius]]) + eye.centre, "eye_left", "sclera_left")
    half.fan(rings[-1][::-1], int(back[0]), closed=True)


def brow(half: Half, m: Measures) -> None:
    """Add the left eyebrow, a tapering bar on the skin."""
    inner, peak, outer, (tall, thick) = m.brow
    t = np.linspace(0, 1, 11)[:, None]
    middle = 2 * np.array(peak) - 0.5 * (np.array(inner) + outer)
    path = front(m, (1 - t) ** 2 * inner + 2 * t * (1 - t) * middle + t**2 * outer)
    taper = np.sqrt(np.clip(1.02 - (1.35 * t[:, 0] - 0.5) ** 2 / 0.75, 0.02, 1))
    _tube(half, path, np.stack([tall * taper, thick * taper], axis=1), "brow_left")


def teeth(half: Half, m: Measures) -> None:
    """Lay a half arch of upper and of lower teeth, left open where it meets its mirror image."""
    wide, tall, at_front, deep = m.teeth
    turn = np.linspace(0, 1.3, 13)
    arch = np.stack([wide * np.sin(turn), 0 * turn, at_front - deep * (1 - np.cos(turn))], axis=1)
    arch[0, 0] = 0
    radii = np.tile([tall / 2, 0.22], (13, 1))
    behind = arch * [0.9, 1, 1] - [0, 0, 0.45]
    _tube(half, arch + np.array([0, m.mouth.height + 0.12 * tall, 0]), radii, "teeth_upper", "teeth", open_start=True)
    _tube(half, behind + np.array([0, m.mouth.height - 0.66 * tall, 0]), radii, "teeth_lower", "teeth", open_start=True)


def tongue(half: Half, centre: Floats, radii: Floats) -> None:
    """Add the left half of the tongue, a flattened ball."""
    turn = np.linspace(0, np.pi, 7)
    across = np.stack([np.sin(turn), np.cos(turn), 0 * turn], axis=1)
    across[[0, -1], 0] = 0
    rings = []
    for polar in np.linspace(0, np.pi, 9)[1:-1]:
        ring = centre + radii * (np.sin(polar) * across + np.cos(polar) * np.array([0, 0, 1]))
        rings.append(half.add(ring, "tongue"))
    for inner, outer in pairwise(rings):
        half.strip(outer, inner, closed=False)
    ends = half.add(centre + np.array([[0, 0, radii[2]], [0, 0, -radii[2]]]), "tongue")
    half.fan(rings[0][::-1], int(ends[0]), closed=False)
    half.fan(rings[-1], int(ends[1]), closed=False)


def _tube(half: Half, path: Floats, radii: Floats, *groups: str, open_start: bool = False) -> None:
    """Sweep an ellipse along a path that runs to the subject's left; `radii` are its height and thickness."""
    turn = np.arange(8) * np.pi / 4
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    if open_start:
        along[0] = [1, 0, 0]
    out = np.cross(along, [0, 1, 0])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    up = np.cross(out, along)
    rings = []
    for p, u, o, (a, b) in zip(path, up, out, radii, strict=True):
        rings.append(half.add(p + a * np.sin(turn)[:, None] * u + b * np.cos(turn)[:, None] * o, *groups))
    for first, second in pairwise(rings):
        half.strip(first, second, closed=True)
    half.fan(rings[-1][::-1], int(half.add(path[-1:] + 0.3 * radii[-1, 1] * along[-1], *groups)[0]), closed=True)
    if not open_start:
        half.fan(rings[0], int(half.add(path[:1] - 0.3 * radii[0, 1] * along[0], *groups)[0]), closed=True)
