"""A cassette radio: it talks with the door of its compartment and looks out of its speakers."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial

import numpy as np

from mien.core import Rig
from mien.core.arrays import Floats
from mien.library.characters.parts import Part, blob, circle, moved, rolled, rounded, slab, tube, turned
from mien.library.characters.radio_deck import FACE, deck, held
from mien.library.characters.radio_poses import POSES, REST, RadioPose
from mien.library.characters.radio_speaker import speaker
from mien.library.characters.rigs import posed_rig

MASKS = ("chassis", "compartment", "speakers")

COLOURS: Mapping[str, tuple[float, float, float]] = {
    "case": (0.50, 0.055, 0.04),
    "panel": (0.72, 0.62, 0.44),
    "handle": (0.045, 0.045, 0.05),
    "feet": (0.03, 0.03, 0.03),
    "antenna": (0.55, 0.56, 0.58),
    "knobs": (0.60, 0.58, 0.54),
    "marks": (0.50, 0.055, 0.04),
    "keys": (0.10, 0.28, 0.30),
    "dial": (0.05, 0.05, 0.055),
    "needle": (0.85, 0.30, 0.02),
    "grille": (0.16, 0.12, 0.08),
    "screws": (0.42, 0.40, 0.36),
    "frame": (0.10, 0.28, 0.30),
    "cavity": (0.010, 0.010, 0.012),
    "door": (0.16, 0.40, 0.41),
    "window": (0.025, 0.035, 0.04),
    "reels": (0.80, 0.76, 0.66),
    "cassette": (0.70, 0.28, 0.03),
    "label": (0.85, 0.80, 0.66),
    "pods": (0.045, 0.045, 0.05),
    "lids": (0.50, 0.055, 0.04),
    "lashes": (0.05, 0.012, 0.01),
    "cone": (0.80, 0.76, 0.66),
    "ring": (0.10, 0.34, 0.36),
    "cap": (0.012, 0.012, 0.014),
    "glint": (0.98, 0.98, 0.98),
}
"""Linear red, green and blue of vertex groups, later ones over earlier."""

HALF = 13.4
"""Half the width of the chassis [cm]."""


@cache
def radio() -> Rig:
    """Make the radio: 23 cm tall, with the extremes of the three layers; its masks are `MASKS`, its look `COLOURS`."""
    return posed_rig("radio", parts, POSES, REST, MASKS, COLOURS)


def parts(pose: RadioPose) -> list[Part]:
    """Return every part of the radio in a pose [cm]."""
    bent = partial(deformed, pose)
    soft = [part.named("chassis") for part in [*_case(), *_controls(pose), *_handle(pose), *_antenna(pose)]]
    soft += [part.named("compartment") for part in moved(deck(pose), partial(held, pose))]
    made = moved(soft, bent)
    for side in (1, -1):
        made += [part.named("speakers") for part in speaker(pose, side, bent)]
    return made


def deformed(pose: RadioPose, points: Floats) -> Floats:
    """Return where points go when the whole radio bends, shears, swells, wrings and leans."""
    x, y, z = points.T
    tall, size = 1 + pose.stretch, 1 + pose.swell
    x, y, z = x * size / tall**0.7, y * size * tall, z * size**0.5
    x, y = x + pose.shear * y, y + pose.quake * np.sin(1.25 * x + 0.6)
    angle = np.radians(pose.wring) * x / HALF
    y, z = y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)
    angle = 2 * pose.bend / HALF**2 * x
    arc, rise = x * np.sinc(angle / np.pi), 0.5 * x * angle * np.sinc(angle / 2 / np.pi) ** 2
    x, y = arc - y * np.sin(angle), rise + y * np.cos(angle)
    lean, bow = np.radians([-pose.tilt, pose.nod])
    y, z = y * np.cos(bow) - z * np.sin(bow), y * np.sin(bow) + z * np.cos(bow)
    return np.stack([x * np.cos(lean) - y * np.sin(lean), x * np.sin(lean) + y * np.cos(lean), z], axis=1)


@cache
def _case() -> list[Part]:
    """Make what only ever goes with the chassis."""
    case = slab(rounded(HALF, 7.6, 1.7, 64), -3.6, 3.5, 0.6, 5).named("case")
    panel = slab(rounded(12.7, 6.9, 1.2, 64), 2.5, FACE, 0.15, 8).named("panel")
    made = [case.shifted(0, -1.5, 0), panel.shifted(0, -1.5, 0)]
    for x in (-9.0, 9.0):
        made.append(slab(rounded(1.6, 0.6, 0.3, 24), -2.0, 2.0, 0.15).shifted(x, -9.2, 0).named("feet"))
    for x in (-12.0, 12.0):
        for y in (-7.7,):
            screw = turned([(0.15, 0.12), (0.6, 0.12), (0.9, 0.05), (1.0, -0.2), (0.5, -0.3)], 0.32 * circle(12))
            made.append(screw.shifted(x, y, FACE + 0.03).named("screws"))
    for n in range(9):
        bar = slab(rounded(0.2, 0.55, 0.18, 12), -0.2, 0.14, 0.08, 1)
        made.append(bar.shifted(0.62 * (n - 4), 1.35, FACE).named("grille"))
    for n in range(5):
        key = slab(rounded(0.68, 0.5, 0.15, 16), -0.4, 0.55, 0.12, 1)
        made.append(key.shifted(1.5 * (n - 2), -7.65, FACE).named("keys"))
    return made


def _controls(pose: RadioPose) -> list[Part]:
    """Make the dial and its needle, and the knobs."""
    dial = slab(rounded(4.6, 0.75, 0.25, 48), -0.3, 0.15, 0.1, 4).shifted(0, 3.5, FACE).named("dial")
    needle = slab(rounded(0.12, 0.6, 0.1, 12), -0.1, 0.3, 0.05, 1)
    made = [dial, needle.shifted(pose.knobs / 40, 3.5, FACE).named("needle")]
    roll = rolled(pose.knobs).place
    for x in (-10.6, 10.6):
        knob = turned(
            [(0.3, 1.3), (0.75, 1.3), (0.9, 1.2), (1.0, 0.95), (1.08, 0.0), (1.0, -0.3), (0.4, -0.3)], 1.05 * circle(24)
        )
        mark = slab(rounded(0.1, 0.35, 0.08, 12), 1.1, 1.42, 0.05, 1).shifted(0, 0.5, 0)
        for part, group in ((knob, "knobs"), (mark, "marks")):
            made.append(part.moved(roll).shifted(x, 3.95, FACE).named(group))
    return made


def _handle(pose: RadioPose) -> list[Part]:
    """Make the handle: each half turns about its outer end, as a brow does."""
    bow = np.linspace(np.pi, np.pi / 2, 7)
    path = np.concatenate([[[0.0, 0.0]], np.stack([2 + 2.0 * np.cos(bow), 1.9 + 2.0 * np.sin(bow)], axis=1)])
    path = np.concatenate([path, np.stack([np.linspace(3.2, 9.2, 8), np.linspace(4.0, 4.45, 8)], axis=1)])
    angle = np.radians(6.0 * pose.handle - 0.45 * pose.slant)
    spin = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    half, thick = path @ spin, np.linspace(0.6, 0.72, len(path))
    flat = np.concatenate([half * [-1, 1] + [10.2, 5.9], (half + [-10.2, 5.9])[::-1]])
    grip = tube(np.column_stack([flat, np.full(len(flat), -0.5)]), np.concatenate([thick, thick[::-1]]), 14)
    hubs = [blob((0.9, 0.9, 1.0), 7, 16).shifted(x, 5.9, -0.5) for x in (10.2, -10.2)]
    return [part.named("handle") for part in (grip, *hubs)]


def _antenna(pose: RadioPose) -> list[Part]:
    angle = np.radians(14 + pose.antenna)
    way = np.array([-np.sin(angle), np.cos(angle), 0.0])
    foot, length = np.array([-11.6, 5.6, -2.2]), 7.2 * (1 + pose.reach)
    steps = np.array([0.0, 0.32, 0.33, 0.64, 0.65, 1.0])
    rod = tube(foot + length * steps[:, None] * way, np.array([0.3, 0.3, 0.22, 0.22, 0.14, 0.14]), 10)
    knob = blob((0.36, 0.36, 0.36), 7, 12).moved(lambda p: p + foot + length * way)
    base = blob((0.7, 0.6, 0.7), 7, 14).moved(lambda p: p + foot)
    return [part.named("antenna") for part in (rod, knob, base)]
