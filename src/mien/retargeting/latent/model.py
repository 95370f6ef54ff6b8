"""The learning of Bouaziz and Pauly 2014, whole, with what their discussion leaves to later work as options."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array

from mien.core import InputError, Note
from mien.core.arrays import Floats
from mien.retargeting.latent.learnt import Convergence, LearntLatent
from mien.retargeting.latent.neighbours import joint_operator, residual_operator
from mien.retargeting.latent.observe import Observer
from mien.retargeting.latent.places import aligned, principal, spread_rows
from mien.retargeting.latent.posterior import Posterior, Unknowns
from mien.retargeting.latent.regressor import Regressor
from mien.retargeting.latent.sparse import SparseLikelihood
from mien.retargeting.samples import Samples
from mien.retargeting.scaling import Scaling
from mien.retargeting.settings import in_range
from mien.solve.gaussian_kernel import START, Kernel
from mien.solve.minimise import Minimum, minimise
from mien.solve.process_likelihood import DenseLikelihood

SHARE = 0.98
"""Of the source's variance that the latent space holds if its dimensions are chosen from the data."""
MOST = 20
"""Dimensions that are ever chosen."""

FLOORS = (1e-2, 1e-3, 1e-4, 1e-5)
"""Noise variances that the search may not go below at first: from the published start straight to clean data it
creeps along a narrow valley, and after many more steps ends higher."""
STEPS = 60
"""The most iterations at each of these floors."""

PUBLISHED: Mapping[str, Any] = {
    "dimensions": 8,
    "neighbours": 8,
    "floor": 0.0,
    "beginning": "alignment",
    "inducing": 0,
    "in_time": False,
    "unlabelled": True,
}
"""The model as printed."""


@dataclass(frozen=True)
class LatentModel:
    """A shared Gaussian-process latent variable model, learned from labelled and unlabelled rows.

    The defaults are the published ones.

    Attributes:
        dimensions: of the latent space; 0 chooses as many as hold 98 % of the source's variance.
        neighbours: k of the prior.
        floor: under both noise variances: without one, clean captures drive them to zero.
        beginning: where the latent points start: `alignment`, as published, or `principal` components.
        inducing: points that stand for all others in the kernels; 0 for exact kernels.
        in_time: unlabelled rows are in the order of time, and those before and after are neighbours too.
        unlabelled: False learns from the labelled rows alone (Ek 2009).
        noise: σ_c, standard deviation of the observation, in units of the source's largest deviation.
        change: σ_t, of what one row changes; infinite if rows are not consecutive frames.
        iterations: the most that learning makes.
        gradient: learning stops at this largest derivative, over the objective's size.
    """

    dimensions: int = 8
    neighbours: int = 8
    floor: float = 0.0
    beginning: str = "alignment"
    inducing: int = 0
    in_time: bool = False
    unlabelled: bool = True
    noise: float = 0.03
    change: float = math.inf
    iterations: int = 500
    gradient: float = 1e-3

    def __post_init__(self) -> None:
        in_range(self, dimensions=(0, 50), neighbours=(1, 100), floor=(0, 1), inducing=(0, 2000))
        in_range(self, noise=(1e-4, 10), change=(1e-4, np.inf), iterations=(1, 10**5), gradient=(1e-12, 1))
        if self.beginning not in ("alignment", "principal"):
            raise InputError(f"beginning must be 'alignment' or 'principal', but is {self.beginning!r}.")

    def learn(self, given: Samples) -> LearntLatent:
        """Learn the shared latent space (eq. 4).

        Args:
            given: labelled and unlabelled rows. NaN targets leave the likelihood; NaN in the
                source is filled from the most similar rows, and counted.

        Raises:
            InputError: nothing of the source varies.
        """
        paired, notes = given.paired()
        paired = paired if self.unlabelled else paired.supervised()
        filled, more = _complete(paired)
        source, target = Scaling.of(filled.X), Scaling.of(filled.Y)
        scaled = Samples(
            source(filled.X_labelled), target(filled.Y_labelled), source(filled.X_only), target(filled.Y_only)
        )
        if len(scaled.X) > 1 and not np.ptp(filled.X, axis=0).any():
            raise InputError(f"nothing of the source varies over its {len(scaled.X)} rows; give frames that differ.")
        posterior = self._posterior(scaled)
        found = self._minimum(posterior)
        at = posterior.shape.filled(found.x)
        convergence = _account(found, self.gradient)
        notes = (*notes, *more, *_doubts(scaled, convergence))
        x = _observer(scaled.X, at.z[posterior.rows_x], at.inducing_x, Kernel.of(at.logs_x, self.floor), self)
        y = _observer(scaled.Y, at.z[posterior.rows_y], at.inducing_y, Kernel.of(at.logs_y, self.floor), self)
        return LearntLatent(x, y, source, target, convergence, notes)

    def _minimum(self, posterior: Posterior) -> Minimum:
        """Search the minimum; with floors under the noise that are taken away step by step, if there is time for it.

        Without unlabelled rows the straight way is as short, and what it finds maps better.
        """
        found, made = posterior.shape.flat(), 0
        stepwise = self.unlabelled and self.iterations > STEPS * len(FLOORS)
        above = [one for one in FLOORS if one > self.floor] if stepwise else []
        for floor in (*above, self.floor):
            last = floor == self.floor
            problem = posterior.floored(floor)
            size = max(1.0, abs(problem(found)[0]))
            most = self.iterations - made if last else STEPS
            minimum = minimise(problem, found, posterior.shape.bounds(), gradient=self.gradient * size, iterations=most)
            found, made = minimum.x, made + minimum.iterations
        return replace(minimum, iterations=made)

    def _posterior(self, scaled: Samples) -> Posterior:
        labels, count_x, count_y = len(scaled), len(scaled.X), len(scaled.Y)
        size = count_x + count_y - labels
        source, target = (
            residual_operator(rows, self.neighbours, in_time_from=labels if self.in_time else None)
            for rows in (scaled.X, scaled.Y)
        )
        operator = joint_operator(source, target, labels)
        z = self._beginning(scaled, operator)
        rows_y = np.concatenate([np.arange(labels), np.arange(count_x, size)])
        none = np.zeros((0, z.shape[1]))
        exact = self.inducing == 0
        shape = Unknowns(
            z,
            START.copy(),
            START.copy(),
            none if exact else spread_rows(z[:count_x], self.inducing),
            none if exact else spread_rows(z[rows_y], self.inducing),
        )
        kind = DenseLikelihood if exact else SparseLikelihood
        precision = csr_array(operator.T @ operator + eye_array(size))
        likelihoods = (kind.of(scaled.X, self.floor), kind.of(scaled.Y, self.floor))
        return Posterior(*likelihoods, np.arange(count_x), rows_y, precision, shape)

    def _beginning(self, scaled: Samples, operator: csr_array) -> Floats:
        size = operator.shape[1]
        if size < 2:
            return np.zeros((1, 1))
        wanted = self.dimensions or telling_dimensions(scaled.X)
        if self.beginning == "principal":
            return principal(scaled, min(wanted, size - 1))
        return aligned(operator, min(wanted, size - 1))


