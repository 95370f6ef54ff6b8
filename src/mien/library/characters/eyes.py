"""Eyes that need no face around them: a ball that looks about, and two lids over it.

A lid is a shell whose edge travels over the ball while its far side stays where it is,
like an awning: it can close over the ball from any slant and never enters it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.library.characters.parts import Frame, Part, ball, blob, polar_angles, ring_ids, rings, tube

SHELL = (1.05, 1.13)
"""Radii of the lids' two sides, over the ball's."""

LAP = np.radians(0.04)
"""How far each closed lid passes the line where they meet, some hundredths of a millimetre, so that no slit is left."""


@dataclass(frozen=True)
class Gaze:
    """How one eye is held; angles in degrees.

    Attributes:
        upper, lower: from the line where the lids meet to each lid's edge; 0 is closed.
        slant: how much higher the edges stand at the end in +x.
        right, up: where it looks, turned towards +x and +y.
        dilate: by what share iris and pupil are larger than usual.
        bow: how much higher the edges and the brow stand at both ends than in the middle.
        brow: how far the brow is raised.
    """

    upper: float
    lower: float
    slant: float = 0.0
    right: float = 0.0
    up: float = 0.0
    dilate: float = 0.0
    bow: float = 0.0
    brow: float = 0.0


def eye(gaze: Gaze, name: str, columns: int = 24, meet: float = -12.0) -> list[Part]:
    """Make an eye of radius 1 about the origin, looking along +Z: ball, glint, upper and lower lid.

    Args:
        gaze: how it is held.
        name: ends the names of its own groups, `eyeball_…` and `lids_…`.
        columns: how finely it is divided.
        meet: elevation of the line where the lids meet [degrees].
    """
    limbus = np.radians(27) * (1 + gaze.dilate)
    near = np.array([0.25, 0.48, 0.52, 0.75, 0.97, 1.05]) * limbus
    white = np.linspace(near[-1], 0.93 * np.pi, 7)[1:]
    eyeball = ball(np.concatenate([near, white]), columns)
    front = len(eyeball.points) - 2
    eyeball = eyeball.named(f"eyeball_{name}", "sclera")
    eyeball = eyeball.named("iris", only=np.append(ring_ids(columns, 0, 5), front))
    eyeball = eyeball.named("pupil", only=np.append(ring_ids(columns, 0, 2), front))
    look = turn(np.radians(gaze.right), np.radians(gaze.up))
    return [eyeball.moved(lambda p: p @ look), _glint(look), *lids(gaze, name, columns, meet)]


def lids(gaze: Gaze, name: str, columns: int, meet: float) -> list[Part]:
    """Make the upper and the lower lid over a ball of radius 1 about the origin."""
    return [_lid(gaze, meet, side, columns).named("lids", f"lids_{name}") for side in (1, -1)]


def turn(right: float, up: float) -> Floats:
    """Return the matrix that row vectors are multiplied by to turn +Z towards +x and then +y [rad]."""
    yaw = np.array([[np.cos(right), 0, -np.sin(right)], [0, 1, 0], [np.sin(right), 0, np.cos(right)]])
    pitch = np.array([[1, 0, 0], [0, np.cos(up), -np.sin(up)], [0, np.sin(up), np.cos(up)]])
    return np.asarray(pitch @ yaw)


def _glint(look: Floats) -> Part:
    """Make the light that an eye reflects; it goes a little way with the gaze."""
    out = np.array([-0.24, 0.26, 1.0]) + 0.6 * (look[2] - [0, 0, 1])
    at = Frame.facing(0.995 * out / np.linalg.norm(out), out)
    return blob((0.12, 0.12, 0.03), 4, 10).moved(at.place).named("glint")


def _lean(gaze: Gaze, across: Floats) -> Floats:
    """Return how much higher than usual a lid or brow stands along its way from +x [rad]."""
    return np.radians(gaze.slant * np.cos(across) + gaze.bow * (1.5 * np.abs(np.cos(across)) - 0.8))


def brow(gaze: Gaze) -> Part:
    """Make the brow of an eye of radius 1, an arc over its upper lid."""
    across = np.pi * np.linspace(0.16, 0.84, 11)
    height = np.radians(58 + gaze.brow) + 1.3 * _lean(gaze, across)
    ahead = np.stack([np.cos(across), np.sin(across) * np.sin(height), np.sin(across) * np.cos(height)], axis=1)
    thick = 0.13 * np.sqrt(np.clip(1 - (2 * np.linspace(0, 1, 11) - 1) ** 2 * 0.9, 0, 1))
    return tube(1.2 * ahead, thick, 10).named("brows")


def _lid(gaze: Gaze, meet: float, side: int, columns: int) -> Part:
    """Make the upper (`side` 1) or lower (-1) lid from loops through its section, one beside the other along x."""
    across = polar_angles(columns)
    opening = np.radians(gaze.upper if side > 0 else gaze.lower)
    line = np.radians(meet) * np.sin(across) ** 2
    edge = side * opening * np.sin(across) ** 0.3 + (1.0 if side > 0 else 0.4) * _lean(gaze, across)
    edge = line + side * (np.maximum(side * edge, 0) - LAP)
    far = side * np.radians(174)
    share = np.concatenate([[0.0, 0.045, 0.055], np.linspace(0.16, 1, 6), np.linspace(1, 0, 3)])
    inner, outer = SHELL
    radius = np.concatenate([[(inner + outer) / 2], [outer] * 8, [inner] * 3])
    height = edge[:, None] + (far - edge)[:, None] * share
    flat = np.sin(across)[:, None] * radius
    loops = np.stack([np.cos(across)[:, None] * radius, flat * np.sin(height), flat * np.cos(height)], axis=2)
    middle = sum(SHELL) / 2
    lid = rings(loops, np.array([[middle, 0, 0], [-middle, 0, 0]]))
    rim = np.arange(columns)[:, None] * len(share) + np.array([0, 1, len(share) - 1])
    return lid.named("lashes", only=rim.ravel())
