"""A small case from mien's own library: runs anywhere in a few seconds."""

from __future__ import annotations

import numpy as np

from mien.core import Clip
from mien.evaluate.cases import Case, across, make_case
from mien.evaluate.conditions import Conditions
from mien.evaluate.truth import semantics
from mien.library import actor, character, performance
from mien.library.cast import CHARACTER_SHAPES
from mien.library.script import BEAT, FPS, RANGE_OF_MOTION

UNSEEN_BY_MARKERS = ("Look_Up", "Look_Down", "Look_L", "Look_R")


def embedded_cases(stride: int = 1) -> list[Case]:
    """Return the library's actor playing on its cartoon: range of motion as training, acting as test."""
    person, cartoon = actor(), character()
    clip, _ = performance(person)
    pairs = across(person, cartoon, 99)
    cut = round((0.4 + (len(RANGE_OF_MOTION) + 1) * BEAT) * FPS)
    training, test = (Clip(clip.names, clip.values[part], clip.fps) for part in (slice(0, cut), slice(cut, None)))
    meanings = semantics(person.blendshapes.names, cartoon.blendshapes.names, CHARACTER_SHAPES)
    cases = []
    for name, conditions in (
        ("library", Conditions()),
        ("library, 41 markers, head, gaps", Conditions(markers=41, noise_mm=0.3, gaps=0.01, head=True)),
    ):
        used = pairs if conditions.markers >= len(pairs) else pairs.take(_some(len(pairs), conditions.markers))
        cases.append(make_case(name, person, cartoon, meanings, used, training, test, conditions, stride=stride))
    return cases


def _some(count: int, wanted: int) -> np.ndarray:
    return np.linspace(0, count - 1, wanted).round().astype(np.int64)
