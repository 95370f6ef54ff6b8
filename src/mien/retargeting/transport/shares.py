"""How far each expert is believed: the mixture that would have predicted labels held out best."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mien.core.arrays import Flags, Floats
from mien.retargeting.transport.experts import Expert
from mien.solve.simplex import simplex_qp

FOLDS = 5
Learn = Callable[[Flags], Sequence[Expert]]


def shares(learn: Learn, coordinates: Floats, targets: Floats) -> Floats:
    """Return the shares of experts, not negative and of sum 1, by cross-validation over the labels.

    Args:
        learn: learns all experts from the labels of a mask `(l,)`.
        coordinates: `(l, r)` of the labelled source rows.
        targets: `(l, k)`.
    """
    fold = np.arange(len(targets)) % min(FOLDS, len(targets))
    errors = []
    for number in range(fold.max() + 1):
        out = fold == number
        errors.append([one.expected(coordinates[out]) - targets[out] for one in learn(~out)])
    off = np.concatenate([np.array(one).reshape(len(one), -1) for one in errors], axis=1)
    gram = off @ off.T
    size = float(np.trace(gram)) / len(gram)
    if size == 0.0:
        return np.full(len(gram), 1 / len(gram))
    return np.asarray(simplex_qp(gram / size, np.zeros(len(gram))).x)
