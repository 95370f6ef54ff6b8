"""Apple's 52 face blendshapes, in the order in which Live Link Face writes them.

Most faces recorded today are recorded in these terms, so this table is the hub
between file formats.  The words of a shape's name alone do not say which names are
pairs: `mouthSmileLeft` is the left half of a smile, `mouthLeft` is a whole mouth
moving left.  The table keeps that difference.
"""

from __future__ import annotations

from typing import Final

from mien.vocabularies.names import ShapeKey, shape_key

_EYE: Final = ("eyeBlink", "eyeLookDown", "eyeLookIn", "eyeLookOut", "eyeLookUp", "eyeSquint", "eyeWide")
_MOUTH_PAIRS: Final = ("mouthSmile", "mouthFrown", "mouthDimple", "mouthStretch")
_MOUTH_LIPS: Final = ("mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper")
_LIP_PAIRS: Final = ("mouthPress", "mouthLowerDown", "mouthUpperUp")


def _pairs(*stems: str) -> tuple[tuple[str, str], ...]:
    return tuple((stem, side) for stem in stems for side in ("Left", "Right"))


def _whole(*stems: str) -> tuple[tuple[str, str], ...]:
    return tuple((stem, "") for stem in stems)


ARKIT: Final[tuple[tuple[str, str], ...]] = (
    *((stem, "Left") for stem in _EYE),
    *((stem, "Right") for stem in _EYE),
    *_whole("jawForward", "jawRight", "jawLeft", "jawOpen"),
    *_whole("mouthClose", "mouthFunnel", "mouthPucker", "mouthRight", "mouthLeft"),
    *_pairs(*_MOUTH_PAIRS),
    *_whole(*_MOUTH_LIPS),
    *_pairs(*_LIP_PAIRS, "browDown"),
    *_whole("browInnerUp"),
    *_pairs("browOuterUp"),
    *_whole("cheekPuff"),
    *_pairs("cheekSquint", "noseSneer"),
    *_whole("tongueOut"),
)
"""Stem and side (`Left`, `Right` or empty) of each of the 52 shapes."""

ARKIT_NAMES: Final[tuple[str, ...]] = tuple(stem + side for stem, side in ARKIT)
"""The 52 names as Apple spells them."""

_BY_KEY: Final[dict[ShapeKey, str]] = {shape_key(name): name for name in ARKIT_NAMES}


def arkit_name(name: str) -> str | None:
    """Return Apple's spelling of a shape, or None if it is not one of the 52.

    Args:
        name: any spelling, e.g. `EyeBlinkLeft`, `eyeBlink_L` or `blendShape1.eye_blink_left`.
    """
    return _BY_KEY.get(shape_key(name))
