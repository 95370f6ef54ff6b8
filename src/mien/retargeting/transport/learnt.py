"""A learned map: shares of experts over the principal coordinates of the source."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import InputError, Note
from mien.core.arrays import Floats, floats
from mien.retargeting.transport.experts import Expert
from mien.retargeting.transport.principal import PrincipalSpace

LOOSE = 0.3
"""Variance, over the largest of a target, by which a few given entries may miss when they speak for all others."""


@dataclass(frozen=True, eq=False)
class LearntTransport:
    """A map from source rows to target rows; every row is mapped by itself.

    Attributes:
        source, target: principal components of both sides.
        experts: what predicts.
        shares: `(e,)` how far each is believed.
        notes: of the learning.
    """

    source: PrincipalSpace
    target: PrincipalSpace
    experts: tuple[Expert, ...]
    shares: Floats
    notes: tuple[Note, ...] = ()

    def start(self) -> None:
        """Begin: rows know nothing of each other, so there is no state."""
        return

    def step(self, state: None, x: Floats) -> tuple[None, Floats]:
        """Map one row `(dx,)`, NaN where not seen."""
        return state, self.map(np.asarray(x, dtype=np.float64)[None])[0]

    def map(self, X: Floats) -> Floats:
        """Map source rows `(f, dx)`, NaN where not seen, to target rows `(f, dy)`."""
        rows = self.source.coordinates(self._rows(X))
        return np.asarray(sum(share * one.expected(rows) for share, one in self._believed()))

    def variance(self, X: Floats) -> Floats:
        """Return the predictive variance `(f, dy)` of what `map` returns: within experts, and between them."""
        rows = self.source.coordinates(self._rows(X))
        predicted = [(share, one.expected(rows), one.variance(rows)) for share, one in self._believed()]
        mean = sum(share * pose for share, pose, _ in predicted)
        return np.asarray(sum(share * (variance + (pose - mean) ** 2) for share, pose, variance in predicted))

    def recovered(self, X: Floats) -> Floats:
        """Return source rows `(f, dx)` as they were probably meant, without noise and gaps."""
        return self.source.restored(self._rows(X))

    def complete(self, given: Floats) -> Floats:
        """Complete a pose of which a few entries are given (character posing).

        Conditions the principal components of all target rows on the entries given, loosely: taken at their
        word, two entries would move fifty others far from any pose seen.

        Args:
            given: `(dy,)`, NaN where free.

        Returns:
            The pose `(dy,)`; what was given stays.

        Raises:
            InputError: no entry is given.
        """
        row = floats(given, (len(self.target.mean),), "the given entries", nan=True)[None]
        if np.isnan(row).all():
            raise InputError("no entry of the pose is given; give at least one, the more telling the better.")
        return np.asarray(self.target.loosened(LOOSE).completed(row)[0])

    def _believed(self) -> list[tuple[float, Expert]]:
        return [(float(s), one) for s, one in zip(self.shares, self.experts, strict=True) if s > 0]

    def _rows(self, X: Floats) -> Floats:
        return floats(X, (None, len(self.source.mean)), "the source rows", nan=True)
