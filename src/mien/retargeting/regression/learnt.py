"""A learned regression behind the interface that all models of examples share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mien.core import Note
from mien.core.arrays import Floats, Ints, floats
from mien.retargeting.regression.gaps import GapFilling
from mien.retargeting.regression.predictor import Predictor
from mien.retargeting.samples import Samples
from mien.retargeting.scaling import Scaling
from mien.solve.process_likelihood import blocks

Fit = Callable[[Floats, Floats], Predictor]
"""From complete scaled rows `(l, d)` and targets `(l, c)` to a predictor."""


@dataclass(frozen=True, eq=False)
class LearntRegression:
    """Predictors of all target columns, for whole and for incomplete source rows.

    Attributes:
        source_scaling, target_scaling: to and from scaled rows.
        gaps: guesses what a source row misses.
        parts: per group of columns that are labelled in the same rows, the columns and their predictor.
        directions: `(dx, r)` the orthonormal directions of the source that are looked at.
        notes: of the learning.
    """

    source_scaling: Scaling
    target_scaling: Scaling
    gaps: GapFilling
    parts: tuple[tuple[Ints, Predictor], ...]
    directions: Floats
    notes: tuple[Note, ...] = ()

    def map(self, X: Floats) -> Floats:
        """Map source rows `(f, dx)` to target rows `(f, dy)`; a row that sees nothing is the one before."""
        state, found = self.start(), []
        for x in floats(X, (None, len(self.source_scaling.mean)), "source rows", nan=True):
            state, y = self.step(state, x)
            found.append(y)
        return np.array(found).reshape(len(X), len(self.target_scaling.mean))

    def variance(self, X: Floats) -> Floats:
        """Return the predictive variance `(f, dy)`."""
        given = floats(X, (None, len(self.source_scaling.mean)), "source rows", nan=True)
        rows = self.gaps(self.source_scaling(given)) @ self.directions
        found = np.zeros((len(rows), len(self.target_scaling.mean)))
        for columns, predictor in self.parts:
            found[:, columns] = predictor.variance(rows)
        return found * self.target_scaling.scale**2

    def start(self) -> Floats | None:
        """Begin with no row before."""
        return None

    def step(self, state: Floats | None, x: Floats) -> tuple[Floats, Floats]:
        """Map one row `(dx,)`; the state is the target row before."""
        row = self.source_scaling(np.asarray(x, dtype=np.float64))[None]
        if state is not None and np.isnan(row).all():
            return state, state
        filled = self.gaps(row) @ self.directions
        found = np.zeros(len(self.target_scaling.mean))
        for columns, predictor in self.parts:
            found[columns] = predictor.mean(filled)[0]
        found = self.target_scaling.undo(found)
        return found, found


def learn_regression(given: Samples, fit: Fit, share: float = 1.0) -> LearntRegression:
    """Learn a regression from the labelled rows; the unlabelled ones only help to fill gaps and to centre the source.

    Args:
        given: labelled and unlabelled rows.
        fit: learns one group of columns.
        share: of the source's variance, unlabelled rows included, that is looked at: the
            principal components that hold it.
    """
    paired, notes = given.paired()
    source, target = Scaling.of(paired.X), Scaling.of(paired.Y_labelled)
    gaps = GapFilling.of(source(paired.X))
    directions = _principal(gaps(source(paired.X)), share)
    rows = gaps(source(paired.X_labelled)) @ directions
    parts = tuple((block.columns, fit(rows[block.rows], block.values)) for block in blocks(target(paired.Y_labelled)))
    return LearntRegression(source, target, gaps, parts, directions, notes)


def _principal(rows: Floats, share: float) -> Floats:
    """Return orthonormal directions `(d, r)` that hold a share of the variance of centred rows `(n, d)`."""
    _, size, directions = np.linalg.svd(rows, full_matrices=False)
    held = np.cumsum(size**2)
    count = int((held < share * held[-1] * (1 - 1e-12)).sum()) + 1
    return np.asarray(directions[:count].T)
