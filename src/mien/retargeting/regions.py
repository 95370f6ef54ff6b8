"""Regions of the face learned apart and joined: few labels then cannot tie the brows to the jaw.

The discussion of Bouaziz and Pauly 2014, after Tena et al. 2011; for any model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from mien.core import InputError, Note
from mien.core.arrays import Floats, Ints
from mien.retargeting.samples import Learner, Learnt, Samples


@runtime_checkable
class KnowsPoses(Protocol):
    """A learned map that also knows what poses there are."""

    def complete(self, given: Floats) -> Floats | tuple[Floats, Floats]:
        """Complete a pose `(dy,)`, NaN where free."""
        ...

    def typical(self) -> Floats:
        """Return the pose `(dy,)` of which nothing is given."""
        ...


@dataclass(frozen=True, eq=False)
class Part:
    """One region.

    Attributes:
        sources: `(a,)` its dimensions of the source; regions may share some.
        targets: `(b,)` its dimensions of the target; no two regions share one.
        learnt: its map, or None before learning.
    """

    sources: Ints
    targets: Ints
    learnt: Learnt | None = None


@dataclass(frozen=True, eq=False)
class Apart:
    """A model learned region by region, before (`learn`) and after (`map`)."""

    parts: tuple[Part, ...]
    size: int

    @property
    def notes(self) -> tuple[Note, ...]:
        """Notes of all regions."""
        return tuple(note for part in self.parts for note in _of(part).notes)

    def map(self, X: Floats) -> Floats:
        """Map source rows `(f, dx)` to `(f, dy)`."""
        found = np.zeros((len(X), self.size))
        for part in self.parts:
            found[:, part.targets] = _of(part).map(X[:, part.sources])
        return found

    def variance(self, X: Floats) -> Floats:
        """Return the predictive variance `(f, dy)`."""
        found = np.zeros((len(X), self.size))
        for part in self.parts:
            found[:, part.targets] = _of(part).variance(X[:, part.sources])
        return found

    def start(self) -> tuple[object, ...]:
        """Begin with no row before."""
        return tuple(_of(part).start() for part in self.parts)

    def step(self, state: tuple[object, ...], x: Floats) -> tuple[tuple[object, ...], Floats]:
        """Map one row."""
        found, after = np.zeros(self.size), []
        for part, before in zip(self.parts, state, strict=True):
            kept, found[part.targets] = _of(part).step(before, x[part.sources])
            after.append(kept)
        return tuple(after), found

    def complete(self, given: Floats) -> Floats:
        """Complete a pose `(dy,)` of which a few entries are given, NaN where free; a region with none stays typical.

        Raises:
            InputError: no entry is given, or the model knows no poses.
        """
        if np.isnan(given).all():
            raise InputError("no entry of the pose is given; give at least one, the more telling the better.")
        found = np.zeros(self.size)
        for part in self.parts:
            found[part.targets] = _completed(_of(part), given[part.targets])
        return found


@dataclass(frozen=True, eq=False)
class ApartModel:
    """A model for each region.

    Attributes:
        model: learns a region.
        sources: dimensions of the source of each region; all others are ignored.
        targets: dimensions of the target of each, every one in exactly one region.
    """

    model: Learner
    sources: tuple[Ints, ...]
    targets: tuple[Ints, ...]

    def learn(self, given: Samples) -> Apart:
        """Learn every region.

        Raises:
            InputError: the regions do not divide the target.
        """
        size = given.Y_labelled.shape[1]
        every = np.sort(np.concatenate(self.targets)) if self.targets else np.zeros(0, dtype=np.int64)
        if len(self.sources) != len(self.targets) or not np.array_equal(every, np.arange(size)):
            raise InputError(
                f"the regions must divide the {size} targets among them, each in exactly one, and name their sources; "
                f"{len(self.sources)} lists of sources and {len(self.targets)} of targets hold {len(every)} in all."
            )
        parts = []
        for sources, targets in zip(self.sources, self.targets, strict=True):
            samples = Samples(
                given.X_labelled[:, sources],
                given.Y_labelled[:, targets],
                given.X_only[:, sources],
                given.Y_only[:, targets],
            )
            parts.append(Part(sources, targets, self.model.learn(samples)))
        return Apart(tuple(parts), size)


def _of(part: Part) -> Learnt:
    assert part.learnt is not None
    return part.learnt


def _completed(learnt: Learnt, given: Floats) -> Floats:
    if not isinstance(learnt, KnowsPoses):
        raise InputError("the model learned how frames become poses, but not what poses there are.")
    if np.isnan(given).all():
        return learnt.typical()
    found = learnt.complete(given)
    return np.asarray(found[0] if isinstance(found, tuple) else found)
