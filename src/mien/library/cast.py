"""Who acts in the demonstrations: bare heads, each rigged by moving the generic rig onto it.

None of these faces was given a single expression by hand.  All of them come from the
generic rig's bones, muscles and templates (Orvalho, Zacur, Susin); what differs is the
face.  The cartoon's shapes are then mixed and renamed, so that it has other names, ranges
and pairings than the actor, as characters from elsewhere do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np

from mien.core import Blendshapes, Rig
from mien.library.generic import generic_rig
from mien.library.heads import HEADS
from mien.rigging.baking import baked
from mien.rigging.transfer import Transfer, transfer_rig
from mien.vocabularies.arkit import ARKIT_NAMES
from mien.vocabularies.expressions import BLINKS, LAYER_EMOTIONS, VISEMES

EXTREMES = (*LAYER_EMOTIONS, *VISEMES, *BLINKS)
"""What the layers method needs of a character."""

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
"""The cartoon's own shapes as sums of ARKit ones."""


@cache
def rigged(name: str) -> Transfer:
    """Move the generic rig onto a head of the cast, a key of `HEADS`."""
    return transfer_rig(generic_rig(), HEADS[name]())


@cache
def cast_member(name: str, templates: tuple[str, ...]) -> Rig:
    """Return a head of the cast with these templates as blendshapes."""
    moved = rigged(name)
    shapes, _ = baked(moved, generic_rig(), templates)
    return replace(moved.rig, blendshapes=shapes, name=name)


def actor() -> Rig:
    """Return the actor: a human head with the ARKit shapes."""
    return _shapes_only(cast_member("actor", tuple(ARKIT_NAMES)))


def character() -> Rig:
    """Return the cartoon, with shapes of its own."""
    rig = _shapes_only(cast_member("cartoon", tuple(ARKIT_NAMES)))
    row = {name: k for k, name in enumerate(rig.blendshapes.names)}
    deltas = rig.blendshapes.deltas
    mixed = [
        np.sum([gain * deltas[row[part]] for part, gain in parts.items()], axis=0)
        for parts in CHARACTER_SHAPES.values()
    ]
    return replace(rig, blendshapes=Blendshapes(tuple(CHARACTER_SHAPES), np.stack(mixed)), name="character")


def _shapes_only(rig: Rig) -> Rig:
    """Return a rig that its blendshapes alone move."""
    return replace(rig, skeleton=None, skin=None, anatomy=None)
