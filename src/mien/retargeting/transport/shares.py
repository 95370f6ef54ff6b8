"""How far each expert is believed: the mixture that would have predicted labels held out best.

Held-out labels are predicted from fewer labels than a new frame is.  Mostly that matters little; but
where the labels just suffice to solve a clean linear rig, each of them left out leaves a gap that the
whole set does not have, and weak labels look better than they are.  The doubt of the process tells
the two apart: a frame it is sure of is left to what learned from labels alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Flags, Floats
from mien.retargeting.transport.experts import Expert, ProcessExpert, Seen
from mien.solve.simplex import simplex_qp

FOLDS = 5
SURE = 4.0
"""A frame is half sure where the doubt promises this many times the squared error of the best mixture."""
FINEST = 1e-6
"""A doubt so small is rounding."""
Learn = Callable[[Flags], Sequence[Expert]]


@dataclass(frozen=True, eq=False)
class Shares:
    """The say of each expert, not negative and of sum 1 for every frame.

    Attributes:
        doubtful: `(e,)` where the process doubts.
        sure: `(e,)` where it does not; of those that learned from labels alone.
        half: the doubt at which both count the same; 0 if no frame counts as sure.
    """

    doubtful: Floats
    sure: Floats
    half: float

    @classmethod
    def whole(cls, count: int) -> Shares:
        """Return shares in which the first of so many experts has all the say."""
        first = np.eye(count)[0]
        return cls(first, first, 0.0)

    @property
    def heard(self) -> Flags:
        """`(e,)` whether an expert has a say, or is asked for its doubt."""
        first = np.arange(len(self.doubtful)) == 0
        return np.asarray((self.doubtful > 0) | (self.sure > 0) | (first & (self.half > 0)))

    def only(self, which: Flags) -> Shares:
        """Return the shares of some experts, those that have all of the say."""
        return Shares(self.doubtful[which], self.sure[which], self.half)

    def at(self, doubt: Floats) -> Floats:
        """Return the shares `(m, e)` at frames of some doubt `(m,)`."""
        certain = (self.half / (doubt + self.half) if self.half else np.zeros(len(doubt)))[:, None]
        return np.asarray(certain * self.sure + (1 - certain) * self.doubtful)


def shares(learn: Learn, seen: Seen, targets: Floats, told_labels: int) -> Shares:
    """Return the shares of experts by cross-validation over the labels.

    Args:
        learn: learns all experts from the labels of a mask `(l,)`; the first one is the process alone.
        seen: the labelled source rows.
        targets: `(l, k)`.
        told_labels: so many of the experts, the first ones, learned from labels alone.
    """
    off, doubt = _left_out(learn, seen, targets)
    plain, sure = _best(off), np.zeros(len(off))
    sure[:told_labels] = _best(off[:told_labels])
    mixed, certain = np.tensordot(plain, off, 1), np.tensordot(sure, off, 1)
    half = SURE * _square(mixed) * float(doubt.mean()) / max(_square(certain), 1e-300)
    if half < FINEST:
        return Shares(plain, plain, 0.0)
    weight = half / (doubt + half)
    bent = (1 - weight)[:, None] * off + weight[:, None] * certain
    doubtful = _best(bent)
    if _square(np.tensordot(doubtful, bent, 1)) > _square(mixed):
        return Shares(plain, plain, 0.0)
    return Shares(doubtful, sure, half)


def _left_out(learn: Learn, seen: Seen, targets: Floats) -> tuple[Floats, Floats]:
    """Return the errors `(e, l, k)` of labels held out, and the doubt `(l,)` about them."""
    fold = np.arange(len(targets)) % min(FOLDS, len(targets))
    errors, doubts = [], np.empty(len(targets))
    for number in range(fold.max() + 1):
        out = fold == number
        experts = learn(~out)
        there = seen.only(out)
        errors.append(np.array([one.expected(there) - targets[out] for one in experts]))
        assert isinstance(experts[0], ProcessExpert)
        doubts[out] = experts[0].doubt(there)
    found = np.empty((len(errors[0]), *targets.shape))
    for number, error in enumerate(errors):
        found[:, fold == number] = error
    return found, doubts


def _best(off: Floats) -> Floats:
    """Return the shares `(e,)` whose mixture of errors `(e, l, k)` is smallest."""
    flat = off.reshape(len(off), -1)
    gram = flat @ flat.T
    size = float(np.trace(gram)) / len(gram)
    if size == 0.0:
        return np.full(len(gram), 1 / len(gram))
    return np.asarray(simplex_qp(gram / size, np.zeros(len(gram))).x)


def _square(off: Floats) -> float:
    return float((off**2).mean())
