"""Judging a method on captures that come without a truth.

Three questions can still be asked: does what was learnt predict markers that it was not
shown, do symmetric movements get symmetric weights, and does the character's mouth close
when the actor's does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mien.core import Correspondence, InputError, Markers, Rig
from mien.core.arrays import Floats, Ints
from mien.evaluate.gaps import gaps
from mien.evaluate.metrics import millimetre
from mien.evaluate.yardstick import sides
from mien.geometry.tps import fit_thin_plate
from mien.retargeting.method import Method
from mien.retargeting.prepare import prepare
from mien.retargeting.shape_retargeter import ShapeRetargeter

MOVED_CM = 0.1
"""A face is doing something while its points are this far from rest, root mean square."""
SYMMETRIC = 0.25
"""A movement is symmetric if it differs from its mirror image by no more than this share of itself."""
PARTNER_CM = 1.0
"""Two markers are each other's mirror image if they are this close to it."""


@dataclass(frozen=True)
class Prediction:
    """How well held-out markers are predicted [mm on a human face].

    Attributes:
        motion_mm: how far they move, root mean square over frames and markers.
        error_mm: how far the prediction is off.
        gain: slope through zero of predicted on actual movement (1 is right).
        shown_mm: how far off the fit is at the markers that were shown.
    """

    motion_mm: float
    error_mm: float
    gain: float
    shown_mm: float


@dataclass(frozen=True)
class Symmetry:
    """How alike both sides of the face are treated.

    Attributes:
        frames: how many frames show a symmetric movement.
        difference: `Σ |left - right| / Σ (|left| + |right|)` of the weights there (0 is right).
    """

    frames: int
    difference: float


@dataclass(frozen=True)
class Closure:
    """Whether the character's lips meet when the actor's do.

    Attributes:
        frames: how many frames the actor's lips meet in while the mouth is doing something.
        lip_mm: the character's mean lip gap there, beyond its gap at rest [mm on a 23 cm head].
        lip_p95_mm: its 95th percentile.
    """

    frames: int
    lip_mm: float
    lip_p95_mm: float


def predict_held_out(
    method: Method, character: Rig, take: Markers, pairs: Correspondence, *, folds: int = 10, stride: int = 1
) -> Prediction:
    """Fit on most of the pairs and predict the rest, each pair being held out once.

    The actor's shapes at a held-out marker are the character's there, corrected by what the
    fit changed at its neighbours (interpolated by a thin plate).

    Args:
        method: a method that gives the actor shapes of their own.
        character: the rig.
        take: the capture, used for fitting and for testing.
        pairs: which marker is which point of the character.
        folds: in how many parts the pairs are held out.
        stride: test every so many frames.

    Raises:
        InputError: the method has no shapes to predict with, or too few pairs are left.
    """
    whole = prepare(character, take, pairs)
    actual = whole.take[::stride]
    predicted, shown = np.full_like(actual, np.nan), []
    rest = whole.neutral
    for fold in range(folds):
        out = np.arange(len(whole.pairs)) % folds == fold
        kept = whole.pairs.take(np.flatnonzero(~out))
        fitted = method.fit(character, take, kept, neutral=replace(rest, points=rest.points[~out]))
        if not isinstance(fitted, ShapeRetargeter):
            raise InputError(f"the method {method.name!r} has no shapes of the actor, so it cannot predict markers.")
        clip, report = fitted.retarget(replace(take, points=take.points[::stride], fps=take.fps / stride))
        shown.append(np.nanmean(report.fit_mm**2))
        change = fitted.shapes - whole.terms.deltas[:, ~out]
        flat = change.transpose(1, 0, 2).reshape(len(kept), -1)
        correction = fit_thin_plate(whole.terms.actor_neutral[~out], flat)(whole.terms.actor_neutral[out])
        shapes = whole.terms.deltas[:, out] + correction.reshape(-1, len(change), 3).transpose(1, 0, 2)
        predicted[:, out] = np.tensordot(clip.values, shapes, axes=1)
    seen = ~np.isnan(actual)
    a, p = actual[seen], predicted[seen]
    return Prediction(_rms_mm(a), _rms_mm(p - a), float((a * p).sum() / (a**2).sum()), float(np.sqrt(np.mean(shown))))


