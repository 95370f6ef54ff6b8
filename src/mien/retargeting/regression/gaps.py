"""What a source row misses, guessed from what it sees: regressions need whole rows.

The rows are taken to lie near a principal subspace (probabilistic principal components,
Tipping and Bishop 1999); what is seen places a row in it, and the place says the rest.
All comparators get the same guess, so that they differ in their regression alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats

SHARE = 0.995
"""Of the variance that the subspace holds."""


@dataclass(frozen=True, eq=False)
class GapFilling:
    """A principal subspace of centred rows.

    Attributes:
        directions: `(d, r)`, scaled by the standard deviation along each.
        noise: the mean variance outside of the subspace.
    """

    directions: Floats
    noise: float

    @classmethod
    def of(cls, rows: Floats) -> GapFilling:
        """Learn the subspace of centred rows `(n, d)`; NaN counts as the mean."""
        filled = np.nan_to_num(rows)
        _, size, directions = np.linalg.svd(filled / np.sqrt(max(len(rows), 1)), full_matrices=False)
        variance = size**2
        total = float(variance.sum())
        count = int(np.searchsorted(np.cumsum(variance), SHARE * total) + 1) if total > 0 else 0
        left = float(variance[count:].sum()) / max(rows.shape[1] - count, 1)
        return cls(directions[:count].T * size[:count], max(left, 1e-6 * total / rows.shape[1], 1e-12))

    def __call__(self, rows: Floats) -> Floats:
        """Fill centred rows `(f, d)`; a row that sees nothing becomes the mean."""
        found = rows.copy()
        for i in np.flatnonzero(np.isnan(rows).any(axis=1)):
            seen = ~np.isnan(rows[i])
            basis = self.directions[seen]
            inner = basis.T @ basis + self.noise * np.eye(basis.shape[1])
            found[i, ~seen] = self.directions[~seen] @ np.linalg.solve(inner, basis.T @ rows[i, seen])
        return found
