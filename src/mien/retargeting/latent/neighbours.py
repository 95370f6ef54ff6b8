"""The prior that keeps neighbours neighbours: locally linear embedding (eq. 5 to 8).

Each row is an affine combination of its nearest rows; latent points are asked to be the
same combination of theirs (Roweis and Saul 2000).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, vstack
from scipy.spatial import cKDTree

from mien.core.arrays import Floats, Ints

SOFTNESS = 1e-3
"""Ridge on the local Gram matrix, relative to its trace: eight neighbours may span fewer directions."""


def residual_operator(rows: Floats, count: int, *, in_time_from: int | None = None) -> csr_array:
    """Return `I − C` (eq. 6 and 7): what of each row its neighbours do not explain.

    Args:
        rows: `(n, d)` observations; NaN counts as the mean of its column.
        count: k, the number of nearest neighbours.
        in_time_from: rows from this one on are in the order of time, and are neighbours of
            the rows before and after them too (the paper's discussion); None if no row is.

    Returns:
        `(n, n)`; zero if there is only one row.
    """
    n = len(rows)
    if n < 2:
        return csr_array((n, n))
    filled = np.where(np.isnan(rows), np.nanmean(rows, axis=0), rows)
    nearest = _nearest(filled, min(count, n - 1))
    lines, columns, values = [], [], []
    for i, near in enumerate(nearest):
        if in_time_from is not None and i >= in_time_from:
            beside = [j for j in (i - 1, i + 1) if in_time_from <= j < n]
            near = np.union1d(near, np.array(beside, dtype=np.int64))
        lines.append(np.full(len(near) + 1, i))
        columns.append(np.append(near, i))
        values.append(np.append(-affine_weights(filled[i], filled[near]), 1.0))
    return csr_array((np.concatenate(values), (np.concatenate(lines), np.concatenate(columns))), shape=(n, n))


def affine_weights(point: Floats, neighbours: Floats) -> Floats:
    """Return the weights that sum to 1 and best combine neighbours `(k, d)` to a point `(d,)` (eq. 8)."""
    local = neighbours - point
    gram = local @ local.T
    gram[np.diag_indices(len(gram))] += SOFTNESS * float(gram.trace()) / len(gram) + 1e-12
    weights = np.linalg.solve(gram, np.ones(len(gram)))
    return np.asarray(weights / weights.sum())


def joint_operator(source: csr_array, target: csr_array, labels: int) -> csr_array:
    """Return `M` (eq. 6): both spaces' operators over labelled, source-only and target-only points.

    Args:
        source: `(l + m, l + m)`.
        target: `(l + n, l + n)`.
        labels: `l`, the rows that both share.
    """
    m, n = source.shape[0] - labels, target.shape[0] - labels
    size = labels + m + n
    place = np.concatenate([np.arange(labels), np.arange(labels + m, size)])
    return csr_array(vstack([_spread(source, np.arange(labels + m), size), _spread(target, place, size)]))


def _spread(operator: csr_array, place: Ints, size: int) -> csr_array:
    found = operator.tocoo()
    return csr_array((found.data, (found.row, place[found.col])), shape=(operator.shape[0], size))


def _nearest(rows: Floats, count: int) -> Ints:
    """Return `(n, count)` the nearest other rows of each."""
    found = np.asarray(cKDTree(rows).query(rows, k=count + 1)[1], dtype=np.int64)
    chosen = np.empty((len(rows), count), dtype=np.int64)
    for i, near in enumerate(found):
        others = near[near != i]
        chosen[i] = others[:count]
    return chosen