def symmetry(
    weights: Floats, names: tuple[str, ...], take: Floats, neutral: Floats, character_neutral: Floats
) -> Symmetry:
    """Compare the weights of both sides while the actor moves symmetrically.

    Args:
        weights: `(F, K)` the result.
        names: of its shapes; left and right are told by them.
        take: `(F, M, 3)` displacements of the markers with the head held still [cm].
        neutral: `(M, 3)` the actor at rest [cm].
        character_neutral: `(M, 3)` the character's points at rest, placed on the actor [cm].
    """
    partner, normal = mirror_partners(neutral, character_neutral)
    both = partner >= 0
    here = take[:, both]
    there = take[:, partner[both]]
    there = there - 2 * (there @ normal)[..., None] * normal
    with np.errstate(invalid="ignore"):
        size = np.sqrt(np.nanmean((here**2).sum(axis=2), axis=1))
        unlike = np.sqrt(np.nanmean(((here - there) ** 2).sum(axis=2), axis=1))
        frames = (size > MOVED_CM) & (unlike < SYMMETRIC * size)
    pairs = sides(names)
    left, right = (weights[frames][:, [pair[i] for pair in pairs]] for i in (0, 1))
    total = (np.abs(left) + np.abs(right)).sum()
    return Symmetry(int(frames.sum()), float(np.abs(left - right).sum() / total) if total > 0 else float("nan"))


def mirror_partners(neutral: Floats, reference: Floats) -> tuple[Ints, Floats]:
    """Find the plane that mirrors a face onto itself, and which point is whose mirror image.

    Args:
        neutral: `(M, 3)` points of the face at rest [cm].
        reference: `(M, 3)` the same points on a symmetric face in the same place.

    Returns:
        `(M,)` the partner of each point (itself on the midline), -1 where there is none; and the plane's normal.
    """
    centre, normal = _mirror_plane(reference)
    image = neutral - 2 * ((neutral - centre) @ normal)[:, None] * normal
    gap = np.linalg.norm(image[:, None] - neutral[None], axis=2)
    nearest = gap.argmin(axis=1)
    mutual = nearest[nearest] == np.arange(len(neutral))
    close = gap[np.arange(len(neutral)), nearest] < PARTNER_CM
    return np.where(mutual & close, nearest, -1), normal


def closures(character: Rig, weights: Floats, upper: Floats, lower: Floats) -> Closure | None:
    """Measure the character's lip gap while the actor's lips meet; None if the character lacks the landmarks.

    The actor's lips meet while the markers above and below them are no farther apart than
    in the closest tenth of the frames.

    Args:
        character: the rig, with landmarks.
        weights: `(F, K)` the result.
        upper: `(F, 3)` the actor's marker on the upper lip, in any unit.
        lower: `(F, 3)` that on the lower lip.
    """
    measured = gaps(character, weights, millimetre(character))
    if measured is None:
        return None
    apart = np.linalg.norm(upper - lower, axis=1)
    met = apart <= np.nanquantile(apart, 0.1)
    if not met.any():
        return Closure(0, float("nan"), float("nan"))
    return Closure(int(met.sum()), float(measured.lips[met].mean()), float(np.quantile(measured.lips[met], 0.95)))


def _mirror_plane(points: Floats) -> tuple[Floats, Floats]:
    """Return the point and normal of the plane about which points mirror onto themselves best, among their axes."""
    centre = points.mean(axis=0)
    axes = np.linalg.svd(points - centre)[2]
    misfit = [_mirror_misfit(points - centre, axis) for axis in axes]
    best = axes[int(np.argmin(misfit))]
    for _ in range(20):
        image = points - 2 * ((points - centre) @ best)[:, None] * best
        partner = np.linalg.norm(image[:, None] - points[None], axis=2).argmin(axis=1)
        across = points - points[partner]
        far = np.linalg.norm(across, axis=1) > PARTNER_CM
        signed = across[far] * np.sign(across[far] @ best)[:, None]
        best = signed.sum(axis=0) / np.linalg.norm(signed.sum(axis=0))
        centre = ((points + points[partner]) / 2).mean(axis=0)
    return centre, best


def _mirror_misfit(points: Floats, axis: Floats) -> float:
    image = points - 2 * (points @ axis)[:, None] * axis
    return float(np.linalg.norm(image[:, None] - points[None], axis=2).min(axis=1).mean())


def _rms_mm(displacements: Floats) -> float:
    """Return the root mean square length, in mm, of displacements [cm] flattened to coordinates."""
    return float(10 * np.sqrt(3 * (displacements**2).mean()))
