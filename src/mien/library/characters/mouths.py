"""Mouths that can sit anywhere: two lips, a dark inside with teeth and tongue, and the skin around them.

A mouth is one closed surface of rings around its opening: from the throat over the
inner lip, the red and the skin to an outline that never moves, and back underneath.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.library.characters.parts import Part, blob, circle, ring_ids, rings

LEAST = 0.006
"""Half the gap between closed lips, in the middle: they meet without touching [cm]."""

_ROLL = np.radians([-75, -35, 0, 25, 50, 75, 100, 125, 150, 172])
"""Angles around the lips' section, from inside to outside; 0 is where they meet."""

_THROAT, _LIPS, _SKIN = 3, len(_ROLL), 6


@dataclass(frozen=True)
class Lips:
    """How a mouth is held [cm of a mouth with half width about 3.5].

    Attributes:
        half_width: from the middle to a corner.
        up, low: how far the upper and lower lip stand from the line between the corners.
        curve: how far the corners stand above the middle.
        skew: how far the corner in +x stands above the other.
        pucker: how far the lips are pushed out.
        thick: thickness of the lips.
        tongue: how far the tongue comes out, from 0 to 1.
    """

    half_width: float = 3.4
    up: float = 0.06
    low: float = 0.06
    curve: float = 0.5
    skew: float = 0.0
    pucker: float = 0.0
    thick: float = 0.46
    tongue: float = 0.0

    def middle(self, x: Floats) -> Floats:
        """Return the height of the line between the lips at `x`."""
        across = x / self.half_width
        return np.asarray(self.curve * (across**2 - 0.5) + 0.5 * self.skew * across)


def mouth(
    lips: Lips, outline: tuple[float, float], teeth: Sequence[tuple[float, float, float]], name: str, columns: int
) -> list[Part]:
    """Make a mouth in front of the plane z = 0: its lips and skin, teeth and tongue.

    Args:
        lips: how it is held.
        outline: half width and half height of the skin around it, which stays where it is [cm].
        teeth: place along the half width (-1 to 1), width [cm] and length [cm] of each; below zero for lower ones.
        name: ends the names of the lips' meeting lines, `upper_lip_…` and `lower_lip_…`.
        columns: number of points around the opening, a multiple of four.
    """
    return [_lips(lips, outline, name, columns), *(_tooth(lips, *tooth) for tooth in teeth), _tongue(lips)]


def _lips(lips: Lips, outline: tuple[float, float], name: str, columns: int) -> Part:
    cosine, sine = circle(columns).T
    sine[[0, columns // 2]] = 0
    x = lips.half_width * cosine
    rise = np.where(sine > 0, lips.up, lips.low) + LEAST
    edge = np.stack([x, lips.middle(x) + rise * sine * np.abs(sine) ** 0.1], axis=1)
    out = np.stack([cosine * cosine**2, sine], axis=1)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    thick = lips.thick * (0.62 + np.where(sine > 0, 0.28, 0.5) * np.abs(sine))
    rows = [_raised(edge + (thick * (1 - np.cos(a)))[:, None] * out, thick * np.sin(a) + lips.pucker) for a in _ROLL]
    rim = np.array(outline) * np.stack([cosine, sine], axis=1)
    last, height = rows[-1][:, :2], rows[-1][:, 2]
    for t in np.linspace(0, 1, _SKIN + 1)[1:]:
        rows.append(_raised(last + (rim - last) * t, height * (1 - t) ** 2 + 0.25 * np.sin(np.pi * t) - 0.6 * t**8))
    rows.append(_raised(0.98 * rim, np.full(columns, -1.3)))
    pocket = edge + 0.3 * thick[:, None] * out + np.stack([0 * sine, 0.35 * sine], axis=1)
    centre = pocket.mean(axis=0)
    back = centre + np.stack([0.6 * cosine, 0.4 * sine], axis=1)
    depth = ((0.0, -1.75), (0.7, -1.6), (1.0, -0.95))
    throat = [_raised(back + (pocket - back) * share, np.full(columns, z)) for share, z in depth]
    part = rings(np.stack([*throat, *rows]), np.array([[*centre, -1.78], [0, 0, -2.1]]))
    meeting = ring_ids(columns, _THROAT + 2)
    part = part.named("throat", only=np.append(ring_ids(columns, 0, _THROAT + 1), len(part.points) - 2))
    part = part.named("lips", only=ring_ids(columns, _THROAT + 1, _THROAT + _LIPS - 1))
    part = part.named(f"upper_lip_{name}", only=meeting[sine > 0])
    return part.named(f"lower_lip_{name}", only=meeting[sine < 0])


def _raised(flat: Floats, height: Floats) -> Floats:
    return np.column_stack([flat, height])


def _tooth(lips: Lips, along: float, width: float, length: float) -> Part:
    """Make a tooth behind the upper lip (`length` above 0) or the lower one, going with it."""
    x = along * lips.half_width * 0.86
    side = np.sign(length)
    arch = np.sqrt(max(1 - along**2, 0.05))
    lip = lips.middle(np.array(x)) + side * (lips.up if side > 0 else lips.low) * arch
    peg = blob((0.5 * width, 0.5 * abs(length) + 0.25, 0.16), 6, 10)
    peg = peg.moved(lambda p: np.sign(p) * np.abs(p / np.ptp(p, axis=0).max()) ** 0.8 * np.ptp(p, axis=0).max())
    return peg.moved(lambda p: p + [x, lip + side * (0.25 - 0.5 * abs(length)), -0.42 + lips.pucker * 0.6]).named(
        "teeth"
    )


def _tongue(lips: Lips) -> Part:
    """Make a tongue that lies in the mouth, or hangs out over the lower lip."""
    out = lips.tongue
    half = 0.45 * lips.half_width
    flat = blob((half, 0.3 + 0.3 * min(lips.low, 1.5), 0.3), 7, 14)
    y = float(lips.middle(np.array(0.0))) - 0.62 * lips.low

    def placed(p: Floats) -> Floats:
        hang = np.clip(-p[:, 1] / 0.5, 0, 1)
        forward = out * np.stack([0 * hang, -1.5 * hang**2, 1.4 * np.sqrt(np.clip(hang * 1.3, 0, 1))], axis=1)
        return np.asarray(p + forward + [0, y + 0.05, -0.75 + lips.pucker * 0.4])

    return flat.moved(placed).named("tongue")
