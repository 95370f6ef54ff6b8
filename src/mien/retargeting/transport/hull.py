"""Poses seen are close to other poses: a prediction is drawn to the surface of the target rows near it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from mien.core.arrays import Floats
from mien.retargeting.transport.principal import PrincipalSpace

STRENGTH = 0.004
"""Share of the neighbours' total variance that counts as noise along each of their axes."""


@dataclass(frozen=True, eq=False)
class LocalHull:
    """Target rows and their neighbourhoods.

    Attributes:
        rows: `(n, k)` target rows.
        space: where distances are measured.
        stretch: `(r,)` of its coordinates.
        neighbours: rows in a neighbourhood.
    """

    rows: Floats
    space: PrincipalSpace
    stretch: Floats
    neighbours: int

    def __call__(self, poses: Floats) -> Floats:
        """Return poses `(m, k)` moved towards the affine hull of their nearest rows.

        Along each principal axis of the neighbours a pose keeps the share of its deviation that
        their variance makes likely; across them it keeps nothing.
        """
        count = min(self.neighbours, len(self.rows))
        places = self.space.coordinates(self.rows) * self.stretch
        apart = cdist(self.space.coordinates(poses) * self.stretch, places)
        near = np.argsort(apart, axis=1, kind="stable")[:, :count]
        patches = self.rows[near]
        centres = patches.mean(axis=1)
        # The Gram matrices of the patches are small, whatever the number of targets.
        offsets = patches - centres[:, None]
        values, vectors = np.linalg.eigh(offsets @ offsets.transpose(0, 2, 1))
        total = values.sum(axis=1, keepdims=True)
        along = np.einsum("mik,mk->mi", offsets, poses - centres)
        weights = np.einsum("mij,mi->mj", vectors, along)
        kept = np.where(values > 1e-12 * total, 1 / (values + STRENGTH * total + 1e-300), 0.0)
        return np.asarray(centres + np.einsum("mij,mj,mik->mk", vectors, weights * kept, offsets))