def telling_dimensions(rows: Floats) -> int:
    """Return how many principal components hold 98 % of the variance of rows `(n, d)`, between 2 and 20."""
    size = np.linalg.svd(rows - rows.mean(axis=0), compute_uv=False) ** 2
    shares = np.cumsum(size) / max(float(size.sum()), 1e-300)
    return int(np.clip(np.searchsorted(shares, SHARE) + 1, 2, MOST))


def _observer(rows: Floats, z: Floats, inducing: Floats, kernel: Kernel, model: LatentModel) -> Observer:
    exact = len(inducing) == 0
    regressor = Regressor.exact(z, kernel, rows) if exact else Regressor.sparse(z, inducing, kernel, rows)
    return Observer(regressor, rows, z, model.noise**2, model.change**2)


def _complete(paired: Samples) -> tuple[Samples, tuple[Note, ...]]:
    """Fill what the source misses from the four most similar rows that see it."""
    rows = paired.X.copy()
    missing = np.isnan(rows)
    if not missing.any():
        return paired, ()
    filled = np.where(missing, np.nanmean(rows, axis=0), rows)
    for i in np.flatnonzero(missing.any(axis=1)):
        seen = ~missing[i]
        order = np.argsort(((filled[:, seen] - filled[i, seen]) ** 2).sum(axis=1), kind="stable")
        for d in np.flatnonzero(missing[i]):
            near = order[~missing[order, d]][:4]
            rows[i, d] = paired.X[near, d].mean()
    text = f"{int(missing.sum())} unseen source values were filled from the most similar rows before learning."
    labels = len(paired)
    return Samples(rows[:labels], paired.Y_labelled, rows[labels:], paired.Y_only), (Note("gaps-filled", text),)


def _account(found: Minimum, gradient: float) -> Convergence:
    left = found.gradient / max(1.0, abs(found.value))
    return Convergence(found.value, left, found.iterations, left <= gradient, found.message)


def _doubts(scaled: Samples, convergence: Convergence) -> tuple[Note, ...]:
    notes = []
    if len(scaled) == 1:
        notes.append(
            Note("one-label", "there is a single label, so every frame becomes much the same pose; label more.")
        )
    if not convergence.converged:
        text = (
            f"learning stopped after {convergence.iterations} iterations at a gradient of {convergence.gradient:.1e} of the "
            f"objective ({convergence.message}); the map is usable, but not the best the model has."
        )
        notes.append(Note("not-converged", text))
    return tuple(notes)
