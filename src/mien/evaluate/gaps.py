"""Whether eyes close and lips meet: the gaps between landmarks on the posed character.

A gap is how far the upper landmark stands above the lower, averaged over the pairs of
an eye or the mouth.  "Above" is the way the lids stand apart at rest.  Skin that
overlaps is closed, so gaps are never negative; lips meet at rest on every character, so
theirs is what exceeds the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import Rig
from mien.core.arrays import Floats
from mien.geometry.surface import unit
from mien.io.documents import join
from mien.vocabularies.openings import INNER_LIPS, LEFT_LIDS, RIGHT_LIDS

NEARLY = 0.2
"""An eye is closed while its gap is within this share of the resting gap of the smallest in the take."""
HALF = 0.5
"""A take whose smallest lid gap is above this share of the resting gap has no blink."""
STIRRED_MM = 1.0
"""The mouth is doing something while some lip landmark is this far from rest."""
MET_MM = 0.5
"""Lips meet, while it does, if their gap is within this of the smallest in the take."""
PARTED_MM = 2.0
"""A take whose smallest lip gap exceeds this has no closure."""


@dataclass(frozen=True, eq=False)
class Gaps:
    """Gaps over time [mm on a 23 cm head].

    Attributes:
        lids: `(F, 2)` of the right and the left eye.
        lips: `(F,)` in excess of the rest.
        stirred: `(F,)` the largest displacement of a lip landmark.
        lids_at_rest: `(2,)`.
    """

    lids: Floats
    lips: Floats
    stirred: Floats
    lids_at_rest: Floats


@dataclass(frozen=True)
class GapFigures:
    """How well closures come across; NaN where the truth has none.

    Attributes:
        lid_mm: mean difference of the lid gap from the truth's while the truth's eye is closed [mm].
        lid_p95_mm: its 95th percentile.
        lip_mm, lip_p95_mm: the same of the lips while they meet.
        blinks, closures: how many eye-frames and frames those are.
    """

    lid_mm: float
    lid_p95_mm: float
    lip_mm: float
    lip_p95_mm: float
    blinks: int
    closures: int


def gaps(rig: Rig, weights: Floats, millimetre: float) -> Gaps | None:
    """Measure the gaps of a posed character; None if it lacks the landmarks.

    Args:
        rig: the character, with iBUG landmarks.
        weights: `(F, K)`.
        millimetre: length of a millimetre in the rig's unit.
    """
    rows = (*RIGHT_LIDS, *LEFT_LIDS, *INNER_LIPS)
    if not all(f"ibug_{n}" in rig.landmarks for row in rows for n in row):
        return None
    upper, lower = (join([rig.landmarks[f"ibug_{row[i]}"] for row in rows]) for i in (0, 1))
    rest_up, rest_low = upper.of(rig.neutral.vertices), lower.of(rig.neutral.vertices)
    up = unit(unit(rest_up[:4] - rest_low[:4]).mean(axis=0))
    deltas = rig.blendshapes.deltas
    moved = [np.tensordot(weights, points.of(deltas), axes=1) / millimetre for points in (upper, lower)]
    rest = (rest_up - rest_low) @ up / millimetre
    change = (moved[0] - moved[1]) @ up
    lids = np.maximum(rest[:4] + change[:, :4], 0).reshape(len(weights), 2, 2).mean(axis=2)
    lips = np.maximum(change[:, 4:], 0).mean(axis=1)
    stirred = np.max([np.linalg.norm(m[:, 4:], axis=2).max(axis=1) for m in moved], axis=0)
    return Gaps(lids, lips, stirred, rest[:4].reshape(2, 2).mean(axis=1))


def closed_eyes(truth: Gaps) -> np.ndarray:
    """Return `(F, 2)` whether each eye is closed."""
    least = truth.lids.min(axis=0)
    closed = truth.lids <= least + NEARLY * truth.lids_at_rest
    return np.asarray(closed & (least <= HALF * truth.lids_at_rest))


def met_lips(truth: Gaps) -> np.ndarray:
    """Return `(F,)` whether the lips meet while the mouth is doing something."""
    stirred = truth.stirred >= STIRRED_MM
    least = truth.lips[stirred].min(initial=np.inf)
    return np.asarray(stirred & (least <= PARTED_MM) & (truth.lips <= least + MET_MM))


def gap_figures(result: Gaps, truth: Gaps) -> GapFigures:
    """Compare the gaps with the truth's where the truth is closed."""
    eyes, lips = closed_eyes(truth), met_lips(truth)
    lid = np.abs(result.lids - truth.lids)[eyes]
    lip = np.abs(result.lips - truth.lips)[lips]
    return GapFigures(*_mean_and_p95(lid), *_mean_and_p95(lip), int(eyes.sum()), int(lips.sum()))


def _mean_and_p95(values: Floats) -> tuple[float, float]:
    return (float(values.mean()), float(np.quantile(values, 0.95))) if values.size else (float("nan"), float("nan"))
