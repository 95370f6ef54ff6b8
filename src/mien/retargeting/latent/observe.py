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
from mien.retargeting.latent.search import find, nearest_row


class State(NamedTuple):
    """What a frame needs of the one before; all are None before the first.

    Attributes:
        x: `(d,)` the observation as it was probably meant, scaled.
        z: `(q,)` its latent point.
        bend: `(q, q)` the inverse Hessian there: the next frame's search begins with it.
    """

    x: Floats | None
    z: Floats | None
    bend: Floats | None = None


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
        bend = np.zeros((len(near), len(near))) if state.bend is None else state.bend.copy()
        x, z, _ = self._find(wanted, weight, near if state.z is None else state.z, near, bend)
        return State(x, z, bend)

    def best(self, observed: Floats, count: int) -> State:
        """Find a single observation `(d,)`, starting from each of so many closest rows: the one of the lowest energy."""
        seen = ~np.isnan(observed)
        wanted, weight = self._pull(observed, seen, None)
        order = np.argsort(((self._filled[:, seen] - observed[seen]) ** 2).sum(axis=1), kind="stable")
        q = self.z.shape[1]
        starts = self.z[order[:count]]
        x, z, _ = min((self._find(wanted, weight, s, s, np.zeros((q, q))) for s in starts), key=lambda found: found[2])
        return State(x, z)

    def nearest(self, observed: Floats, seen: Flags) -> Floats:
        """Return the latent point of the training row closest over what is seen, as published."""
        where = nearest_row(self._filled, np.where(seen, observed, 0.0), seen.astype(np.float64))
        return np.ascontiguousarray(self.z[where])

    def _pull(self, observed: Floats, seen: Flags, before: Floats | None) -> tuple[Floats, Floats]:
        """Return where the observation and the frame before pull `x` to, and with what precision."""
        now = seen / self.noise
        kept = 0.0 if before is None else 1 / self.change
        weight = now + kept
        total = now * np.where(seen, observed, 0.0) + (0.0 if before is None else kept * before)
        return np.divide(total, weight, out=np.zeros(len(weight)), where=weight > 0), weight

    def _find(
        self, wanted: Floats, weight: Floats, one: Floats, other: Floats, bend: Floats
    ) -> tuple[Floats, Floats, float]:
        """Search from the better of two points; return the observation as meant, its latent point and the energy."""
        z, meant = np.array(one), np.empty(len(wanted))
        centres, kernel, coefficients, turn, turned, reduction = self._compiled
        problem = (centres, kernel, coefficients, turn, turned, reduction)
        lowest = find(z, np.array(other), bend, *problem, wanted, weight, meant)
        return meant, z, float(lowest)

    @cached_property
    def _compiled(self) -> tuple[Floats, ...]:
        """What the search needs of the regressor; one variance serves a whole row, as published: the commonest one."""
        r = self.regressor
        kernel = np.array([r.kernel.height, r.kernel.steepness, r.kernel.noise, r.coefficients.shape[1]])
        turn, triangle = np.linalg.qr(r.coefficients.T)
        reduction = r.reductions[np.bincount(r.kind).argmax()]
        parts = (r.centres, kernel, r.coefficients, turn, triangle.T, reduction)
        return tuple(np.array(part, dtype=np.float64, order="C") for part in parts)

    @cached_property
    def _filled(self) -> Floats:
        return np.nan_to_num(self.rows)
