"""Rigid and similarity alignment of point sets, robust to what moves and what is missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.core.errors import InputError

CHUNK = 512
"""Frames whose head motion is found at a time: what is worked on then stays in the processor's cache."""
CLEAR = 1e-6
"""A matrix of norm 1 whose determinant is above this is far enough from a singular or mirrored one."""
STEPS, SETTLED = 20, 1e-15
"""Newton's steps towards a rotation, and the change at which they end (six or seven do)."""
_PLACES = np.arange(9).reshape(3, 3)
ONE_ON, TWO_ON, ONE_TWO_ON, TWO_ONE_ON = (
    np.roll(_PLACES, (-down, -along), axis=(0, 1)).ravel() for down, along in ((1, 1), (2, 2), (1, 2), (2, 1))
)
"""Of each entry of a 3 × 3 matrix, the place of the one so many rows and columns on, which its cofactor needs."""


@dataclass(frozen=True, eq=False)
class Similarity:
    """The map `x ↦ scale · rotation · x + translation`, and how well it fits.

    Attributes:
        scale: uniform scale.
        rotation: `(3, 3)`, determinant +1.
        translation: `(3,)`.
        residual: root-mean-square distance left over, relative to the target's radius.
        mirrored_residual: the same if a mirror image were allowed.
    """

    scale: float
    rotation: Floats
    translation: Floats
    residual: float
    mirrored_residual: float

    def apply(self, points: Floats) -> Floats:
        """Map positions `(…, 3)`."""
        return np.asarray(self.scale * points @ self.rotation.T + self.translation)

    def invert(self, points: Floats) -> Floats:
        """Map positions `(…, 3)` back."""
        return np.asarray((points - self.translation) @ self.rotation / self.scale)

    def invert_vectors(self, vectors: Floats) -> Floats:
        """Map displacements `(…, 3)` back: no translation."""
        return np.asarray(vectors @ self.rotation / self.scale)

    def conjugate(self, rigid: Floats) -> Floats:
        """Carry rigid motions `(…, 4, 4)` of the source space into the target space."""
        there, back = np.eye(4), np.eye(4)
        there[:3, :3], there[:3, 3] = self.scale * self.rotation, self.translation
        back[:3, :3] = self.rotation.T / self.scale
        back[:3, 3] = -back[:3, :3] @ self.translation
        return np.asarray(there @ rigid @ back)


def similarity(source: Floats, target: Floats) -> Similarity:
    """Fit the least-squares similarity of paired points (Umeyama 1991).

    Args:
        source, target: `(M, 3)` paired points.

    Raises:
        InputError: fewer than 4 pairs, or one side coincides or lies in a plane.
    """
    if len(source) < 4:
        raise InputError(f"{len(source)} pairs are too few to place a face; give at least 4, spread over it.")
    _check_spread(source, "source")
    _check_spread(target, "target")
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    left, stretch, right = np.linalg.svd(b.T @ a)
    sign = np.sign(np.linalg.det(left @ right))
    power_a, power_b = (a**2).sum(), (b**2).sum()

    def residual(last: float) -> float:
        explained = (stretch[0] + stretch[1] + last * stretch[2]) ** 2 / (power_a * power_b)
        return float(np.sqrt(max(0.0, 1 - explained)))

    rotation = left @ np.diag([1, 1, sign]) @ right
    scale = float((stretch[0] + stretch[1] + sign * stretch[2]) / power_a)
    translation = target.mean(axis=0) - scale * rotation @ source.mean(axis=0)
    return Similarity(scale, rotation, translation, residual(sign), residual(1.0 if sign < 0 else -1.0))


def _check_spread(points: Floats, side: str) -> None:
    stretch = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if stretch[0] == 0:
        raise InputError(f"the {side} points of the pairs all coincide; spread them over the face.")
    if stretch[2] < 1e-3 * stretch[0]:
        raise InputError(f"the {side} points of the pairs lie in one plane; add pairs off it, such as the nose tip.")


def rigid(source: Floats, target: Floats, weights: Floats) -> Floats:
    """Fit weighted rigid motions from `source` to `target`, many at once.

    Args:
        source: `(M, 3)` points at rest.
        target: `(F, M, 3)` the same points later; any finite value where the weight is 0.
        weights: `(F, M)` non-negative.

    Returns:
        `(F, 4, 4)` motions.
    """
    rest, middle = source.mean(axis=0), target.mean(axis=1)
    motion = _rigid(source - rest, np.ascontiguousarray(np.moveaxis(target - middle[:, None], 2, 0)), weights)
    return _uncentred(motion, rest, middle)


def _rigid(source: Floats, target: Floats, weights: Floats) -> Floats:
    """Fit motions as `rigid`, of points `(M, 3)` and `(3, F, M)` that lie around the origin."""
    with_one = np.column_stack([source, np.ones(len(source))])
    share = 1 / np.maximum(weights.sum(axis=1), 1e-300)
    centre_s = (weights @ source) * share[:, None]
    sums = ((weights * target) @ with_one) * share[:, None]
    centre_t = sums[..., 3].T
    motion = np.zeros((len(weights), 4, 4))
    motion[:, :3, :3] = nearest_rotations(np.moveaxis(sums[..., :3], 0, 1) - centre_t[..., None] * centre_s[:, None])
    motion[:, :3, 3] = centre_t - np.einsum("fab,fb->fa", motion[:, :3, :3], centre_s)
    motion[:, 3, 3] = 1
    return motion


