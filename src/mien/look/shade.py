"""Colours and lights: what makes a bare mesh look like a face of clay.

The lights stand still relative to the camera, so a face is lit alike from every
side.  Surfaces seen from inside are dark and reddish (`HOLLOW`): an open mouth or
eye must read as a hole.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.arrays import Floats


def linear(colour: Floats) -> Floats:
    """Return light proportional to energy for sRGB values between 0 and 1."""
    c = np.clip(np.asarray(colour, dtype=np.float64), 0, 1)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def encoded(light: Floats) -> Floats:
    """Return sRGB values for light between 0 and 1, what `linear` undoes."""
    c = np.clip(np.asarray(light, dtype=np.float64), 0, 1)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)


def _towards(x: float, y: float, z: float) -> Floats:
    direction = np.array([x, y, z])
    return np.asarray(direction / np.linalg.norm(direction))


KEY = _towards(-0.55, 0.75, 0.95)
"""Towards the main light, in the camera's axes: right, up, backward."""
FILL = _towards(0.9, -0.05, 0.7)
RIM = _towards(0.5, 0.8, -0.6)
WRAP = np.array([0.24, 0.15, 0.11])
"""How far light creeps around an edge, per band: red the farthest, as in skin."""

SKIN = np.array([0.88, 0.74, 0.665])
BACKDROP = np.array([[0.93, 0.935, 0.94], [0.82, 0.83, 0.84]])
"""sRGB of the background, above and below."""
HOLLOW = np.array([0.085, 0.045, 0.040])
"""What is left of a colour seen from inside."""
HOLE_LIGHT = 0.4 * linear(SKIN) * HOLLOW
"""Linear colour of what shows through the surface."""

IRIS, PUPIL = linear(np.array([0.36, 0.42, 0.44])), linear(np.array([0.07, 0.07, 0.08]))
IRIS_COSINE, PUPIL_COSINE = float(np.cos(np.radians(28.0))), float(np.cos(np.radians(12.0)))
"""Seen from the eye's centre: an iris of 11.5 mm on a ball of 24 mm, and its pupil."""

BRIGHTEST, KNEE = 3.0, 0.75


def encoding(steps: int = 8192) -> NDArray[np.uint8]:
    """Return sRGB bytes for linear light from 0 to `BRIGHTEST`, rolling off softly above `KNEE`."""
    light = np.linspace(0, BRIGHTEST, steps)
    rolled = np.where(light > KNEE, KNEE + (1 - KNEE) * np.tanh((light - KNEE) / (1 - KNEE)), light)
    return np.round(255 * encoded(rolled)).astype(np.uint8)


_RAMP = np.array([[0.80, 0.79, 0.77], [0.98, 0.85, 0.45], [0.93, 0.50, 0.20], [0.70, 0.10, 0.15], [0.35, 0.02, 0.22]])


def heat(values: Floats, top: float) -> Floats:
    """Return sRGB colours `(N, 3)` for values between 0 (grey) and `top` (dark red)."""
    place = np.clip(np.asarray(values) / top if top > 0 else np.zeros(len(values)), 0, 1)
    steps = np.linspace(0, 1, len(_RAMP))
    return np.stack([np.interp(place, steps, _RAMP[:, band]) for band in range(3)], axis=-1)
