"""Refined inverse rigging (Racković, Soares, Jakovetić, SIGGRAPH Asia 2024): the authors' own program.

Install: it has no licence, so it is neither copied nor shipped; get it yourself with

    git clone https://github.com/stevorackovic/Siggraph-Paper-Code
    export MIEN_PEER_REFINED_RIGGING=$PWD/Siggraph-Paper-Code

It needs NumPy and SciPy.  Coordinate descent over whole intervals of ten frames, with L1 and
second differences, and correctives up to fourth order; here the rigs have none, so its
corrective matrices are empty.  Once with the program's default strengths, which its paper says to
choose for each character, and once with a hundredth of them.  It leaves out the frames after the
last whole interval; they hold the last one.
"""

from __future__ import annotations

import importlib

import numpy as np

from benchmarks.peers.adapter import Peer, SolverMethod, checkout
from mien.core.arrays import Floats

VARIABLE = "MIEN_PEER_REFINED_RIGGING"
INTERVAL, MOST, LEAST = 10, 10, 5
"""Frames solved together, and rounds over all shapes at most and at least: the program's defaults."""
STRENGTH = 1.0
"""Of the L1 term and of the second differences alike: the program's default."""


def refined(strength: float = STRENGTH) -> SolverMethod:
    checkout(VARIABLE, "Scripts", "TACFunctions.py")
    program = importlib.import_module("TACFunctions")
    order_of = importlib.import_module("HelperFunctions").ctr_order

    def solve(shapes: Floats, take: Floats, fps: float) -> Floats:
        del fps
        deltas = np.ascontiguousarray(shapes.reshape(len(shapes), -1).T)
        target = np.ascontiguousarray(np.nan_to_num(take).reshape(len(take), -1).T)
        none = [np.zeros((0, len(deltas)))] * 3
        keys = [np.zeros((0, width), dtype=np.int64) for width in (2, 3, 4)]
        banded = program.banded_matrix(INTERVAL)
        weights = program.solver_holistic(
            len(take), INTERVAL, target, len(shapes), deltas, *none, *keys, order_of(deltas), banded,
            *program.banded_matrix_add(banded), strength, strength, MOST, LEAST,
        ).T  # fmt: skip
        held = np.minimum(np.arange(len(take)), len(weights) - 1)
        return np.asarray(weights[held])

    return SolverMethod(solve)


_GET = f"a checkout named by {VARIABLE}"
REFINED = (
    Peer("refined-rigging", "Racković et al. 2024, the authors' program", _GET, refined),
    Peer("refined-rigging-light", "the same, a hundredth as strong", _GET, lambda: refined(STRENGTH / 100)),
)
