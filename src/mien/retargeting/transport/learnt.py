"""A learned map: shares of experts over the principal coordinates of the source."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import Note
from mien.core.arrays import Floats, floats
from mien.retargeting.transport.experts import Expert
from mien.retargeting.transport.principal import PrincipalSpace


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

    def _believed(self) -> list[tuple[float, Expert]]:
        return [(float(s), one) for s, one in zip(self.shares, self.experts, strict=True) if s > 0]

    def _rows(self, X: Floats) -> Floats:
        return floats(X, (None, len(self.source.mean)), "the source rows", nan=True)
