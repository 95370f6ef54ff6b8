"""Who is in the library: an actor with human proportions, and a cartoon that is nothing like them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mien.core import Blendshapes, Mesh, Rig
from mien.core.arrays import Floats
from mien.library.generic.head import build
from mien.library.generic.measures import Eye, Measures, Mouth
from mien.library.landmarks import landmarks
from mien.library.modelling.half import Head
from mien.library.modelling.solids import Ball, Bar
from mien.library.shapes import arkit_shapes

CENTIMETRE = 0.01

ACTOR = Measures(
    solids=(
        Ball((0, 3.2, -1.2), (7.2, 8.3, 9.4), 1),
        Ball((0, -3.8, 2.0), (5.9, 6.6, 6.3), 3.0),
        Bar((0.0, -8, -2.4), (0.0, -17, -3.4), (4.2, 5.0), 2.0),
        Bar((1.5, -9.8, 5.7), (4.7, -6.2, -0.4), (1.4, 1.1), 2.0),
        Bar((4.7, -6.2, -0.4), (5.5, -1.5, -1.2), (1.1, 0.9), 2.5),
        Ball((0, -9.9, 6.6), (1.8, 1.6, 1.7), 1.8),
        Ball((0, -6.6, 6.6), (3.2, 2.4, 2.1), 1.8),
        Ball((3.3, -4.6, 4.5), (2.3, 2.8, 2.7), 2.2),
        Bar((4.0, -2.4, 5.6), (5.8, -1.2, 2.4), (1.2, 0.8), 2.0),
        Bar((1.0, 1.8, 7.7), (4.4, 2.1, 5.9), (0.9, 0.55), 1.8),
        Ball((3.1, -0.1, 9.3), (2.1, 1.35, 1.9), 1.3, carve=True),
        Bar((0, 1.0, 7.9), (0, -3.1, 9.3), (0.6, 0.75), 1.5),
        Ball((0, -3.3, 9.5), (0.85, 0.8, 0.9), 0.9),
        Ball((1.0, -3.75, 8.6), (0.75, 0.65, 1.0), 0.6),
        Ball((3.2, 0, 6.0), (1.68, 1.68, 1.68), 0.5),
        Ball((6.9, 0.1, -1.6), (0.95, 2.4, 1.4), 0.6),
        Ball((7.8, 0.3, -1.1), (0.7, 1.5, 0.8), 0.4, carve=True),
    ),
    eye=Eye(
        centre=(3.2, 0, 6.0), radius=1.5, half_width=1.42, upper=0.55, lower=0.42, tilt=0.08, clearance=0.07, iris=0.62
    ),
    mouth=Mouth(height=-6.7, half_width=2.5, lift=0.05, upper=0.75, lower=0.95, fullness=0.35),
    brow=((1.3, 1.9), (3.4, 2.35), (5.0, 1.75), (0.32, 0.16)),
    teeth=(2.6, 0.9, 7.85, 2.8),
    centre=(0, -2.0, -1.0),
    hinge=(-1.0, -0.5),
    neck=-14.0,
    spacing=(3.3, 9.0),
    places={
        "glabella": (0, 1.9, 8.5),
        "nasion": (0, 0.7, 8.3),
        "nose_tip": (0, -3.3, 10.4),
        "subnasale": (0, -4.4, 8.8),
        "wing": (1.55, -3.8, 8.6),
        "chin_tip": (0, -10.4, 8.3),
        "gonion_left": (5.4, -6.8, -0.2),
        "zygion_left": (6.5, -1.2, 3.2),
        "cheek_left": (3.9, -3.8, 7.0),
        "forehead_centre": (0, 5.8, 8.0),
    },
)

CHARACTER = Measures(
    solids=(
        Ball((0, 4.0, -1.0), (9.6, 9.4, 9.6), 1),
        Ball((0, -3.4, 2.2), (7.6, 5.6, 6.0), 3.5),
        Bar((0.0, -6, -2.0), (0.0, -16, -2.4), (3.0, 3.2), 2.0),
        Ball((0, -7.4, 5.2), (2.4, 1.6, 2.2), 2.0),
        Ball((0, -4.6, 5.4), (4.4, 2.4, 2.8), 2.4),
        Ball((5.0, -3.2, 4.2), (2.5, 2.4, 2.6), 2.4),
        Ball((4.1, 1.4, 10.0), (3.2, 3.2, 2.2), 1.5, carve=True),
        Ball((0, -1.6, 9.2), (1.25, 1.0, 1.25), 1.2),
        Ball((4.1, 1.4, 5.4), (3.28, 3.28, 3.28), 0.8),
        Ball((9.4, -0.4, -0.8), (1.3, 2.4, 1.2), 0.8),
        Ball((10.4, -0.3, -0.4), (0.8, 1.4, 0.7), 0.4, carve=True),
    ),
    eye=Eye(
        centre=(4.1, 1.4, 5.4),
        radius=2.75,
        half_width=2.3,
        upper=1.95,
        lower=1.5,
        tilt=0.1,
        clearance=0.35,
        iris=1.5,
        points=30,
    ),
    mouth=Mouth(height=-4.9, half_width=3.9, lift=0.7, upper=0.6, lower=0.8, fullness=0.3, points=29),
    brow=((1.7, 5.3), (4.4, 6.2), (6.6, 5.0), (0.5, 0.3)),
    teeth=(3.6, 1.0, 7.7, 2.2),
    centre=(0, -0.5, -1.0),
    hinge=(-1.0, -0.5),
    neck=-11.5,
    places={
        "glabella": (0, 4.6, 9.0),
        "nasion": (0, 1.2, 8.0),
        "nose_tip": (0, -1.6, 10.6),
        "subnasale": (0, -2.7, 8.9),
        "wing": (1.2, -1.8, 9.2),
        "chin_tip": (0, -7.6, 7.4),
        "gonion_left": (6.3, -6.0, 1.0),
        "zygion_left": (8.2, -1.4, 3.6),
        "cheek_left": (5.2, -2.9, 6.6),
        "forehead_centre": (0, 8.6, 7.6),
    },
    spacing=(3.6, 9.5),
)

CHARACTER_SHAPES: Mapping[str, Mapping[str, float]] = {
    "Jaw_Open": {"jawOpen": 1.15},
    "Jaw_Side_L": {"jawLeft": 1.4},
    "Jaw_Side_R": {"jawRight": 1.4},
    "Lips_Seal": {"mouthClose": 1.15},
    "Grin_L": {"mouthSmileLeft": 1.15, "cheekSquintLeft": 0.5},
    "Grin_R": {"mouthSmileRight": 1.15, "cheekSquintRight": 0.5},
    "Sad_Mouth": {"mouthFrownLeft": 1.3, "mouthFrownRight": 1.3},
    "Kiss": {"mouthPucker": 0.8},
    "Ooh": {"mouthFunnel": 0.9},
    "Mouth_Wide": {"mouthStretchLeft": 0.7, "mouthStretchRight": 0.7},
    "Upper_Lip_Raise": {"mouthUpperUpLeft": 0.9, "mouthUpperUpRight": 0.9},
    "Lower_Lip_Drop_L": {"mouthLowerDownLeft": 0.8},
    "Lower_Lip_Drop_R": {"mouthLowerDownRight": 0.8},
    "Lips_Tight": {"mouthPressLeft": 1.2, "mouthPressRight": 1.2},
    "Mouth_Shift_L": {"mouthLeft": 1.2},
    "Mouth_Shift_R": {"mouthRight": 1.2},
    "Pout": {"mouthShrugLower": 1.5},
    "Balloon_Cheeks": {"cheekPuff": 0.9},
    "Snarl": {"noseSneerLeft": 0.7, "noseSneerRight": 0.7},
    "Worry_Brows": {"browInnerUp": 0.8},
    "Angry_Brow_L": {"browDownLeft": 0.9},
    "Angry_Brow_R": {"browDownRight": 0.9},
    "Raise_Brow_L": {"browOuterUpLeft": 0.9, "browInnerUp": 0.2},
    "Raise_Brow_R": {"browOuterUpRight": 0.9, "browInnerUp": 0.2},
    "Blink_L": {"eyeBlinkLeft": 1.0},
    "Blink_R": {"eyeBlinkRight": 1.0},
    "Eyes_Wide": {"eyeWideLeft": 0.6, "eyeWideRight": 0.6},
    "Eyes_Narrow": {"eyeSquintLeft": 0.9, "eyeSquintRight": 0.9},
    "Look_Up": {"eyeLookUpLeft": 0.8, "eyeLookUpRight": 0.8},
    "Look_Down": {"eyeLookDownLeft": 0.8, "eyeLookDownRight": 0.8},
    "Look_L": {"eyeLookOutLeft": 0.7, "eyeLookInRight": 0.7},
    "Look_R": {"eyeLookOutRight": 0.7, "eyeLookInLeft": 0.7},
}
"""The cartoon's own shapes as sums of ARKit ones: other names, ranges and pairings than the actor's."""


def actor() -> Rig:
    """Make the actor: a human face with the ARKit shapes, 23 cm from chin to crown."""
    head = build(ACTOR)
    return _rig("actor", ACTOR, head, arkit_shapes(ACTOR, head))


def character() -> Rig:
    """Make the cartoon: large eyes and cranium, wide mouth, and shapes of its own."""
    head = build(CHARACTER)
    shapes = arkit_shapes(CHARACTER, head)
    mixed = {
        name: sum((gain * shapes[part] for part, gain in parts.items()), np.zeros_like(head.vertices))
        for name, parts in CHARACTER_SHAPES.items()
    }
    return _rig("character", CHARACTER, head, mixed)


def _rig(name: str, measures: Measures, head: Head, shapes: Mapping[str, Floats]) -> Rig:
    return Rig(
        Mesh(head.vertices * CENTIMETRE, head.triangles, groups=head.groups),
        Blendshapes(tuple(shapes), np.stack(list(shapes.values())) * CENTIMETRE),
        landmarks=landmarks(measures, head),
        name=name,
    )
