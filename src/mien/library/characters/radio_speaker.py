"""The radio's eyes: speakers whose cones look about, under shutters that close like lids."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from mien.core.arrays import Floats
from mien.library.characters.eyes import Gaze, lids, turn
from mien.library.characters.parts import Frame, Part, ball, blob, circle, moved, polar_angles, turned
from mien.library.characters.radio_poses import RadioPose

SPEAKER, REACH = (8.9, -1.6, 5.15), 3.35
"""The left speaker's middle, and the speakers' radius [cm]."""


def speaker(pose: RadioPose, side: int, bent: Callable[[Floats], Floats]) -> list[Part]:
    """Make a speaker, which goes with the chassis as a rigid thing: pod, cone, cap and shutters."""
    x, y, z = SPEAKER
    at = Frame(np.array([side * x, y, z]), np.eye(3)).carried(bent)
    at = Frame(at.origin, turn(np.radians(-side * pose.toe), 0.0) @ at.axes)
    size = REACH * (1 + pose.big)
    made = [_pod().moved(lambda p: at.place(size * p))]
    look = turn(np.radians(0.7 * pose.right), np.radians(0.7 * pose.up))
    out = np.array([0, 0, pose.push / size])
    glance = np.radians([pose.right, pose.up, 0.0]) * 0.85
    centre = np.array([0, 0, -0.16]) + glance * [1, 1, 0] + out
    cone, ring = _cone(pose)
    made.append(cone.moved(lambda p: at.place(size * (p @ look + out))))
    made.append(ring.moved(lambda p: at.place(size * (p @ look + centre))))
    cap = 0.25 * (1 + 0.6 * pose.dilate)
    dome = ball(polar_angles(12), 24).named("cap", "cap_left" if side > 0 else "cap_right")
    made.append(dome.moved(lambda p: at.place(size * (cap * p + centre))))
    light = centre + cap * np.array([-0.42, 0.45, 0.8])
    made.append(blob((0.07, 0.07, 0.03), 4, 10).moved(lambda p: at.place(size * (p + light))).named("glint"))
    lost = 1 - (pose.squint if side > 0 else 0)
    gaze = Gaze(pose.upper * lost, pose.lower * lost, side * pose.slant)
    name = "left" if side > 0 else "right"
    return made + moved(lids(gaze, name, 26, -8.0), lambda p: at.place(size * p * [1, 1, 0.5]))


@cache
def _pod() -> Part:
    """Make the housing of a speaker of radius 1: a bowl with a thick rim."""
    profile = [
        (0.3, -0.3),
        (0.95, -0.3),
        (1.0, -0.2),
        (1.0, 0.0),
        (1.18, 0.0),
        (1.25, -0.04),
        (1.28, -0.12),
        (1.3, -0.5),
        (0.6, -0.55),
    ]
    return turned(profile, circle(40)).named("pods")


def _cone(pose: RadioPose) -> tuple[Part, Part]:
    """Make the cone of a speaker of radius 1, with a coloured ring around where its cap is."""
    profile = [
        (0.2, -0.22),
        (0.5, -0.14),
        (0.53, -0.1),
        (0.56, -0.14),
        (0.72, -0.06),
        (0.75, -0.02),
        (0.78, -0.06),
        (0.9, 0.0),
    ]
    profile += [(0.94, 0.05), (0.98, 0.0), (0.98, -0.15), (0.5, -0.3)]
    cone = turned(profile, circle(40)).named("cone")
    ring = turned(
        [(0.3, 0.08), (0.86, 0.08), (1.0, 0.03), (0.9, -0.1), (0.4, -0.1)], 0.42 * (1 + 0.45 * pose.dilate) * circle(32)
    )
    return cone, ring.named("ring")
