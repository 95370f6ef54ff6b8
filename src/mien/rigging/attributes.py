"""Attributes of the skin on a face of other triangulation (Orvalho et al., §4.5 and §4.6).

Every vertex of the face takes the value of its point on the generic skin that was stuck
to it.  Numbers are interpolated, labels never; what is not skin takes the value of the
part it follows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from mien.core import Labels, Skin, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.rigging.dense import DenseFit
from mien.rigging.parts import Attachment


def interpolation(fit: DenseFit, attached: tuple[Attachment, ...]) -> sparse.csr_matrix:
    """Return the `(Nt, Ns)` matrix of means that takes values of the source's vertices to the target's."""
    points = fit.back
    skin = _means(points, len(fit.source.vertices))
    matrix = sparse.diags(fit.target_skin.astype(np.float64)) @ skin
    for part in attached:
        followed = part.weights if part.counterpart else part.weights @ skin
        matrix += _rows(part.vertices, len(points)) @ followed
    return sparse.csr_matrix(matrix)


def carried_values(values: Floats, means: sparse.csr_matrix) -> Floats:
    """Interpolate values `(Ns,)` or `(Ns, C)`."""
    return np.asarray(means @ values)


def carried_shares(values: Floats, means: sparse.csr_matrix) -> Floats:
    """Interpolate shares `(Ns,)` between 0 and 1, which they stay."""
    return np.clip(means @ values, 0.0, 1.0)


def carried_labels(labels: Labels, means: sparse.csr_matrix) -> Labels:
    """Give every vertex the label of the source vertex that weighs most in its mean."""
    return replace(labels, of=labels.of[dominant(means)])


def dominant(means: sparse.csr_matrix) -> Ints:
    """Return the column of the largest entry of every row."""
    rows = np.repeat(np.arange(means.shape[0]), np.diff(means.indptr))
    order = np.lexsort((means.data, rows))
    return np.asarray(means.indices[order[means.indptr[1:] - 1]], dtype=np.int64)


def carried_skin(skin: Skin, means: sparse.csr_matrix, influences: int) -> tuple[Ints, Floats]:
    """Interpolate skin weights and keep the strongest.

    Returns:
        `(Nt, I)` joints and weights; each row is non-negative and sums to 1.
    """
    count = len(skin.inverse_bind)
    rows = np.repeat(np.arange(len(skin.joints)), skin.joints.shape[1])
    full = sparse.csr_matrix((skin.weights.ravel(), (rows, skin.joints.ravel())), shape=(len(skin.joints), count))
    spread = np.asarray((means @ full).todense())
    kept = min(influences, count)
    joints = np.argsort(-spread, axis=1, kind="stable")[:, :kept]
    weights = np.maximum(np.take_along_axis(spread, joints, axis=1), 0)
    return joints, weights / weights.sum(axis=1, keepdims=True)


def _means(points: SurfacePoints, count: int) -> sparse.csr_matrix:
    rows = np.repeat(np.arange(len(points)), 3)
    shape = (len(points), count)
    return sparse.csr_matrix((points.weights.ravel(), (rows, points.corners.ravel())), shape=shape)


def _rows(places: Ints, count: int) -> sparse.csr_matrix:
    """Return the `(count, P)` matrix that puts `P` rows in their places."""
    return sparse.csr_matrix((np.ones(len(places)), (places, np.arange(len(places)))), shape=(count, len(places)))
