"""Animation scripts: templates over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from mien.core import Clip
from mien.core.arrays import Floats
from mien.library.expressions.arkit import BASES
from mien.vocabularies.arkit import ARKIT_NAMES

FPS: Final = 60.0


class Cue(NamedTuple):
    """A template that rises, holds and falls: its start and end [s], strength, and how long it rises and falls [s]."""

    template: str
    start: float
    end: float
    strength: float = 1.0
    ramp: float = 0.1


SENTENCE: Final = "Wow. I had no idea you were into that!"

_SOUNDS: Final = (
    ("viseme_U", 0.45, 0.62),
    ("viseme_aa", 0.56, 0.85),
    ("viseme_U", 0.78, 1.0),
    ("viseme_aa", 1.55, 1.72),
    ("viseme_I", 1.66, 1.82),
    ("viseme_E", 1.8, 1.98),
    ("viseme_DD", 1.93, 2.05),
    ("viseme_DD", 2.03, 2.13),
    ("viseme_O", 2.1, 2.32),
    ("viseme_aa", 2.28, 2.44),
    ("viseme_I", 2.4, 2.54),
    ("viseme_DD", 2.5, 2.6),
    ("viseme_I", 2.56, 2.72),
    ("viseme_aa", 2.68, 2.82),
    ("viseme_I", 2.82, 2.92),
    ("viseme_U", 2.88, 3.06),
    ("viseme_RR", 3.0, 3.2),
    ("viseme_I", 3.16, 3.3),
    ("viseme_DD", 3.26, 3.38),
    ("viseme_U", 3.34, 3.5),
    ("viseme_TH", 3.46, 3.6),
    ("viseme_aa", 3.54, 3.78),
    ("viseme_DD", 3.74, 3.9),
)
"""Mouth shapes of the sentence with their start and end [s], at about five syllables a second."""

_CUES: Final = (
    Cue("surprise", 0.1, 1.55, 0.75, 0.25),
    Cue("interest", 1.25, 3.1, 1.0, 0.35),
    Cue("joy", 2.7, 5.2, 0.85, 0.5),
    Cue("blink_closed", 1.22, 1.47, 1.0, 0.1),
    Cue("blink_closed", 4.15, 4.4, 1.0, 0.1),
    *(Cue(name, start - 0.04, end + 0.04, 0.8, 0.08) for name, start, end in _SOUNDS),
)

_LENGTH: Final = 5.5
_BEAT: Final = 0.5


def rise_and_fall(time: Floats, cue: Cue) -> Floats:
    """Return a cue's strength over time: smooth up, held, smooth down."""
    ramp = np.clip(np.minimum(time - cue.start, cue.end - time) / cue.ramp, 0, 1)
    return np.asarray(cue.strength * ramp**3 * (ramp * (6 * ramp - 15) + 10))


def scripted(cues: tuple[Cue, ...], length: float) -> Clip:
    """Return the clip that plays some cues; where cues of one template overlap, the stronger counts."""
    time = np.arange(round(length * FPS) + 1) / FPS
    names = tuple(dict.fromkeys(cue.template for cue in cues))
    values = np.zeros((len(time), len(names)))
    for cue in cues:
        column = values[:, names.index(cue.template)]
        np.maximum(column, rise_and_fall(time, cue), out=column)
    return Clip(names, values, FPS)


def _range_of_motion() -> Clip:
    """Return each ARKit shape to its extreme and back, one after the other, on top of what it is meant on."""
    cues = [Cue(name, i * _BEAT, (i + 1) * _BEAT, 1.0, 0.2) for i, name in enumerate(ARKIT_NAMES)]
    under = [cues[ARKIT_NAMES.index(name)]._replace(template=base) for name, base in BASES.items()]
    return scripted((*cues, *under), len(cues) * _BEAT)


SCRIPTS: Final[Mapping[str, Clip]] = {
    "sentence": scripted(_CUES, _LENGTH),
    "range_of_motion": _range_of_motion(),
}
"""The sentence, with the feelings that go with it and two blinks; and every ARKit shape in turn."""
