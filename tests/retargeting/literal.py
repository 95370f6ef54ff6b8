"""The paper's energies written out as printed, slowly: what the small matrices are tested against."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from mien.core.arrays import Floats
from mien.retargeting.range_of_motion.alignment import cross_expression_laplacian, local_support


def energies(
    personal: Floats,
    similarity: Floats,
    keys: Floats,
    shapes: Floats,
    guess: Floats,
    between: Floats,
    laplacian: sparse.spmatrix,
) -> dict[str, float]:
    """Evaluate `E_Match`, `E_Mesh` and `E_CEG` (eq. 10, 11, 13) term by term, as printed.

    The slow, literal reading: what the assembled problem is tested against.
    """
    markers = shapes.shape[1]
    reach = local_support(shapes)[:, :, None]
    match = sum(
        similarity[k, e] * float(((personal[k] - reach[k] * keys[e]) ** 2).sum())
        for k in range(len(shapes))
        for e in range(len(keys))
    ) / len(keys)
    mesh = sum(float(((laplacian @ d) ** 2).sum()) for d in personal - guess) / markers
    graph = cross_expression_laplacian(between)
    drift = np.einsum("kl,lmc->kmc", graph, personal - shapes)
    return {"match": match, "mesh": mesh, "cross": float((drift**2).sum()) / markers}
