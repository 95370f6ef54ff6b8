"""Cases from mien's own library: they run anywhere in a few seconds."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from mien.core import Clip, InputError, Rig
from mien.core.errors import unknown
from mien.evaluate.cases import Case, across, make_case
from mien.evaluate.conditions import Conditions
from mien.evaluate.people import person
from mien.evaluate.truth import semantics
from mien.library import actor, character, performance
from mien.library.cast import CHARACTER_SHAPES, EXTREMES, cast_member
from mien.library.expressions.scripts import SCRIPTS, Cue
from mien.library.expressions.scripts import scripted as acted
from mien.library.script import BEAT, FPS, RANGE_OF_MOTION
from mien.rigging.baking import scripted
from mien.vocabularies.arkit import ARKIT_NAMES

ACTING, SENTENCE = "acting", "sentence"
TAKES = (ACTING, SENTENCE)
CARTOON = "cartoon"


@dataclass(frozen=True)
class LibraryRecipe:
    """How a case is made of the library's cast.

    Attributes:
        person: number of the identity; 0 is the actor itself.
        character: `cartoon`, which has shapes of its own, or another of the cast, with the actor's.
        test: `acting`, in ARKit's shapes, or `sentence`, in emotions, visemes and blinks.
        spread: the range of each of the actor's shapes differs by up to this share, either way.
        conditions: of the capture.
    """

    person: int = 0
    character: str = CARTOON
    test: str = ACTING
    spread: float = 0.0
    conditions: Conditions = field(default_factory=Conditions)

    @property
    def actor(self) -> str:
        """Who acts."""
        return f"a{self.person}"

    @property
    def special(self) -> str:
        """What is unusual about it, in words for a table."""
        return " ".join([f"±{self.spread:.0%}"] * bool(self.spread) + list(self.conditions.special))


def library_case(recipe: LibraryRecipe, stride: int = 1, name: str = "") -> Case:
    """Make a case.

    Args:
        recipe: what to make.
        stride: the vertex error is measured at every so many frames.
        name: what to call it.

    Raises:
        InputError: the recipe names an unknown take.
    """
    if recipe.test not in TAKES:
        raise InputError(unknown("take of the library", recipe.test, TAKES))
    one, other, table = _cast(recipe.test, recipe.character)
    someone = person(one, recipe.person, recipe.spread) if recipe.person else one
    training, test = _takes(recipe.test)
    return make_case(
        name or f"{recipe.actor}>{recipe.character} {recipe.test}",
        someone,
        other,
        semantics(someone.blendshapes.names, other.blendshapes.names, table),
        across(someone, other, recipe.conditions.markers),
        training,
        test,
        recipe.conditions,
        stride=stride,
    )


def embedded_cases(stride: int = 1) -> list[Case]:
    """Return the library's actor playing on its cartoon: range of motion as training, acting as test."""
    hard = Conditions(markers=41, noise_mm=0.3, gaps=0.01, head=True)
    named = {"library": LibraryRecipe(), "library, 41 markers, head, gaps": LibraryRecipe(conditions=hard)}
    return [library_case(recipe, stride, name) for name, recipe in named.items()]


@cache
def _cast(take: str, other: str) -> tuple[Rig, Rig, dict[str, dict[str, float]] | None]:
    """Return actor and character, and what the character's shapes mean in the actor's where names do not say."""
    if take == SENTENCE:
        one, two = (_shapes_only(cast_member(name, EXTREMES)) for name in ("actor", other))
        return one, two, None
    if other == CARTOON:
        return actor(), character(), {name: dict(parts) for name, parts in CHARACTER_SHAPES.items()}
    return actor(), _shapes_only(cast_member(other, tuple(ARKIT_NAMES))), None


@cache
def _takes(take: str) -> tuple[Clip, Clip]:
    """Return what is shown for training, each extreme in turn, and what is then retargeted."""
    if take == ACTING:
        clip, _ = performance(actor())
        cut = round((0.4 + (len(RANGE_OF_MOTION) + 1) * BEAT) * FPS)
        values = np.asarray(clip.values)
        return Clip(clip.names, values[:cut], clip.fps), Clip(clip.names, values[cut:], clip.fps)
    shapes = cast_member("actor", EXTREMES).blendshapes
    cues = tuple(Cue(name, i * BEAT, i * BEAT + 1.6 * BEAT) for i, name in enumerate(shapes.names))
    return scripted(acted(cues, (len(cues) + 1) * BEAT), shapes), scripted(SCRIPTS["sentence"], shapes)


def _shapes_only(rig: Rig) -> Rig:
    """Return a rig that its blendshapes alone move."""
    return replace(rig, skeleton=None, skin=None, anatomy=None)
