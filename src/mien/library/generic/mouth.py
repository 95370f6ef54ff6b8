"""The mouth: rings from the throat over the lips to the skin around, so that both lips have edges of their own."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mien.core.arrays import Ints
from mien.library.generic.measures import Measures, Mouth, front
from mien.library.modelling.half import Half


class Ring(NamedTuple):
    """A ring around the mouth: its distances from the slit, how far it stands out, and how it tapers to the corners.

    `bow` and `groove` are its shares of the dip in the upper lip's border and of the philtrum.
    """

    widen: float
    above: float
    below: float
    out: float
    taper: float
    parts: tuple[str, ...] = ()
    bow: float = 0.0
    groove: float = 0.0


def mouth_rings(half: Half, m: Measures) -> Ints:
    """Lay rings from the throat over the lips to the chin; return the outermost, from below to above."""
    mouth = m.mouth
    angles = np.linspace(-np.pi / 2, np.pi / 2, mouth.points)
    cosine, sine = np.cos(angles), np.sin(angles)
    cosine[[0, -1]], sine[mouth.points // 2] = 0, 0
    table = _mouth_table(mouth)
    flat, depth = [], []
    for ring in table:
        x = (mouth.half_width + ring.widen) * cosine
        midline = np.exp(-((x / (0.19 * mouth.half_width)) ** 2)) * (sine > 0)
        rise = np.where(sine > 0, ring.above, -ring.below) * np.abs(sine) ** ring.taper
        rise = rise - ring.bow * mouth.bow * mouth.upper * midline
        flat.append(np.stack([x, mouth.height + mouth.lift * cosine**4 + rise], axis=1))
        at_corner = {"pocket": 1.0, "inside": 0.25}.get("".join(ring.parts[1:]), 0.0)
        out = ring.out * (at_corner + (1 - at_corner) * np.abs(sine) ** 0.6)
        depth.append(out - ring.groove * mouth.philtrum * midline)
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
        Ring(0.4, 1.9, floor, -2.8, 0.85, pocket),
        Ring(0.2, 1.6, 1.6, -0.45, 0.85, pocket),
        Ring(-0.04, 0.3 * up, 0.3 * low, -0.4, 0.85, inside),
        Ring(-0.02, 0.05, 0.05, -0.14, 0.85, inside),
        Ring(0.0, 0.005, 0.005, 0.1 * full, 0.85, lips),
        Ring(0.03, 0.16 * up, 0.16 * low, 0.6 * full, 0.95, lips),
        Ring(0.07, 0.55 * up, 0.55 * low, full, 1.3, lips, 0.4),
        Ring(0.11, up, low, 0.75 * full, 1.4, lips, 1.0, 0.6),
        Ring(0.2, 1.08 * up + 0.06, 1.08 * low + 0.06, 0.5 * full, 1.2, (), 0.9, 1.0),
        Ring(0.72, 1.6 * up + 0.3, 1.7 * low + 0.3, 0.0, 0.85, (), 0.0, 1.0),
    )
