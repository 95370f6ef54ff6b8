"""What the benchmark runs: every method on every scene.

A scene is one performance on one character under one set of conditions, acted by several
people, so that a figure comes with its spread over identities.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from mien.core import InputError
from mien.core.errors import unknown
from mien.evaluate.cases import Case
from mien.evaluate.collection import FULL, Recipe, made
from mien.evaluate.conditions import Conditions
from mien.evaluate.embedded import SENTENCE, LibraryRecipe, library_case
from mien.evaluate.played import REFERENCES
from mien.retargeting import METHODS
from mien.retargeting.method import Method

AnyRecipe = Recipe | LibraryRecipe
PEOPLE = "people"
HARD = Conditions(markers=41, noise_mm=0.3, gaps=0.01, head=True)
STRIDE = 4
"""The vertex error is measured at every so many frames."""


@dataclass(frozen=True)
class Entrant:
    """A method with its settings.

    Attributes:
        name: what it is called in the table.
        method: a key of `METHODS`, one of `REFERENCES`, or a method made elsewhere.
        settings: parameters by name.
    """

    name: str
    method: str | Method
    settings: Mapping[str, Any] = field(default_factory=dict)


class Row(NamedTuple):
    """One line of the table."""

    method: str
    performance: str
    character: str
    conditions: str
    identities: tuple[str, ...]


@dataclass(frozen=True)
class Scene:
    """Recipes that differ only in who acts.

    Attributes:
        recipes: one per identity.
        quick: whether it belongs to the quick suite.
    """

    recipes: tuple[AnyRecipe, ...]
    quick: bool = False

    @property
    def real(self) -> bool:
        """Whether it needs the real rigs and recordings."""
        return isinstance(self.recipes[0], Recipe)

    @property
    def identities(self) -> tuple[str, ...]:
        """Who acts."""
        return tuple(recipe.actor for recipe in self.recipes)

    @property
    def performance(self) -> str:
        """What is acted, and by whom where that is not just anyone."""
        one = self.recipes[0]
        return one.test if _anyone(one) else f"{one.test} by {one.actor}"

    @property
    def character(self) -> str:
        """Who plays it back."""
        return self.recipes[0].character

    @property
    def conditions(self) -> str:
        """What is unusual, in words; `usual` if nothing: 99 points, 0.2 mm of noise, no gaps, a still head."""
        return self.recipes[0].special or "usual"

    @property
    def name(self) -> str:
        """What it is called in tables."""
        return f"{self.performance} > {self.character}, {self.conditions}"

    def row(self, method: str) -> Row:
        """Return the line of a method."""
        return Row(method, self.performance, self.character, self.conditions, self.identities)

    def cases(self, folder: Path | None, stride: int = STRIDE) -> Iterator[tuple[str, Case]]:
        """Make the cases, one identity after another (they are large)."""
        for recipe in self.recipes:
            if isinstance(recipe, LibraryRecipe):
                yield recipe.actor, library_case(recipe, stride)
            else:
                assert folder is not None
                yield recipe.actor, made(folder, recipe, stride)


def _anyone(recipe: AnyRecipe) -> bool:
    """Return whether the actor is one of the people who exist only as numbers."""
    return isinstance(recipe, LibraryRecipe) or recipe.actor.startswith("p")


def _library(count: int, *recipes: LibraryRecipe, quick: bool = False) -> tuple[Scene, ...]:
    return tuple(Scene(tuple(replace(r, person=i + 1) for i in range(count)), quick) for r in recipes)


def _collection(quick: Sequence[Recipe], full: Sequence[Recipe]) -> tuple[Scene, ...]:
    """Group the cases of the accuracy suite by everything but the person."""
    grouped: dict[Recipe, list[Recipe]] = {}
    for recipe in full:
        grouped.setdefault(replace(recipe, actor=PEOPLE) if _anyone(recipe) else recipe, []).append(recipe)
    return tuple(Scene(tuple(group), bool(set(group) & set(quick))) for group in grouped.values())


QUICK_REAL = (Recipe("p1", "toon", "apfel", 0.3), Recipe("adult", "ict"))
"""Members of the groups that the quick suite runs where the real data is."""

SCENES: tuple[Scene, ...] = (
    *_library(
        3,
        LibraryRecipe(),
        LibraryRecipe(character="goat", spread=0.3, conditions=HARD),
        LibraryRecipe(character="tortoise", test=SENTENCE),
        quick=True,
    ),
    *_library(
        5,
        LibraryRecipe(spread=0.3),
        LibraryRecipe(spread=0.3, conditions=HARD),
        LibraryRecipe(conditions=Conditions(noise_mm=0.5)),
        LibraryRecipe(character="goat", spread=0.3),
        LibraryRecipe(character="tortoise", spread=0.3),
        LibraryRecipe(character="cartoon", test=SENTENCE),
        LibraryRecipe(character="goat", test=SENTENCE, spread=0.3, conditions=HARD),
    ),
    *_collection(QUICK_REAL, FULL),
)
"""Every performance, character and condition."""

VARIANTS: Mapping[str, tuple[str, Mapping[str, Any]]] = {"paper": ("range-of-motion", {"preset": "paper"})}
"""Methods with other settings than their own, by name."""


def entrants(wanted: Sequence[str] = ()) -> tuple[Entrant, ...]:
    """Return the methods that take part: the references, every method, and the variants; or only those named.

    Raises:
        InputError: an unknown name.
    """
    every = {name: Entrant(name, name) for name in (*REFERENCES, *METHODS)}
    every |= {name: Entrant(name, method, settings) for name, (method, settings) in VARIANTS.items()}
    for name in wanted:
        if name not in every:
            raise InputError(unknown("method of the benchmark", name, every))
    return tuple(every[name] for name in wanted) if wanted else tuple(every.values())


def scenes(*, full: bool, real: bool, words: Sequence[str] = ()) -> tuple[Scene, ...]:
    """Return the scenes of a suite.

    Args:
        full: all, and not the quick ones alone.
        real: whether the real rigs and recordings are there.
        words: only scenes whose names hold all of them.

    Raises:
        InputError: no scene is left.
    """
    at_hand = [s for s in SCENES if (full or s.quick) and (real or not s.real)]
    found = tuple(s for s in at_hand if all(word in s.name for word in words))
    if not found:
        raise InputError(
            f"no case of the suite holds all of the words {' '.join(words)!r}; there are: {'; '.join(s.name for s in at_hand)}."
        )
    return found


def rows(suite: Sequence[Scene], methods: Sequence[Entrant]) -> tuple[Row, ...]:
    """Return the table: every scene with every method."""
    return tuple(scene.row(entrant.name) for scene in suite for entrant in methods)
