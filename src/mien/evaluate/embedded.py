"""A small case from mien's own library: runs anywhere in a few seconds."""

from __future__ import annotations

from mien.core import Clip
from mien.evaluate.cases import Case, across, make_case
from mien.evaluate.conditions import Conditions
from mien.evaluate.truth import semantics
from mien.library import actor, character, performance
from mien.library.cast import CHARACTER_SHAPES
from mien.library.script import BEAT, FPS, RANGE_OF_MOTION


def embedded_cases(stride: int = 1) -> list[Case]:
    """Return the library's actor playing on its cartoon: range of motion as training, acting as test."""
    person, cartoon = actor(), character()
    clip, _ = performance(person)
    cut = round((0.4 + (len(RANGE_OF_MOTION) + 1) * BEAT) * FPS)
    training, test = (Clip(clip.names, clip.values[part], clip.fps) for part in (slice(0, cut), slice(cut, None)))
    meanings = semantics(person.blendshapes.names, cartoon.blendshapes.names, CHARACTER_SHAPES)
    cases = []
    for name, conditions in (
        ("library", Conditions()),
        ("library, 41 markers, head, gaps", Conditions(markers=41, noise_mm=0.3, gaps=0.01, head=True)),
    ):
        pairs = across(person, cartoon, conditions.markers)
        cases.append(make_case(name, person, cartoon, meanings, pairs, training, test, conditions, stride=stride))
    return cases
