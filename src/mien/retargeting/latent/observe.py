"""From an observation, noisy and perhaps incomplete, to its latent point and what was probably meant (eq. 9 to 17).

The same search serves both spaces: in the source it reads captured frames, in the target
it completes a pose of which only a few parameters are given.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mien.core.arrays import Flags, Floats
from mien.retargeting.latent.regressor import Regressor
from mien.retargeting.latent.search import SMALLEST, descend, lower_start


class State(NamedTuple):
    """What a frame needs of the one before; both are None before the first.

    Attributes:
        x: `(d,)` the observation as it was probably meant, scaled.
        z: `(q,)` its latent point.
    """

    x: Floats | None
    z: Floats | None


@dataclass(frozen=True, eq=False)
class Observer:
    """Finds latent points of observations of one space.

    Attributes:
        regressor: of the space.
        rows: `(n, d)` the training observations, scaled; NaN where not given.
        z: `(n, q)` their latent points.
        noise: σ_c², the variance of what the observation adds.
        change: σ_t², the variance of what a frame changes; infinite if frames do not follow each other.
    """

    regressor: Regressor
    rows: Floats
    z: Floats
    noise: float
    change: float

    def start(self) -> State:
        """Begin with no frame before."""
        return State(None, None)

    def step(self, state: State, observed: Floats) -> State:
        """Find one frame `(d,)`, NaN where not seen; a frame that sees nothing is the one before, or the mean."""
        seen = ~np.isnan(observed)
        if not seen.any():
            if state.x is not None:
                return state
            centre = np.zeros(len(observed))
            return State(centre, self.nearest(centre, seen | True))
        wanted, weight = self._pull(observed, seen, state.x)
        near = self.nearest(observed, seen)
        z, _ = self._descend(wanted, weight, near if state.z is None else state.z, near, bool(seen.all()))
        return State(self._meant(z, wanted, weight), z)

    def best(self, observed: Floats, count: int) -> State:
        """Find a single observation `(d,)`, starting from each of so many closest rows: the one of the lowest energy."""
        seen = ~np.isnan(observed)
        wanted, weight = self._pull(observed, seen, None)
        order = np.argsort(((self._filled[:, seen] - observed[seen]) ** 2).sum(axis=1), kind="stable")
        found = [self._descend(wanted, weight, self.z[i], self.z[i], bool(seen.all())) for i in order[:count]]
        z, _ = min(found, key=lambda pair: pair[1])
        return State(self._meant(z, wanted, weight), z)

    def nearest(self, observed: Floats, seen: Flags) -> Floats:
        """Return the latent point of the training row closest over what is seen, as published."""
        if seen.all():
            order = self._norms - 2 * (self._filled @ observed)
        else:
            order = ((self._filled[:, seen] - observed[seen]) ** 2).sum(axis=1)
        return np.asarray(self.z[int(np.argmin(order))])

    def _pull(self, observed: Floats, seen: Flags, before: Floats | None) -> tuple[Floats, Floats]:
        """Return where the observation and the frame before pull `x` to, and with what precision."""
        now = seen / self.noise
        kept = 0.0 if before is None else 1 / self.change
        weight = now + kept
        total = now * np.where(seen, observed, 0.0) + (0.0 if before is None else kept * before)
        return np.divide(total, weight, out=np.zeros(len(weight)), where=weight > 0), weight

    def _descend(self, wanted: Floats, weight: Floats, one: Floats, other: Floats, whole: bool) -> tuple[Floats, float]:
        r = self.regressor
        kernel = np.array([r.kernel.height, r.kernel.steepness, r.kernel.noise, len(wanted)])
        coefficients, rest = r.coefficients, np.zeros(2)
        if whole:
            turn, coefficients = self._turned
            within = wanted @ turn
            rest = np.array([max(float(wanted @ wanted - within @ within), 0.0), weight[0]])
            wanted, weight = within, np.full(len(within), weight[0])
        problem = (r.centres, kernel, coefficients, self._reduction, wanted, weight, rest)
        z = lower_start(np.ascontiguousarray(one), np.ascontiguousarray(other), *problem)
        lowest, _, _ = descend(z, *problem)
        return z, float(lowest)

    def _meant(self, z: Floats, wanted: Floats, weight: Floats) -> Floats:
        """Return the best observation for a latent point, in closed form."""
        r = self.regressor
        k = r.kernel(z[None], r.centres)[0]
        variance = max(r.kernel.height + r.kernel.noise - float(k @ self._reduction @ k), SMALLEST)
        share = weight * variance / (weight * variance + 1)
        return np.asarray(share * wanted + (1 - share) * (k @ r.coefficients))

    @cached_property
    def _turned(self) -> tuple[Floats, Floats]:
        """Directions `(d, r)` in which the mean can move, and the coefficients in them."""
        turn, triangle = np.linalg.qr(self.regressor.coefficients.T)
        return np.ascontiguousarray(turn), np.ascontiguousarray(triangle.T)

    @cached_property
    def _reduction(self) -> Floats:
        """The reduction that most dimensions share: one variance serves a whole frame, as published."""
        return np.ascontiguousarray(self.regressor.reductions[np.bincount(self.regressor.kind).argmax()])

    @cached_property
    def _filled(self) -> Floats:
        return np.nan_to_num(self.rows)

    @cached_property
    def _norms(self) -> Floats:
        return np.asarray((self._filled**2).sum(axis=1))
