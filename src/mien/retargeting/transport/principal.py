"""The subspace that all rows seen span, with the noise told apart from what moves.

Unlabelled rows cost nothing and say which directions a face moves in.  Probabilistic principal
components (Tipping and Bishop 1999) also say where a row with missing entries lies: conditioning on
the entries that are there is a small linear system, and with none missing it shrinks each
coordinate by the share of its variance that is not noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mien.core.arrays import Floats

FLOOR = 1e-8
"""Noise variance is never below this share of the first component's variance: conditioning stays well posed."""
QUANTILE = 0.25
FEW = 20
"""Of fewer rows or entries than this, noise can't be told from movement."""
ROUNDS = 8
"""Times that missing entries are filled from the components found so far."""


@dataclass(frozen=True, eq=False)
class PrincipalSpace:
    """Probabilistic principal components of rows.

    Attributes:
        mean: `(d,)`.
        axes: `(r, d)` orthonormal.
        spread: `(r,)` standard deviation along each axis, noise taken off, falling.
        noise: variance of the noise in each entry.
    """

    mean: Floats
    axes: Floats
    spread: Floats
    noise: float

    @classmethod
    def of(cls, rows: Floats) -> PrincipalSpace:
        """Estimate the components of rows `(n, d)`, NaN where not seen."""
        unseen = np.isnan(rows)
        if not unseen.any():
            return cls._of_complete(rows)
        filled = np.where(unseen, np.nanmean(rows, axis=0), rows)
        for _ in range(ROUNDS):
            space = cls._of_complete(filled)
            filled = np.where(unseen, space.restored(rows), rows)
        return space

    @classmethod
    def _of_complete(cls, rows: Floats) -> PrincipalSpace:
        n, d = rows.shape
        mean = rows.mean(axis=0)
        _, singular, axes = np.linalg.svd(rows - mean, full_matrices=False)
        variance = singular[: max(n - 1, 1)] ** 2 / n
        noise = noise_variance(variance, n, d)
        spread = np.sqrt(_without_noise(variance, noise, d / n))
        kept = spread > np.sqrt(FLOOR) * spread[0]
        kept[0] = True
        size = float(spread[0] ** 2) or 1.0
        spread = np.where(spread > 0, spread, np.sqrt(size))[: len(kept)]
        return cls(mean, axes[: len(kept)][kept], spread[kept], max(noise, FLOOR * size))

    def coordinates(self, rows: Floats) -> Floats:
        """Return the expected coordinates `(n, r)` of rows `(n, d)`, given the entries that are not NaN."""
        unseen = np.isnan(rows)
        whole = ~unseen.any(axis=1)
        found = np.empty((len(rows), len(self.spread)))
        found[whole] = (rows[whole] - self.mean) @ self.axes.T * (self.spread**2 / (self.spread**2 + self.noise))
        for i in np.flatnonzero(~whole):
            axes = self.axes[:, ~unseen[i]]
            system = axes @ axes.T + np.diag(self.noise / self.spread**2)
            found[i] = np.linalg.solve(system, axes @ (rows[i] - self.mean)[~unseen[i]])
        return found

    def loosened(self, share: float) -> PrincipalSpace:
        """Return the space with noise of a share of the largest variance, for poses of which little is given."""
        return replace(
            self, noise=max(self.noise, share * float((self.spread[:, None] ** 2 * self.axes**2).sum(axis=0).max()))
        )

    def restored(self, rows: Floats) -> Floats:
        """Return rows `(n, d)` as their coordinates make them: without noise and gaps."""
        return np.asarray(self.mean + self.coordinates(rows) @ self.axes)

    def completed(self, rows: Floats) -> Floats:
        """Return rows `(n, d)` with NaN entries filled and all others as they are."""
        unseen = np.isnan(rows)
        return np.where(unseen, self.restored(rows), rows) if unseen.any() else rows


def noise_variance(variance: Floats, n: int, d: int) -> float:
    """Estimate the noise variance from the lower quartile of the components.

    Where noise alone is left, their spectrum is known (Marchenko and Pastur 1967); the quartile rather
    than the median (Gavish and Donoho 2014), since a face fills up to half of them.

    Args:
        variance: of the principal components of `n` rows of `d` entries.
        n: rows.
        d: entries.
    """
    if min(n, d) < FEW:
        return 0.0
    ratio = min(n, d) / max(n, d)
    return float(np.quantile(variance, QUANTILE) / (max(n, d) / n * _quantile_of_noise(ratio)))


def _quantile_of_noise(ratio: float) -> float:
    """Return the quantile of the Marchenko–Pastur law of unit variance."""
    low, high = (1 - ratio**0.5) ** 2, (1 + ratio**0.5) ** 2
    at = np.linspace(low, high, 4001)[1:-1]
    mass = np.cumsum(np.sqrt((high - at) * (at - low)) / at)
    return float(at[np.searchsorted(mass, QUANTILE * mass[-1])])


def _without_noise(variance: Floats, noise: float, ratio: float) -> Floats:
    """Return the variance behind each sample variance under white noise, 0 below the noise's edge.

    Inverts `λ = (ℓ + σ²)(1 + γσ²/ℓ)`, the limit of a spiked sample covariance (Baik and Silverstein 2006).
    """
    sum_ = variance - noise - ratio * noise
    signal = (sum_ + np.sqrt(np.maximum(sum_**2 - 4 * ratio * noise**2, 0.0))) / 2
    return np.where(variance > noise * (1 + np.sqrt(ratio)) ** 2, np.maximum(signal, 0.0), 0.0)
