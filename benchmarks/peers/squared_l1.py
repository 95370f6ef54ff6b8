"""The squared-L1 bounded solver of the widely used audio-driven face, restated from its published description.

Install: nothing; this is a restatement in a few lines, not the program itself.

Each frame solves `A w = b` in the least-squares sense between 0 and 1, where

    A = DᵀD + 10 a I + ¼ c² 11ᵀ + 10 s SᵀS + 100 t I,     b = Dᵀd + g t w_before

with strengths a (called L2), c (called L1: the *square* of the sum of the weights, not their
absolute values), s (a row of S for each symmetric pair) and t (temporal).  Two descriptions
of the temporal term are in use: in one the weights before come back with the factor that they
have in the matrix (g = 100), in the other with g = 1, and a held pose sags.  That bounded
`|A w - b|²` is not the energy whose gradient is `A w - b` is part of the description.

The constants are for a dense mesh in centimetres; a marker stands for its share of one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.peers.adapter import Peer, SolverMethod
from mien.core.arrays import Floats

DENSE = 24_000
"""Points of the mesh that the constants are for, of this order: what the squared error is a sum over."""
L2, L1, TEMPORAL = 3.5, 1.0, 3.5
"""Strengths as shipped.  Symmetry is left out: pairs are told by hand there."""


@dataclass(frozen=True)
class SquaredL1:
    """The solver.

    Attributes:
        returned: g, the factor of the weights before on the right-hand side.
    """

    returned: float

    def __call__(self, shapes: Floats, take: Floats, fps: float) -> Floats:
        """Solve a take frame after frame; what is not seen counts as not moving, as zeros do there."""
        from scipy.optimize import lsq_linear

        del fps
        count = len(shapes)
        share = DENSE / shapes.shape[1]
        matrix = shapes.reshape(count, -1).T
        gram = share * matrix.T @ matrix + 0.25 * L1**2 * np.ones((count, count))
        gram += (10 * L2 + 100 * TEMPORAL) * np.eye(count)
        right = share * np.nan_to_num(take).reshape(len(take), -1) @ matrix
        weights, before = np.zeros((len(take), count)), np.zeros(count)
        for frame, row in enumerate(right):
            b = row + self.returned * TEMPORAL * before
            before = lsq_linear(gram, b, bounds=(0.0, 1.0), method="bvls").x
            weights[frame] = before
        return weights


RESTATED = (
    Peer(
        "squared-l1",
        "squared-L1 bounded solver, consistent in time",
        "with mien",
        lambda: SolverMethod(SquaredL1(100.0)),
    ),
    Peer("squared-l1-sag", "the same, weights before at 1", "with mien", lambda: SolverMethod(SquaredL1(1.0))),
)
