"""Names of whole expressions: emotions after Plutchik, visemes, and blinks.

The emotions are Plutchik's wheel (1980): eight primaries in three degrees, and the
eight dyads between neighbours.  Kholgade, Matthews and Sheikh (2011, §3.1) use 29
extremes, the neutral among them, and do not name them; the four left out here are
mild degrees that a still face tells least apart.
"""

from __future__ import annotations

from typing import Final

PRIMARIES: Final[dict[str, tuple[str, str, str]]] = {
    "joy": ("serenity", "joy", "ecstasy"),
    "trust": ("acceptance", "trust", "admiration"),
    "fear": ("apprehension", "fear", "terror"),
    "surprise": ("distraction", "surprise", "amazement"),
    "sadness": ("pensiveness", "sadness", "grief"),
    "disgust": ("boredom", "disgust", "loathing"),
    "anger": ("annoyance", "anger", "rage"),
    "anticipation": ("interest", "anticipation", "vigilance"),
}
"""Each primary emotion in its mild, medium and strong degree, around the wheel."""

DYADS: Final[dict[str, tuple[str, str]]] = {
    "love": ("joy", "trust"),
    "submission": ("trust", "fear"),
    "awe": ("fear", "surprise"),
    "disapproval": ("surprise", "sadness"),
    "remorse": ("sadness", "disgust"),
    "contempt": ("disgust", "anger"),
    "aggressiveness": ("anger", "anticipation"),
    "optimism": ("anticipation", "joy"),
}
"""The emotions between two neighbouring primaries."""

EMOTIONS: Final[tuple[str, ...]] = (*(degree for three in PRIMARIES.values() for degree in three), *DYADS)
"""All 32."""

NEUTRAL: Final = "neutral"
LAYER_EMOTIONS: Final[tuple[str, ...]] = (
    NEUTRAL,
    *(name for name in EMOTIONS if name not in ("acceptance", "distraction", "boredom", "interest")),
)
"""The 29 extremes of the emotion layer."""

VISEMES: Final[dict[str, str]] = {
    "viseme_PP": "p, b, m",
    "viseme_FF": "f, v",
    "viseme_TH": "th",
    "viseme_DD": "t, d, n, l, k, g",
    "viseme_CH": "ch, j, sh",
    "viseme_SS": "s, z",
    "viseme_RR": "r",
    "viseme_aa": "ah",
    "viseme_E": "eh",
    "viseme_I": "ee",
    "viseme_O": "oh",
    "viseme_U": "oo, w",
}
"""Twelve mouth shapes and the sounds they stand for, in the names that avatars use."""

BLINKS: Final[tuple[str, ...]] = ("blink_open", "blink_half", "blink_closed")

LAYER_REGION: Final = "layer region"
"""The label of an anatomy that says which region a vertex is in: regions weigh the layers each for itself."""
