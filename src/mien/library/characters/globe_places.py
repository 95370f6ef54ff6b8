"""Where on the globe its eyes, noses and mouths sit [cm]."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from mien.core.arrays import Floats
from mien.library.characters.parts import Frame

RADIUS = 9.6


class Eye(NamedTuple):
    """An eye: its place, radius, whether it stands on a stalk, and the side of its inner end for slants."""

    x: float
    y: float
    radius: float
    stalk: bool = False


class Mouth(NamedTuple):
    """A mouth: its place, size, roll [degrees], how gladly it opens, and its teeth."""

    x: float
    y: float
    size: float
    roll: float
    opening: float
    outline: tuple[float, float]
    teeth: tuple[tuple[float, float, float], ...]


EYES = (
    Eye(0.0, 4.1, 2.35),
    Eye(4.75, 3.5, 1.6),
    Eye(-4.75, 3.5, 1.6),
    Eye(2.5, 10.9, 1.25, stalk=True),
    Eye(-2.2, 11.9, 1.05, stalk=True),
)

_FIVE = ((-0.62, 0.62, 0.5), (-0.3, 0.78, 0.62), (0.06, 0.8, 0.66), (0.4, 0.74, 0.6), (0.66, 0.55, 0.45))
MOUTHS = (
    Mouth(0.8, -4.6, 0.82, 0.0, 1.0, (5.6, 4.2), (*_FIVE, (-0.45, 0.5, -0.75), (0.42, 0.5, -0.7))),
    Mouth(6.5, -0.9, 0.42, 14.0, 0.9, (5.6, 4.2), ((-0.3, 0.9, 0.7), (0.3, 0.9, 0.7))),
    Mouth(-6.5, -0.7, 0.40, -14.0, 0.9, (5.6, 4.2), ((0.0, 1.1, 0.9), (-0.4, 0.6, -0.7))),
    Mouth(-5.8, -5.1, 0.31, -24.0, 1.0, (5.6, 4.2), ((0.0, 1.3, 0.9),)),
)
NOSES = ((1.75, 0.1, 1.0), (-1.6, 0.3, 0.85))


@cache
def seat(x: float, y: float, roll: float = 0.0) -> Frame:
    """Return the frame on the sphere in front of (x, y), turned by `roll` [degrees], its rows right, up and out."""
    at = np.array([x, y, np.sqrt(RADIUS**2 - x**2 - y**2)])
    right, up, out = Frame.facing(at, at).axes
    c, s = np.cos(np.radians(roll)), np.sin(np.radians(roll))
    return Frame(at, np.stack([c * right + s * up, c * up - s * right, out]))


def wrapped(frame: Frame, points: Floats) -> Floats:
    """Lay points given over a tangent plane around the sphere, each at its own height above it."""
    far = np.hypot(points[:, 0], points[:, 1]) / RADIUS
    flat = points[:, :2] / RADIUS * np.sinc(far / np.pi)[:, None]
    direction = np.column_stack([flat, np.cos(far)]) @ frame.axes
    return np.asarray((RADIUS + points[:, 2:]) * direction)
