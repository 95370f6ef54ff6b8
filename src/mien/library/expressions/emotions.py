"""Plutchik's 32 emotions as action units.

Six emotions have a prototype (Ekman, Friesen and Hager 2002): the units at the core of
joy, fear, surprise, sadness, disgust and anger are those.  Contempt's is the one-sided
dimpler (Ekman and Friesen 1986).  Their degrees, and what is added to them (heavy lids,
an open mouth, a frown), are ours.  Nobody has published prototypes for the rest: they
are ours, and say so.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

PROTOTYPE: Final = "Ekman, Friesen and Hager 2002"
DIMPLER: Final = "Ekman and Friesen 1986"
OURS: Final = "ours"


class Expression(NamedTuple):
    """Intensities of action units, 0 to 1, and where the choice of units comes from."""

    units: Mapping[str, float]
    source: str = OURS


def _degrees(source: str, **names: Mapping[str, float]) -> dict[str, Expression]:
    return {name: Expression(units, source) for name, units in names.items()}


PRIMARY: Final[dict[str, Expression]] = {
    **_degrees(
        PROTOTYPE,
        serenity={"12": 0.5, "6": 0.35},
        joy={"12": 0.9, "6": 0.8, "25": 0.6},
        ecstasy={"12": 1.0, "6": 1.0, "25": 1.0, "26": 0.75, "1": 0.25, "2": 0.25},
    ),
    **_degrees(
        OURS,
        acceptance={"12": 0.2, "1": 0.2, "43": 0.1},
        trust={"12": 0.4, "1": 0.35, "2": 0.1, "6": 0.2},
        admiration={"12": 0.55, "1": 0.7, "2": 0.5, "5": 0.25, "6": 0.2, "25": 0.4, "63": 0.25},
    ),
    **_degrees(
        PROTOTYPE,
        apprehension={"1": 0.5, "2": 0.2, "4": 0.3, "5": 0.25, "20": 0.25},
        fear={"1": 0.85, "2": 0.4, "4": 0.45, "5": 0.7, "20": 0.65, "25": 0.5, "26": 0.25},
        terror={"1": 1.0, "2": 0.6, "4": 0.5, "5": 1.0, "20": 1.0, "25": 0.8, "27": 0.6},
    ),
    **_degrees(
        PROTOTYPE,
        distraction={"1": 0.4, "2": 0.4, "5": 0.2, "25": 0.2},
        surprise={"1": 0.8, "2": 0.8, "5": 0.55, "26": 0.9, "25": 0.1},
        amazement={"1": 1.0, "2": 1.0, "5": 0.9, "27": 0.9},
    ),
    **_degrees(
        PROTOTYPE,
        pensiveness={"1": 0.45, "4": 0.2, "15": 0.35, "64": 0.3, "43": 0.1},
        sadness={"1": 0.8, "4": 0.4, "15": 0.7, "17": 0.35, "64": 0.25, "43": 0.15},
        grief={"1": 1.0, "4": 0.6, "15": 1.0, "17": 0.6, "6": 0.5, "20": 0.35, "25": 0.5, "43": 0.4},
    ),
    "boredom": Expression({"43": 0.45, "15": 0.35, "17": 0.25, "1": 0.1}),
    **_degrees(
        PROTOTYPE,
        disgust={"9": 0.7, "10": 0.5, "4": 0.35, "15": 0.3, "17": 0.35, "7": 0.3},
        loathing={"9": 1.0, "10": 0.9, "4": 0.7, "16": 0.6, "25": 0.6, "26": 0.35, "7": 0.6, "6": 0.3},
    ),
    **_degrees(
        PROTOTYPE,
        annoyance={"4": 0.5, "7": 0.3, "23": 0.4},
        anger={"4": 1.0, "5": 0.3, "7": 0.7, "23": 0.5, "24": 0.5, "17": 0.4},
        rage={"4": 1.0, "5": 0.75, "7": 0.5, "9": 0.6, "10": 0.8, "16": 0.7, "20": 0.4, "25": 0.8, "26": 0.9},
    ),
    **_degrees(
        OURS,
        interest={"1": 0.3, "2": 0.4, "5": 0.15, "12": 0.2},
        anticipation={"1": 0.35, "2": 0.55, "5": 0.4, "12": 0.3, "25": 0.2},
        vigilance={"4": 0.6, "1": 0.3, "2": 0.9, "5": 1.0, "23": 0.6, "38": 0.6, "15": 0.25},
    ),
}
"""The eight primaries in three degrees."""

DYAD: Final[dict[str, Expression]] = {
    "love": Expression({"12": 0.6, "6": 0.5, "1": 0.4, "43": 0.25}),
    "submission": Expression({"1": 0.6, "64": 0.75, "43": 0.15, "15": 0.3, "24": 0.4}),
    "awe": Expression({"1": 0.9, "2": 0.6, "5": 0.8, "26": 0.7, "25": 0.3, "63": 0.3}),
    "disapproval": Expression({"L2": 0.9, "L1": 0.3, "R4": 0.5, "15": 0.7, "17": 0.6, "43": 0.1}),
    "remorse": Expression({"1": 0.9, "4": 0.5, "15": 0.6, "17": 0.5, "64": 0.8, "24": 0.3}),
    "contempt": Expression({"L14": 1.0, "L12": 0.6, "43": 0.25, "R2": 0.4, "L4": 0.3, "17": 0.2}, DIMPLER),
    "aggressiveness": Expression({"4": 1.0, "5": 0.6, "9": 0.5, "10": 0.6, "16": 0.8, "25": 0.6, "29": 0.7, "38": 0.6}),
    "optimism": Expression({"12": 0.7, "6": 0.35, "1": 0.45, "2": 0.5, "5": 0.2, "25": 0.35, "63": 0.3}),
}
"""The emotions between neighbours on the wheel."""
