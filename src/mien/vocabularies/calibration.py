"""The expressions of a calibration take, in the order in which an actor is asked for them.

docs/calibration-take.md says what to tell the actor; this is what the face then shows, in
Apple's shapes, so that such a take can be played, and a recorded one be labelled by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from mien.core.arrays import Floats
from mien.vocabularies.arkit import ARKIT_NAMES

EXPRESSIONS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "jawOpen": "jawOpen",
        "jawLeft": "jawLeft",
        "jawRight": "jawRight",
        "jawForward": "jawForward",
        "mouthLeft": "mouthLeft",
        "mouthRight": "mouthRight",
        "mouthPucker": "mouthPucker",
        "mouthFunnel": "mouthFunnel",
        "mouthSmileLeft": "mouthSmileLeft mouthDimpleLeft=.3",
        "mouthSmileRight": "mouthSmileRight mouthDimpleRight=.3",
        "mouthSmile": "mouthSmile* cheekSquint*=.6",
        "mouthStretch": "mouthStretch*",
        "mouthFrown": "mouthFrown* mouthShrugLower=.3",
        "mouthShrug": "mouthShrugLower mouthShrugUpper=.7",
        "mouthUpperUp": "mouthUpperUp* noseSneer*",
        "mouthLowerDown": "mouthLowerDown*",
        "mouthRoll": "mouthRollUpper mouthRollLower",
        "mouthPress": "mouthPress* mouthDimple*",
        "mouthClose": "jawOpen=.6 mouthClose=.6",
        "cheekPuff": "cheekPuff",
        "eyeBlink": "eyeBlink*",
        "eyeWide": "eyeWide* browInnerUp=.6 browOuterUp*=.6",
        "eyeSquint": "eyeSquint* cheekSquint*",
        "browUp": "browInnerUp browOuterUp*",
        "browDown": "browDown*",
        "eyeLookUp": "eyeLookUp*",
        "eyeLookDown": "eyeLookDown*",
        "eyeLookLeft": "eyeLookOutLeft eyeLookInRight",
        "eyeLookRight": "eyeLookInLeft eyeLookOutRight",
    }
)
"""What each is called, and its shapes; a star stands for both sides, a number for what accompanies it less strongly."""


def list_weights() -> Floats:
    """Return the weights of Apple's shapes in each expression of the list, `(29, 52)`."""
    return np.array([_weights(shapes) for shapes in EXPRESSIONS.values()])


def _weights(shapes: str) -> Floats:
    full = np.zeros(len(ARKIT_NAMES))
    for word in shapes.split():
        name, _, amount = word.partition("=")
        for side in ("Left", "Right") if name.endswith("*") else ("",):
            full[ARKIT_NAMES.index(name.rstrip("*") + side)] = float(amount or 1)
    return full
