"""The radio's mouth: a compartment whose door opens on a hinge below, and the cassette inside."""

from __future__ import annotations

from functools import cache

import numpy as np

from mien.core.arrays import Floats
from mien.library.characters.eyes import turn
from mien.library.characters.parts import Frame, Part, circle, moved, ring_ids, rings, rolled, rounded, slab, turned
from mien.library.characters.radio_poses import RadioPose

FACE = 3.75
"""Depth of the front panel [cm]."""
DECK = np.array([0.0, -2.2, 0.3])
WIDE, TALL, CORNER, COLUMNS = 3.3, 2.5, 0.55, 56
OPENING = rounded(WIDE, TALL, CORNER, COLUMNS)
"""The compartment's middle, and its opening [cm]."""
HINGE = np.array([0.0, -2.4, 5.36])
"""What the door turns about [cm]."""
CLEARANCE = 0.012
"""Between the door and the frame [cm]."""


def held(pose: RadioPose, points: Floats) -> Floats:
    """Return where points of the compartment at rest go when it widens, curves and is pushed out."""
    x, y, z = points.T
    across = x / 4.2
    near = np.clip((z - FACE) / 1.6, 0, 1)
    bowed = pose.curve * (across**2 - 0.45) + 0.5 * pose.skew * across
    return np.asarray(np.stack([x * (1 + pose.wide), y * (1 + pose.tall) + bowed, z + pose.out * near], axis=1) + DECK)


def deck(pose: RadioPose) -> list[Part]:
    """Make the compartment about the origin: frame, door, and the cassette inside."""
    return [_frame(), *_door(pose), *_cassette(pose)]


@cache
def _frame() -> Part:
    profile = [(0.3, 3.9), (0.97, 3.9), (1.0, 4.1), (1.0, 5.3), (1.02, 5.52), (1.06, 5.6)]
    outlines = [(reach * OPENING, z) for reach, z in profile]
    for away, z in ((0.55, 5.6), (0.7, 5.45), (0.75, 5.2), (0.95, 3.5), (0.8, 3.0)):
        outlines.append((rounded(WIDE + away, TALL + away, CORNER + away, COLUMNS), z))
    stack = np.stack([np.column_stack([outline, np.full(COLUMNS, z)]) for outline, z in outlines])
    frame = rings(stack, np.array([[0, 0, 3.9], [0, 0, 3.0]])).named("frame")
    frame = frame.named("cavity", only=np.append(ring_ids(COLUMNS, 0, 3), len(frame.points) - 2))
    return frame.named("door_frame", only=ring_ids(COLUMNS, 3))


def _door(pose: RadioPose) -> list[Part]:
    """Make the door with its window and the reels behind it, turned about the hinge."""
    leaf = OPENING * (1 - CLEARANCE / np.array([WIDE, TALL]))
    door = slab(leaf, 4.75, 5.42, 0.12, 4).named("door").named("door_rim", only=ring_ids(COLUMNS, 5))
    made = [door, slab(rounded(2.6, 1.45, 0.35, 40), 5.2, 5.54, 0.08, 4).shifted(0, 0.35, 0).named("window")]
    cogs = circle(24) * (0.72 + 0.12 * np.sign(np.sin(np.pi / 2 * np.arange(24) + 0.1)))[:, None]
    spin = rolled(pose.reels).place
    for x in (-1.25, 1.25):
        reel = turned([(0.25, 5.62), (0.3, 5.68), (1.0, 5.68), (1.04, 5.42), (0.5, 5.37)], cogs)
        made.append(reel.moved(spin).shifted(x, 0.35, 0).named("reels"))
    swing = Frame(HINGE, turn(0.0, np.radians(-pose.door)))
    return moved(made, lambda p: swing.place(p - HINGE))


def _cassette(pose: RadioPose) -> list[Part]:
    """Make the cassette, which rises and tips out like a tongue."""
    made = [slab(rounded(2.8, 1.5, 0.25, 40), 4.0, 4.55, 0.1, 4).named("cassette")]
    made.append(slab(rounded(2.3, 0.7, 0.15, 32), 4.4, 4.62, 0.05, 4).shifted(0, 0.3, 0).named("label"))
    middle = np.array([0.0, 0.0, 4.3])
    tip = Frame(middle + [0, 1.5 * pose.eject - 0.5, 2.3 * pose.eject], turn(0.0, np.radians(38 * pose.eject)))
    return moved(made, lambda p: tip.place(p - middle))
