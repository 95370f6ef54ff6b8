"""Rigid and similarity alignment of point sets, robust to what moves and what is missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.core.errors import InputError


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
    w = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-300)
    centre_s = w @ source
    weighted = w[..., None] * target
    centre_t = weighted.sum(axis=1)
    moment = np.swapaxes(weighted - w[..., None] * centre_t[:, None], 1, 2) @ source
    left, _, right = np.linalg.svd(moment)
    flip = np.ones((len(target), 3))
    flip[:, 2] = np.sign(np.linalg.det(left @ right))
    motion = np.zeros((len(target), 4, 4))
    motion[:, :3, :3] = (left * flip[:, None, :]) @ right
    motion[:, :3, 3] = centre_t - np.einsum("fab,fb->fa", motion[:, :3, :3], centre_s)
    motion[:, 3, 3] = 1
    return motion


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
    filled = np.where(seen[..., None], points, 0.0)
    base = stability * seen
    weights = base
    for _ in range(iterations):
        motion = rigid(neutral, filled, weights)
        residuals = np.linalg.norm(filled - transform(motion, neutral), axis=2)
        weights = base / (1 + (residuals / softness) ** 2) ** 2
    usable = (base > 0).sum(axis=1) >= 3
    last = np.maximum.accumulate(np.where(usable, np.arange(len(points)), -1))
    motion = np.where((last >= 0)[:, None, None], motion[last], np.eye(4))
    residuals = np.linalg.norm(filled - transform(motion, neutral), axis=2)
    return motion, np.where(seen, residuals, np.nan)


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