def _uncentred(motion: Floats, rest: Floats, middle: Floats) -> Floats:
    """Return motions `(F, 4, 4)` of points around `rest` to points around `middle` `(F, 3)`."""
    moved = motion.copy()
    moved[:, :3, 3] += middle - motion[:, :3, :3] @ rest
    return moved


def nearest_rotations(matrices: Floats) -> Floats:
    """Return for matrices `(F, 3, 3)` the rotations that are nearest to them, `(F, 3, 3)`.

    By Newton's iteration for the polar factor (Higham 1986), for all at once: a tenth of the
    time of as many singular value decompositions, which are left to what is nearly singular or mirrored.
    """
    x = np.ascontiguousarray(matrices.reshape(-1, 9).T)
    x /= np.maximum(np.sqrt((x * x).sum(axis=0)), 1e-300)
    clear = (x[:3] * _cofactors(x)[:3]).sum(axis=0) > CLEAR
    x = np.where(clear, x, np.eye(3).reshape(9, 1))
    for _ in range(STEPS):
        inverse = _cofactors(x)
        inverse /= (x[:3] * inverse[:3]).sum(axis=0)
        scale = np.sqrt(np.sqrt((inverse * inverse).sum(axis=0) / (x * x).sum(axis=0)))
        before, x = x, 0.5 * (scale * x + inverse / scale)
        if np.abs(x - before).max(initial=0.0) < SETTLED:
            break
    found = np.array(x.T).reshape(-1, 3, 3)
    if not clear.all():
        left, _, right = np.linalg.svd(matrices[~clear])
        left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
        found[~clear] = left @ right
    return found


def _cofactors(x: Floats) -> Floats:
    """Return the cofactors of matrices, each a column of `(9, F)`."""
    return np.asarray(x[ONE_ON] * x[TWO_ON] - x[ONE_TWO_ON] * x[TWO_ONE_ON])


def head_motion(
    neutral: Floats, points: Floats, stability: Floats, *, softness: float, iterations: int = 12
) -> tuple[Floats, Floats]:
    """Find the rigid head motion under a moving face, by reweighted Procrustes.

    Points that fit badly in a frame (an open jaw, a mislabelled marker) lose their
    say in that frame: weight `stability / (1 + r²/softness²)²`, iterated.

    Args:
        neutral: `(M, 3)` the face at rest.
        points: `(F, M, 3)`; NaN where a marker is missing.
        stability: `(M,)` how rigidly each point rides on the skull, non-negative.
        softness: the residual at which a point's weight falls to a quarter, in the unit of the points.
        iterations: rounds of reweighting.

    Returns:
        `(F, 4, 4)` motion from the neutral to each frame, and `(F, M)` residuals. A
        frame with fewer than 3 usable points keeps the motion of the frame before.
    """
    seen = ~np.isnan(points[..., 0])
    filled = np.where(seen, np.moveaxis(points, 2, 0), 0.0)
    rest, middle = neutral.mean(axis=0), filled.sum(axis=2) / np.maximum(seen.sum(axis=1), 1)
    base, around, target = stability * seen, neutral - rest, filled - middle[..., None]
    motion = np.empty((len(points), 4, 4))
    for begin in range(0, len(points), CHUNK):
        part = slice(begin, begin + CHUNK)
        weights = base[part]
        for _ in range(iterations):
            motion[part] = _rigid(around, target[:, part], weights)
            off = _squared_residuals(motion[part], around, target[:, part])
            weights = base[part] / (1 + off / softness**2) ** 2
    motion = _uncentred(motion, rest, middle.T)
    usable = (base > 0).sum(axis=1) >= 3
    last = np.maximum.accumulate(np.where(usable, np.arange(len(points)), -1))
    motion = np.where((last >= 0)[:, None, None], motion[last], np.eye(4))
    residuals = np.sqrt(_squared_residuals(motion, neutral, filled))
    return motion, np.where(seen, residuals, np.nan)


def _squared_residuals(motion: Floats, source: Floats, target: Floats) -> Floats:
    """Return how far motions `(F, 4, 4)` put points `(M, 3)` from `(3, F, M)`, squared, `(F, M)`."""
    with_one = np.column_stack([source, np.ones(len(source))])
    off = np.ascontiguousarray(np.moveaxis(motion[:, :3], 1, 0)) @ with_one.T
    off -= target
    return np.asarray(np.einsum("afm,afm->fm", off, off))


def transform(motion: Floats, points: Floats) -> Floats:
    """Apply motions `(F, 4, 4)` to points `(M, 3)` or `(F, M, 3)`."""
    moved = points @ np.swapaxes(motion[:, :3, :3], 1, 2)
    return np.asarray(moved + motion[:, None, :3, 3])


def inverse_rigid(motion: Floats) -> Floats:
    """Invert rigid motions `(F, 4, 4)`."""
    back = np.zeros_like(motion)
    turn = np.swapaxes(motion[..., :3, :3], -1, -2)
    back[..., :3, :3] = turn
    back[..., :3, 3] = -np.einsum("...ab,...b->...a", turn, motion[..., :3, 3])
    back[..., 3, 3] = 1
    return back
