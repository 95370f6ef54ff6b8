"""The 52 ARKit shapes as action units: each is one movement, so most are one unit of one side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

_SIDED: Final[dict[str, dict[str, float]]] = {
    "eyeBlink": {"45": 1.0},
    "eyeLookDown": {"64": 1.0},
    "eyeLookUp": {"63": 1.0},
    "eyeSquint": {"7": 1.0},
    "eyeWide": {"5": 1.0},
    "mouthSmile": {"12": 1.0},
    "mouthFrown": {"15": 1.0},
    "mouthDimple": {"14": 1.0},
    "mouthStretch": {"20": 1.0},
    "mouthPress": {"24": 0.8, "17": 0.5, "12": 0.2},
    "mouthLowerDown": {"16": 1.0},
    "mouthUpperUp": {"10": 1.0},
    "browDown": {"4": 1.0},
    "browOuterUp": {"2": 1.0},
    "cheekSquint": {"6": 1.0},
    "noseSneer": {"9": 1.0},
    "jaw": {"30": 1.0},
    "mouth": {"101": 1.0},
}
"""Shapes that end in `Left` or `Right`."""

_WHOLE: Final[dict[str, dict[str, float]]] = {
    "eyeLookInLeft": {"L62": 1.0},
    "eyeLookOutLeft": {"L61": 1.0},
    "eyeLookInRight": {"R61": 1.0},
    "eyeLookOutRight": {"R62": 1.0},
    "jawForward": {"29": 1.0},
    "jawOpen": {"27": 1.0},
    "mouthClose": {"8": 1.0},
    "mouthFunnel": {"22": 1.0},
    "mouthPucker": {"18": 1.0},
    "mouthRollLower": {"B28": 1.0},
    "mouthRollUpper": {"T28": 1.0},
    "mouthShrugLower": {"17": 1.0},
    "mouthShrugUpper": {"102": 1.0},
    "browInnerUp": {"1": 0.65},
    "cheekPuff": {"34": 1.0},
    "tongueOut": {"19": 1.0},
}

SHAPES: Final[Mapping[str, Mapping[str, float]]] = _WHOLE | {
    stem + side: {side[0] + code: value for code, value in units.items()}
    for stem, units in _SIDED.items()
    for side in ("Left", "Right")
}
"""Intensity of each action unit, by shape."""

BASES: Final[dict[str, str]] = {"mouthClose": "jawOpen", "tongueOut": "jawOpen"}
"""Closing the lips and showing the tongue are meant while the jaw is open, and leave it where it is."""
