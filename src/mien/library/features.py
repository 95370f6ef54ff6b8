"""The features of a face: lids, lips, eyeballs, brows and teeth, each added to the left half."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mien.core.arrays import Floats, Ints
from mien.library.half import Half
from mien.library.measures import LID_RINGS, Eye, Measures, Mouth, front


def eye_rings(half: Half, m: Measures) -> Ints:
    """Lay rings from the lids' inner edge to the brow and cheek; return the outermost."""
    eye, angles = m.eye, np.arange(m.eye.points) * 2 * np.pi / m.eye.points
    edge, closing = eye.edge(angles), eye.closing(angles)
    offset = edge - np.array(eye.centre[:2])
    depth = np.sqrt((eye.radius + eye.clearance) ** 2 - (offset**2).sum(axis=1))
    upper = np.sin(angles) > 1e-9
    lower = np.sin(angles) < -1e-9
    inner = half.add(np.column_stack([edge, eye.centre[2] + depth]), "face", lid=closing)
    half.label(inner[upper], "upper_lid_left")
    half.label(inner[lower], "lower_lid_left")
    outwards = np.stack([np.cos(angles), np.sin(angles)], axis=1) * eye.half_width
    skin = front(m, np.concatenate([edge + distance * outwards for distance in LID_RINGS]))
    for distance, points in zip(LID_RINGS, np.split(skin, len(LID_RINGS)), strict=True):
        ring = half.add(points, "face", lid=closing * (1 - distance / LID_RINGS[-1]) ** 1.4)
        half.strip(inner, ring, closed=True)
        inner = ring
    return inner


class Ring(NamedTuple):
    """A ring around the mouth: its distances from the slit, how far it stands out, and how it tapers to the corners."""

    widen: float
    above: float
    below: float
    out: float
    taper: float
    parts: tuple[str, ...] = ()


def mouth_rings(half: Half, m: Measures) -> Ints:
    """Lay rings from the throat over the lips to the chin; return the outermost, from below to above."""
    mouth = m.mouth
    angles = np.linspace(-np.pi / 2, np.pi / 2, mouth.points)
    cosine, sine = np.cos(angles), np.sin(angles)
    cosine[[0, -1]], sine[mouth.points // 2] = 0, 0
    table = _mouth_table(mouth)
    flat, depth = [], []
    for ring in table:
        rise = np.where(sine > 0, ring.above, -ring.below) * np.abs(sine) ** ring.taper
        y = mouth.height + mouth.lift * cosine**4 + rise
        flat.append(np.stack([(mouth.half_width + ring.widen) * cosine, y], axis=1))
        at_corner = {"pocket": 1.0, "inside": 0.25}.get("".join(ring.parts[1:]), 0.0)
        depth.append(ring.out * (at_corner + (1 - at_corner) * np.abs(sine) ** 0.6))
    points = front(m, np.concatenate(flat)) + np.concatenate(depth)[:, None] * [0, 0, 1]
    rings = [half.add(p, "face", *r.parts) for p, r in zip(np.split(points, len(table)), table, strict=True)]
    for ids, ring in zip(rings, table, strict=True):
        if "lips" in ring.parts:
            for part, chosen in (("upper_lip", sine > 0), ("lower_lip", sine < 0), ("lip_corner_left", sine == 0)):
                half.label(ids[chosen], part)
    throat = half.add(np.array([[0.0, mouth.height, points[0, 2] - 1]]), "face", "mouth")
    half.fan(rings[0], int(throat[0]), closed=False)
    for inner, outer in pairwise(rings):
        half.strip(inner, outer, closed=False)
    return rings[-1]


def _mouth_table(mouth: Mouth) -> tuple[Ring, ...]:
    """Return the rings from the throat outwards: the pocket that holds the teeth, the lips, and the skin around."""
    up, low, full, floor = mouth.upper, mouth.lower, mouth.fullness, 1.9 + mouth.lift
    pocket, inside, lips = ("mouth", "pocket"), ("mouth", "inside"), ("lips",)
    return (
        Ring(-0.6, 0.9, 0.9, -6.5, 0.85, pocket),
        Ring(0.2, 1.9, floor, -5.5, 0.85, pocket),
        Ring(0.4, 1.9, floor, -2.8, 0.85, pocket),
        Ring(0.2, 1.6, 1.6, -0.45, 0.85, pocket),
        Ring(-0.04, 0.3 * up, 0.3 * low, -0.4, 0.85, inside),
        Ring(-0.02, 0.05, 0.05, -0.14, 0.85, inside),
        Ring(0.0, 0.005, 0.005, 0.0, 0.85, lips),
        Ring(0.05, 0.16 * up, 0.16 * low, 0.5 * full, 0.85, lips),
        Ring(0.12, 0.55 * up, 0.55 * low, full, 1.25, lips),
        Ring(0.2, up, low, 0.35 * full, 1.25, lips),
        Ring(0.34, 1.25 * up + 0.1, 1.25 * low + 0.1, 0.0, 0.85),
        Ring(0.75, 1.6 * up + 0.35, 1.7 * low + 0.35, 0.0, 0.85),
    )


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
