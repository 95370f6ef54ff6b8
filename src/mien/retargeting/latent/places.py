"""Where the search for the latent points starts.

As published, from the semi-supervised alignment of the two manifolds (Ham, Lee and Saul
2005).  The other start, from the principal components of the source, is not in the paper.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_array, csr_array, eye_array

from mien.core.arrays import Floats
from mien.retargeting.samples import Samples

DENSE = 800
"""Up to so many points all eigenvectors come from one dense factorisation, beyond from a sparse one."""
SHIFT = -1e-7
"""Below the smallest eigenvalue, which is zero: the shifted matrix can be factored."""
RIDGE = 1e-2
"""Of the regression that places target-only points, relative to the targets' mean variance."""


def aligned(operator: csr_array, dimensions: int) -> Floats:
    """Return latent points `(n, q)` from both spaces' operators (Ham, Lee and Saul 2005).

    The coordinates are the bottom eigenvectors of `MᵀM`, the constant one left out, each
    scaled to unit variance: what the two sides' graphs can agree on at the labelled points.

    Args:
        operator: `(r, n)` `M`, see `joint_operator`.
        dimensions: q, at most `n − 1`.
    """
    gram = csr_array(operator.T @ operator)
    n = gram.shape[0]
    if n <= DENSE:
        flat = np.full((n, n), float(gram.diagonal().sum()) / n / n)
        found = eigh(gram.toarray() + flat, subset_by_index=(0, dimensions - 1))[1]
    else:
        found = _bottom(gram, dimensions + 1)
    found = found - found.mean(axis=0)
    return _oriented(found / np.maximum(found.std(axis=0), 1e-12))


def _bottom(gram: csr_array, count: int) -> Floats:
    """Return the bottom eigenvectors without the constant one, by inverse iteration from a fixed start."""
    from scipy.sparse.linalg import eigsh

    n = gram.shape[0]
    start = np.cos(np.arange(n) + 1.0)
    values, vectors = eigsh(csc_array(gram + 1e-9 * eye_array(n)), k=count, sigma=SHIFT, v0=start)
    vectors = vectors[:, np.argsort(values)]
    constant = int(np.argmax(np.abs(vectors.sum(axis=0))))
    return np.asarray(np.delete(vectors, constant, axis=1))


def principal(samples: Samples, dimensions: int) -> Floats:
    """Return latent points from the principal components of the source.

    Target-only points are placed by a ridge regression from the labelled targets to the
    labelled points.

    Args:
        samples: scaled, complete on the source's side.
        dimensions: q.
    """
    rows = samples.X - samples.X.mean(axis=0)
    u, size, _ = np.linalg.svd(rows, full_matrices=False)
    scores = u[:, :dimensions] * size[:dimensions]
    scores = scores / max(float(scores[:, 0].std()), 1e-12)
    scores = _oriented(np.pad(scores, ((0, 0), (0, dimensions - scores.shape[1]))))
    labels = len(samples)
    y, y_only = (np.where(np.isnan(a), 0.0, a) for a in (samples.Y_labelled, samples.Y_only))
    centre, at = y.mean(axis=0), scores[:labels].mean(axis=0)
    gram = (y - centre) @ (y - centre).T
    ridge = RIDGE * max(float(gram.trace()) / labels, 1e-12) * np.eye(labels)
    placed = (y_only - centre) @ (y - centre).T @ np.linalg.solve(gram + ridge, scores[:labels] - at) + at
    return np.concatenate([scores, placed])


def spread_rows(points: Floats, count: int) -> Floats:
    """Return `count` of the points `(n, q)`, each the farthest from those before it: the inducing points' start."""
    chosen = [int(np.argmin(((points - points.mean(axis=0)) ** 2).sum(axis=1)))]
    distance = ((points - points[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
    return points[chosen]


def _oriented(points: Floats) -> Floats:
    """Turn each coordinate so that its largest entry is positive: eigenvectors have no sign of their own."""
    top = points[np.abs(points).argmax(axis=0), np.arange(points.shape[1])]
    return np.asarray(points * np.where(top < 0, -1.0, 1.0))
