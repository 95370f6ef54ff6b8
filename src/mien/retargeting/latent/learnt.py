"""A learned shared latent space, and what can be asked of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import InputError, Note
from mien.core.arrays import Floats, floats
from mien.retargeting.latent.observe import Observer, State
from mien.retargeting.scaling import Scaling

CANDIDATES = 8
"""A pose of a few given entries is searched from so many of the closest training poses: few entries mislead."""


@dataclass(frozen=True, eq=False)
class Mapping:
    """What is known of some source rows.

    Attributes:
        values: `(f, dy)` target rows.
        variance: `(f, dy)` their predictive variance.
        recovered: `(f, dx)` source rows as they were probably meant, without noise and gaps.
        latent: `(f, q)` latent points.
    """

    values: Floats
    variance: Floats
    recovered: Floats
    latent: Floats


@dataclass(frozen=True, eq=False)
class Convergence:
    """How far learning got.

    Attributes:
        objective: the negative log posterior.
        gradient: its largest derivative, over the objective's size.
        iterations: made.
        converged: whether the gradient is as small as asked.
        message: why the search stopped.
    """

    objective: float
    gradient: float
    iterations: int
    converged: bool
    message: str


@dataclass(frozen=True, eq=False)
class LearntLatent:
    """A shared latent space and its maps to both sides.

    Attributes:
        source, target: find latent points of source and target rows.
        source_scaling, target_scaling: to and from scaled rows.
        convergence: how far learning got.
        notes: of the learning.
    """

    source: Observer
    target: Observer
    source_scaling: Scaling
    target_scaling: Scaling
    convergence: Convergence
    notes: tuple[Note, ...] = ()

    def start(self) -> State:
        """Begin with no row before."""
        return self.source.start()

    def step(self, state: State, x: Floats) -> tuple[State, Floats]:
        """Map one row `(dx,)`, NaN where not seen, knowing only what came before."""
        state = self.source.step(state, self.source_scaling(np.asarray(x, dtype=np.float64)))
        assert state.z is not None
        values = self.target.regressor.mean(state.z[None])[0]
        return state, self.target_scaling.undo(values)

    def map(self, X: Floats) -> Floats:
        """Map source rows `(f, dx)` in the order of time, NaN where not seen, to target rows `(f, dy)` (eq. 18)."""
        z, _ = self._found(X)
        return self.target_scaling.undo(self.target.regressor.mean(z))

    def variance(self, X: Floats) -> Floats:
        """Return the predictive variance `(f, dy)` of what `map` returns."""
        return self.trace(X).variance

    def trace(self, X: Floats) -> Mapping:
        """Map source rows `(f, dx)` and return all that is found on the way."""
        z, meant = self._found(X)
        values = self.target_scaling.undo(self.target.regressor.mean(z))
        variance = self.target.regressor.variance(z) * self.target_scaling.scale**2
        return Mapping(values, variance, self.source_scaling.undo(meant), z)

    def _found(self, X: Floats) -> tuple[Floats, Floats]:
        """Return the latent points `(f, q)` and the rows as meant `(f, dx)`, scaled."""
        rows = self.source_scaling(floats(X, (None, len(self.source_scaling.mean)), "source rows", nan=True))
        z, meant = np.empty((len(rows), self.source.z.shape[1])), np.empty_like(rows)
        state = self.start()
        for i, row in enumerate(rows):
            state = self.source.step(state, row)
            z[i], meant[i] = state.z, state.x
        return z, meant

    def complete(self, given: Floats) -> tuple[Floats, Floats]:
        """Complete a pose of which a few entries are given (character posing, §3).

        Args:
            given: `(dy,)`, NaN where free.

        Returns:
            The pose `(dy,)`, near what was given, and the variance of its entries.

        Raises:
            InputError: no entry is given.
        """
        pose = self.target_scaling(floats(given, (len(self.target_scaling.mean),), "the given entries", nan=True))
        if np.isnan(pose).all():
            raise InputError("no entry of the pose is given; give at least one, the more telling the better.")
        found = self.target.best(pose, CANDIDATES)
        assert found.x is not None
        assert found.z is not None
        variance = self.target.regressor.variance(found.z[None])[0] * self.target_scaling.scale**2
        return self.target_scaling.undo(found.x), variance

    def typical(self) -> Floats:
        """Return the pose `(dy,)` of which nothing is given: the mean."""
        return self.target_scaling.mean
