"""One actor, and characters less and less like them, with the right answer for each.

The real ones are a person of ICT's identities, who acts, and ICT's own face, MakeHuman's adult and
child, and a caricature.  The embedded ones are the built-in actor, and the cartoon, tortoise and goat of the
cast with the actor's shapes, moved there by rig transfer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np

from benchmarks.paper_figures.rig_transfer.faces import Settings
from mien.core import Clip
from mien.core.arrays import Floats, Ints
from mien.evaluate import Case
from mien.evaluate.cases import across, make_case, on_actor
from mien.evaluate.collection import Recipe, made
from mien.evaluate.conditions import Conditions
from mien.evaluate.truth import semantics
from mien.library import actor, performance
from mien.library.cast import cast_member
from mien.library.script import BEAT, FPS, RANGE_OF_MOTION
from mien.retargeting.example_based import ExampleBased
from mien.retargeting.initial import warped_shapes
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.settings import SolveSettings
from mien.retargeting.shape_retargeter import shape_retargeter
from mien.retargeting.spacetime import SpacetimeRetargeter
from mien.vocabularies.arkit import ARKIT_NAMES

STRIDE = 8
"""The vertex error is measured at every so many frames."""
REAL = ("ict", "adult", "child", "toon")
CAST = ("cartoon", "tortoise", "goat")


def cases(settings: Settings) -> Iterator[Case]:
    """Return the cases, one at a time, realistic characters first."""
    real = () if settings.data is None else REAL[:1] + REAL[3:] if settings.quick else REAL
    for character in real:
        yield _real(settings, character)
    for character in CAST[:1] if settings.quick else CAST:
        yield _embedded(character)


def name_of(case: Case) -> str:
    """Return what a case's character is called."""
    return case.name.split(">")[-1].split()[0]


def unlikeness(case: Case) -> float:
    """Return what is left between actor and character after scale and turn, over the face's radius."""
    return case.prepared.terms.placement.residual


def frames_of(case: Case, count: int) -> Ints:
    """Return frames of the test that are strong, and unlike each other."""
    values = np.asarray(case.truth_range.values)
    strength = np.linalg.norm(values, axis=1)
    strong = np.flatnonzero(strength > np.quantile(strength, 0.7))
    chosen = [int(strong[np.argmax(strength[strong])])]
    while len(chosen) < count:
        apart = np.linalg.norm(values[strong][:, None] - values[chosen][None], axis=2).min(axis=1)
        chosen.append(int(strong[np.argmax(apart)]))
    return np.sort(np.array(chosen, dtype=np.int64))


def acted(case: Case) -> Floats:
    """Return the weights of the actor's own rig in the test, `(F, J)`."""
    return np.asarray(on_actor(case.recording, case.actor).values)


@cache
def found_shapes(case: Case) -> Mapping[str, Floats]:
    """Return the actor's shapes by how they are found, `(K, M, 3)` [cm].

    `ours` are those of the default, `aligned` the published ones, `EBFR` the example-based ones.
    """
    return {
        "own": case.prepared.terms.deltas,
        "RBF": warped_shapes(case.prepared.terms),
        "EBFR": ExampleBased().rig(case.prepared, case.character)[1].shapes,
        "aligned": RangeOfMotion(shapes="alignment").align(case.prepared, case.character).personal,
        "ours": RangeOfMotion().align(case.prepared, case.character).personal,
    }


def solved(case: Case, shapes: Floats, settings: Mapping[str, Any], velocity: float | None = None) -> Clip:
    """Return a case's test on its character.

    Args:
        case: the case.
        shapes: the actor's, `(K, M, 3)` [cm].
        settings: of the solve.
        velocity: λ of a solve over the whole clip; frame by frame if None.
    """
    fitted = shape_retargeter("shapes", case.character, case.prepared, shapes, SolveSettings(**settings))
    if velocity is not None:
        fitted = SpacetimeRetargeter.of(fitted, velocity)
    return fitted.retarget(case.test)[0]


@cache
def _real(settings: Settings, character: str) -> Case:
    assert settings.data is not None
    return made(settings.data, Recipe("p1", character), STRIDE)


@cache
def _embedded(character: str) -> Case:
    person, rig = actor(), cast_member(character, tuple(ARKIT_NAMES))
    clip, _ = performance(person)
    cut = round((0.4 + (len(RANGE_OF_MOTION) + 1) * BEAT) * FPS)
    training, test = (Clip(clip.names, clip.values[part], clip.fps) for part in (slice(0, cut), slice(cut, None)))
    meanings = semantics(person.blendshapes.names, rig.blendshapes.names)
    conditions = Conditions()
    pairs = across(person, rig, conditions.markers)
    name = f"actor>{character}"
    return make_case(name, person, rig, meanings, pairs, training, test, conditions, stride=STRIDE)
