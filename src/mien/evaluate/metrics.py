"""Figures of a result against the truth: weights, surface, smoothness.

Every figure is a pure function of arrays.  Weights are `(F, K)` with 1 for a shape's
full extent; frames whose truth is NaN are left out by the caller.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mien.core import InputError, Rig
from mien.core.arrays import Floats
from mien.core.units import face_radius

HEAD_M = 0.23
"""Errors are given on a head of this size from chin to crown …"""
LANDMARK_RADIUS_MM = 51.0
"""… whose facial landmarks are this far from their centre, root mean square (MakeHuman's adult is 22.9 cm)."""
MOVES = 0.1
"""A shape moves in a take if the 99th percentile of its weight, either way, reaches this."""
MOVING_MM = 1.0
"""A vertex moves in a take if the truth takes it this far from rest."""
ACTIVE = 1e-3
"""A weight above this, either way, is active."""
ONE_SIDE, SILENT = 0.3, 0.1
"""An expression is one-sided while one side is above the first and the other below the second."""
MOST_VERTICES = 2000
"""Denser surfaces are measured at every so many of their vertices."""
CHUNK = 128
"""Frames posed at a time, so that long takes need little memory."""


@dataclass(frozen=True, eq=False)
class WeightFigures:
    """How close weights are to the truth.

    Attributes:
        rmse: root mean square of the difference, over frames and moving shapes.
        correlation: Pearson correlation over time of the moving shapes taken together, each about its own mean,
            so that shapes count by how much they move.
        correlation_each: the mean of their own correlations, so that each counts alike; 0 for a constant result.
        gain: slope through zero of result on truth, `Σ r t / Σ t²` over frames and moving shapes (1 is right).
        per_shape_rmse: `(K,)` the same, shape by shape; NaN where it does not move.
        per_shape_correlation: `(K,)`.
        per_shape_gain: `(K,)`.
        moving: `(K,)` which shapes count.
    """

    rmse: float
    correlation: float
    correlation_each: float
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
        none = float("nan")
        return WeightFigures(none, none, none, none, rmse, correlation, gain, moving)
    return WeightFigures(
        float(np.sqrt(((r - t) ** 2).mean())),
        float(_correlations((r - r.mean(axis=0)).reshape(-1, 1), (t - t.mean(axis=0)).reshape(-1, 1))[0]),
        float(correlation[moving].mean()),
        float((r * t).sum() / power.sum()),
        rmse,
        correlation,
        gain,
        moving,
    )


def jerk_ratio(result: Floats, truth: Floats) -> float:
    """Return how jerky weights `(F, K)` are: root-mean-square third difference over the truth's (1 is right)."""
    _check_alike(result, truth)
    third = [np.sqrt((np.diff(w, 3, axis=0) ** 2).mean()) if len(w) > 3 else np.nan for w in (result, truth)]
    return float(third[0] / third[1]) if third[1] > 0 else float("nan")


def active_per_frame(weights: Floats) -> float:
    """Return how many of the weights `(F, K)` are active in a frame, on average."""
    return float((np.abs(weights) > ACTIVE).sum(axis=1).mean())


def other_side(result: Floats, truth: Floats, sides: Sequence[tuple[int, int]]) -> float:
    """Return how much of a one-sided expression appears on the other side (0 is right).

    Args:
        result: `(F, K)` weights.
        truth: `(F, K)` true weights.
        sides: columns of the left and right version of a shape.

    Returns:
        The result's weight on the silent side over the truth's on the acting side, over
        all frames in which only one side acts; NaN if there is none.
    """
    _check_alike(result, truth)
    leaked = acted = 0.0
    for pair in sides:
        for acting, silent in (pair, pair[::-1]):
            alone = (truth[:, acting] > ONE_SIDE) & (truth[:, silent] < SILENT)
            leaked += float(np.abs(result[alone, silent] - truth[alone, silent]).sum())
            acted += float(truth[alone, acting].sum())
    return leaked / acted if acted > 0 else float("nan")


def millimetre(rig: Rig) -> float:
    """Return the length, in the rig's unit, that is 1 mm if its head were 23 cm from chin to crown.

    Heads are compared by their landmarks, because crops and craniums differ.

    Raises:
        InputError: the rig has no landmarks.
    """
    if not rig.landmarks:
        raise InputError(
            f"{rig.name} has no landmarks, so nothing says how large its head is; put {rig.name}.landmarks.json beside it."
        )
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


def moving_surface(rig: Rig, truth: Floats, unit: float) -> NDArray[np.float32]:
    """Return the deltas `(3, K, V)` [mm] of the vertices that the truth moves, at most about `MOST_VERTICES` of them.

    Args:
        rig: the character.
        truth: `(F, K)` weights.
        unit: length of a millimetre in the rig's unit, see `millimetre`.
    """
    deltas = (rig.blendshapes.deltas / unit).transpose(2, 0, 1).astype(np.float32)
    deltas = deltas[:, :, :: max(1, deltas.shape[2] // MOST_VERTICES)]
    reach = np.zeros(deltas.shape[2], dtype=np.float32)
    for part in _chunks(truth):
        np.maximum(reach, _squared(part, deltas).max(axis=0), out=reach)
    return np.ascontiguousarray(deltas[:, :, reach > MOVING_MM**2])


def vertex_error(surface: NDArray[np.float32], result: Floats, truth: Floats) -> VertexError:
    """Pose a character with result and truth and measure the distance between the two.

    Args:
        surface: as `moving_surface` returns it.
        result: `(F, K)` weights.
        truth: `(F, K)` true weights.
    """
    _check_alike(result, truth)
    if not surface.shape[2]:
        return VertexError(float("nan"), float("nan"))
    off = np.concatenate([np.sqrt(_squared(part, surface)) for part in _chunks(result - truth)])
    return VertexError(float(off.mean(dtype=np.float64)), float(np.quantile(off, 0.95)))


def shape_error(shapes: Floats, truth: Floats, counted: np.ndarray) -> float:
    """Return `|Δp - Δp*| / |Δp*|` over the counted shapes; both `(K, M, 3)` in one unit."""
    power = (truth[counted] ** 2).sum()
    return float(np.sqrt(((shapes[counted] - truth[counted]) ** 2).sum() / power)) if power > 0 else float("nan")


def _chunks(weights: Floats) -> list[NDArray[np.float32]]:
    return [weights[begin : begin + CHUNK].astype(np.float32) for begin in range(0, len(weights), CHUNK)]


def _squared(weights: NDArray[np.float32], deltas: NDArray[np.float32]) -> NDArray[np.float32]:
    x, y, z = (np.square(weights @ axis) for axis in deltas)
    return np.asarray(x + y + z)


def _correlations(result: Floats, truth: Floats) -> Floats:
    r, t = result - result.mean(axis=0), truth - truth.mean(axis=0)
    scale = np.sqrt((r**2).sum(axis=0) * (t**2).sum(axis=0))
    return np.asarray(np.divide((r * t).sum(axis=0), scale, out=np.zeros(r.shape[1]), where=scale > 1e-12))


def _check_alike(result: Floats, truth: Floats) -> None:
    if result.shape != truth.shape or result.ndim != 2 or not len(result):
        raise InputError(
            f"result and truth must be frames × shapes of the same size, but are {result.shape} and {truth.shape}."
        )
