"""Node transforms: translation, rotation (quaternion xyzw), scale, and 4 × 4 matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mien.core.arrays import Floats


def composed(translation: Floats, rotation: Floats, scale: Floats) -> Floats:
    """Return the matrices `(…, 4, 4)` of translations `(…, 3)`, unit quaternions `(…, 4)` and scales `(…, 3)`."""
    shape = np.broadcast_shapes(translation.shape[:-1], rotation.shape[:-1], scale.shape[:-1])
    matrix = np.zeros((*shape, 4, 4))
    matrix[..., :3, :3] = rotation_matrix(rotation) * scale[..., None, :]
    matrix[..., :3, 3] = translation
    matrix[..., 3, 3] = 1
    return matrix


def decomposed(matrix: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the translation, rotation and scale nearest to matrices `(…, 4, 4)`; shear is lost."""
    linear = matrix[..., :3, :3]
    scale = np.linalg.norm(linear, axis=-2)
    mirrored = np.linalg.det(linear) < 0
    scale = np.where(mirrored[..., None], scale * [-1.0, 1.0, 1.0], scale)
    return matrix[..., :3, 3], quaternion(linear / np.where(scale == 0, 1, scale)[..., None, :]), scale


def rotation_matrix(q: Floats) -> Floats:
    """Return the rotations `(…, 3, 3)` of unit quaternions `(…, 4)`."""
    x, y, z, w = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion(rotation: Floats) -> Floats:
    """Return unit quaternions `(…, 4)` of rotations `(…, 3, 3)`.

    The quaternion is read from the row of the symmetric matrix 4 q qᵀ with the largest
    diagonal, which is never near zero.
    """
    r = rotation
    trace = r[..., 0, 0] + r[..., 1, 1] + r[..., 2, 2]
    product = np.empty((*r.shape[:-2], 4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        product[..., i, i] = 1 + 2 * r[..., i, i] - trace
        product[..., i, j] = product[..., j, i] = r[..., i, j] + r[..., j, i]
        product[..., i, 3] = product[..., 3, i] = r[..., k, j] - r[..., j, k]
    product[..., 3, 3] = 1 + trace
    best = np.argmax(np.diagonal(product, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(product, best[..., None, None], axis=-2)[..., 0, :]
    return np.asarray(q / np.maximum(np.linalg.norm(q, axis=-1, keepdims=True), np.finfo(float).tiny))


def slerped(a: Floats, b: Floats, u: Floats) -> Floats:
    """Interpolate unit quaternions `(F, 4)` along the shorter great arc, by `u` `(F, 1)` from 0 to 1."""
    dot = (a * b).sum(axis=-1, keepdims=True)
    b = np.where(dot < 0, -b, b)
    angle = np.arccos(np.clip(np.abs(dot), 0, 1))
    near = angle < 1e-6
    sine = np.where(near, 1, np.sin(angle))
    q = np.where(near, a + u * (b - a), (np.sin((1 - u) * angle) * a + np.sin(u * angle) * b) / sine)
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def invertible(matrices: Floats) -> NDArray[np.bool_]:
    """Return which matrices `(…, 4, 4)` have an inverse worth the name."""
    linear = matrices[..., :3, :3]
    size = np.linalg.norm(linear, axis=(-2, -1))
    return np.asarray(np.abs(np.linalg.det(linear)) > 1e-12 * size**3)


def continuous(q: Floats) -> Floats:
    """Flip signs of quaternions `(F, 4)` over time so that neighbours lie on the same side."""
    flips = np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    return np.concatenate([q[:1], q[1:] * np.cumprod(flips)[:, None]])
