"""Mouth shapes of speech, and blinks, as action units; the choice of units is ours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

VISEME: Final[Mapping[str, Mapping[str, float]]] = {
    "viseme_PP": {"24": 0.7, "23": 0.2},
    "viseme_FF": {"32": 1.0, "10": 0.35, "26": 0.1},
    "viseme_TH": {"19": 0.42, "103": 0.15, "25": 0.8, "26": 0.494},
    "viseme_DD": {"25": 0.7, "26": 0.4, "103": 0.8},
    "viseme_CH": {"22": 0.75, "25": 0.4, "26": 0.12},
    "viseme_SS": {"20": 0.35, "25": 0.9, "26": 0.05},
    "viseme_RR": {"18": 0.45, "22": 0.3, "25": 0.3, "26": 0.2},
    "viseme_aa": {"27": 0.65, "25": 0.4},
    "viseme_E": {"26": 0.7, "20": 0.4, "25": 0.6},
    "viseme_I": {"12": 0.25, "20": 0.5, "25": 0.8, "26": 0.15},
    "viseme_O": {"22": 0.6, "18": 0.35, "26": 0.95},
    "viseme_U": {"18": 1.0, "22": 0.25, "26": 0.3},
}
"""Intensity of each action unit, by viseme."""

BLINK: Final[Mapping[str, Mapping[str, float]]] = {
    "blink_open": {"5": 0.5},
    "blink_half": {"45": 0.5},
    "blink_closed": {"45": 1.0},
}
"""The lids wide, half way, and shut."""
