"""A learned map: shares of experts over the principal coordinates of the source."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import InputError, Note
from mien.core.arrays import Floats, floats
from mien.retargeting.transport.experts import Expert, ProcessExpert, Seen
from mien.retargeting.transport.posing import completed
from mien.retargeting.transport.principal import PrincipalSpace
from mien.retargeting.transport.shares import Shares


@dataclass(frozen=True, eq=False)
class LearntTransport:
    """A map from source rows to target rows; every row is mapped by itself.

    Attributes:
        source, target: principal components of both sides.
        experts: what predicts; the process alone first, if frames are more or less sure.
        shares: how far each is believed.
        poses: `(n, dy)` all target rows, the labelled ones first.
        notes: of the learning.
    """

    source: PrincipalSpace
    target: PrincipalSpace
    experts: tuple[Expert, ...]
    shares: Shares
    poses: Floats
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        if not len(self.experts) == len(self.shares.doubtful) == len(self.shares.sure):
            raise ValueError(f"{len(self.experts)} experts have {len(self.shares.doubtful)} shares")

    def start(self) -> None:
        """Begin: rows know nothing of each other, so there is no state."""
        return

    def step(self, state: None, x: Floats) -> tuple[None, Floats]:
        """Map one row `(dx,)`, NaN where not seen."""
        return state, self.map(np.asarray(x, dtype=np.float64)[None])[0]

    def map(self, X: Floats) -> Floats:
        """Map source rows `(f, dx)`, NaN where not seen, to target rows `(f, dy)`."""
        seen = Seen.of(self.source, self._rows(X))
        say = self._say(seen)
        return np.asarray(sum(share[:, None] * one.expected(seen) for share, one in say))

    def variance(self, X: Floats) -> Floats:
        """Return the predictive variance `(f, dy)` of what `map` returns: within experts, and between them."""
        seen = Seen.of(self.source, self._rows(X))
        predicted = [(share[:, None], one.expected(seen), one.variance(seen)) for share, one in self._say(seen)]
        mean = sum(share * pose for share, pose, _ in predicted)
        return np.asarray(sum(share * (variance + (pose - mean) ** 2) for share, pose, variance in predicted))

    def recovered(self, X: Floats) -> Floats:
        """Return source rows `(f, dx)` as they were probably meant, without noise and gaps."""
        return self.source.restored(self._rows(X))

    def complete(self, given: Floats) -> Floats:
        """Complete a pose of which a few entries are given (character posing).

        The median of the poses seen that are alike in what is given, drawn to a linear completion where it is not
        at rest; never past what was seen.

        Args:
            given: `(dy,)`, NaN where free.

        Returns:
            The pose `(dy,)`; what was given stays.

        Raises:
            InputError: no entry is given.
        """
        row = floats(given, (len(self.target.mean),), "the given entries", nan=True)
        if np.isnan(row).all():
            raise InputError("no entry of the pose is given; give at least one, the more telling the better.")
        return completed(row, self.target, self.poses)

    def typical(self) -> Floats:
        """Return the pose `(dy,)` of which nothing is given: the median of all poses seen."""
        return np.median(self.poses, axis=0)

    def _say(self, seen: Seen) -> list[tuple[Floats, Expert]]:
        """Return the experts that have a say, and their shares `(f,)` at each row."""
        doubt = np.zeros(len(seen.rows))
        if self.shares.half:
            assert isinstance(self.experts[0], ProcessExpert)
            doubt = self.experts[0].doubt(seen)
        found = self.shares.at(doubt).T
        return [(share, one) for share, one in zip(found, self.experts, strict=True) if (share > 0).any()]

    def _rows(self, X: Floats) -> Floats:
        return floats(X, (None, len(self.source.mean)), "the source rows", nan=True)
