"""Figures of a result against the truth: weights, surface, smoothness.

Every figure is a pure function of arrays.  Weights are `(F, K)` with 1 for a shape's
full extent; frames whose truth is NaN are left out by the caller.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import InputError, Rig
from mien.core.arrays import Floats
from mien.core.units import face_radius

LANDMARK_RADIUS_MM = 51.0
"""Root-mean-square distance of the facial landmarks from their centre on a head of 23 cm from chin to crown."""
MOVES = 0.05
"""A shape moves in a take if the 99th percentile of its weight, either way, reaches this."""
MOVING_MM = 1.0
"""A vertex moves in a take if the truth takes it this far from rest."""
ACTIVE = 1e-3
"""A weight above this, either way, is active."""
CHUNK = 128
"""Frames posed at a time, so that long takes need little memory."""


@dataclass(frozen=True, eq=False)
class WeightFigures:
    """How close weights are to the truth.

    Attributes:
        rmse: root mean square of the difference, over frames and moving shapes.
        correlation: Pearson correlation over time, the mean over moving shapes; 0 for a constant result.
        gain: slope through zero of result on truth, `Σ r t / Σ t²` over frames and moving shapes (1 is right).
        per_shape_rmse, per_shape_correlation, per_shape_gain: `(K,)` the same, shape by shape; NaN where it does not move.
        moving: `(K,)` which shapes count.
    """

    rmse: float
    correlation: float
    gain: float
    per_shape_rmse: Floats
    per_shape_correlation: Floats
    per_shape_gain: Floats
    moving: np.ndarray


def moving_shapes(truth: Floats) -> np.ndarray:
    """Return `(K,)` whether each shape of `(F, K)` weights moves."""
    return np.asarray(np.quantile(np.abs(truth), 0.99, axis=0) >= MOVES)


def weight_figures(result: Floats, truth: Floats, counted: np.ndarray | None = None) -> WeightFigures:
    """Compare weights with the truth, over the shapes that move in it.

    Args:
        result: `(F, K)` weights.
        truth: `(F, K)` true weights.
        counted: `(K,)` shapes that may count; all if None.

    Raises:
        InputError: the shapes of the arrays differ.
    """
    _check_alike(result, truth)
    moving = moving_shapes(truth) if counted is None else moving_shapes(truth) & counted
    r, t = result[:, moving], truth[:, moving]
    power = (t**2).sum(axis=0)
    rmse, correlation, gain = (np.full(truth.shape[1], np.nan) for _ in range(3))
    rmse[moving] = np.sqrt(((r - t) ** 2).mean(axis=0))
    correlation[moving] = _correlations(r, t)
    gain[moving] = (r * t).sum(axis=0) / power
    if not moving.any():
        return WeightFigures(*[float("nan")] * 3, rmse, correlation, gain, moving)
    return WeightFigures(
        float(np.sqrt(((r - t) ** 2).mean())),
        float(correlation[moving].mean()),
        float((r * t).sum() / power.sum()),
        rmse,
        correlation,
        gain,
        moving,
    )


def jerk_ratio(result: Floats, truth: Floats) -> float:
    """Return the root-mean-square third difference of weights `(F, K)` over the truth's (1 is right, more is jitter)."""
    _check_alike(result, truth)
    third = [np.sqrt((np.diff(w, 3, axis=0) ** 2).mean()) if len(w) > 3 else np.nan for w in (result, truth)]
    return float(third[0] / third[1]) if third[1] > 0 else float("nan")


def active_per_frame(weights: Floats) -> float:
    """Return how many of the weights `(F, K)` are active in a frame, on average."""
    return float((np.abs(weights) > ACTIVE).sum(axis=1).mean())


def millimetre(rig: Rig) -> float:
    """Return the length, in the rig's unit, that is 1 mm if its head were 23 cm from chin to crown.

    Heads are compared by their landmarks, because crops and craniums differ.

    Raises:
        InputError: the rig has no landmarks.
    """
    if not rig.landmarks:
        raise InputError(f"{rig.name} has no landmarks, so errors on it cannot be given in millimetres; put {rig.name}.landmarks.json beside it.")
    points = np.concatenate([p.of(rig.neutral.vertices) for p in rig.landmarks.values()])
    return face_radius(points) / LANDMARK_RADIUS_MM


@dataclass(frozen=True)
class VertexError:
    """How far the surface is from where it should be, over the vertices that move and all frames.

    Attributes:
        mean_mm: mean distance [mm on a 23 cm head].
        p95_mm: its 95th percentile.
    """

    mean_mm: float
    p95_mm: float


def vertex_error(rig: Rig, result: Floats, truth: Floats, unit: float) -> VertexError:
    """Pose a character with result and truth and measure the distance between the two.

    Args:
        rig: the character.
        result, truth: `(F, K)` weights of its shapes.
        unit: length of a millimetre in the rig's unit, see `millimetre`.
    """
    _check_alike(result, truth)
    deltas = rig.blendshapes.deltas / unit
    k = deltas.shape[0]
    reach = np.zeros(deltas.shape[1])
    for begin in range(0, len(truth), CHUNK):
        posed = (truth[begin : begin + CHUNK] @ deltas.reshape(k, -1)).reshape(-1, *deltas.shape[1:])
        reach = np.maximum(reach, (posed**2).sum(axis=2).max(axis=0))
    moving = np.ascontiguousarray(deltas[:, reach > MOVING_MM**2])
    if not moving.shape[1]:
        return VertexError(float("nan"), float("nan"))
    off = np.empty((len(truth), moving.shape[1]), dtype=np.float32)
    for begin in range(0, len(truth), CHUNK):
        part = slice(begin, begin + CHUNK)
        apart = ((result[part] - truth[part]) @ moving.reshape(k, -1)).reshape(-1, *moving.shape[1:])
        off[part] = np.sqrt((apart**2).sum(axis=2))
    return VertexError(float(off.mean()), float(np.quantile(off, 0.95)))


def shape_error(shapes: Floats, truth: Floats, counted: np.ndarray) -> float:
    """Return `|Δp - Δp*| / |Δp*|` over the counted shapes; both `(K, M, 3)` in one unit."""
    power = (truth[counted] ** 2).sum()
    return float(np.sqrt(((shapes[counted] - truth[counted]) ** 2).sum() / power)) if power > 0 else float("nan")


def _correlations(result: Floats, truth: Floats) -> Floats:
    r, t = result - result.mean(axis=0), truth - truth.mean(axis=0)
    scale = np.sqrt((r**2).sum(axis=0) * (t**2).sum(axis=0))
    return np.asarray(np.divide((r * t).sum(axis=0), scale, out=np.zeros(r.shape[1]), where=scale > 1e-12))


def _check_alike(result: Floats, truth: Floats) -> None:
    if result.shape != truth.shape or result.ndim != 2 or not len(result):
        raise InputError(f"result and truth must be frames × shapes of the same size, but are {result.shape} and {truth.shape}.")
