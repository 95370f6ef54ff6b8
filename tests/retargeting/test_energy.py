"""Damping: shapes that are a little wrong do not work against each other."""

from __future__ import annotations

import numpy as np
import pytest

from mien.retargeting.energy import FrameSolver, frame_solver
from mien.retargeting.settings import SolveSettings


def solver(shapes: np.ndarray, damping: float) -> FrameSolver:
    count, points, _ = shapes.shape
    settings = SolveSettings(sparsity=0.0, smooth=0.0, bounds=None, damping=damping)
    names = [f"s{k}" for k in range(count)]
    return frame_solver(shapes, names, np.zeros((count, count)), np.ones(points), settings)


@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
def test_damping_costs_a_shape_alone_its_share_whatever_its_size(size: float, rng: np.random.Generator) -> None:
    shape = size * rng.normal(size=(1, 20, 3))
    found = solver(shape, 0.1).step(0.7 * shape[0], None)
    assert found == pytest.approx([0.7 / 1.1], rel=1e-4)


def test_damping_keeps_opposed_shapes_from_pulling_against_each_other(rng: np.random.Generator) -> None:
    push = rng.normal(size=(20, 3))
    shapes = np.stack([push, -push + 0.1 * rng.normal(size=(20, 3))])
    frame = 0.5 * push + 0.1 * rng.normal(size=(20, 3))
    effort = [np.abs(solver(shapes, damping).step(frame, None)).sum() for damping in (0.0, 0.01, 0.1)]
    assert effort[0] > effort[1] > effort[2]


def test_damping_counts_points_by_their_confidence(rng: np.random.Generator) -> None:
    shapes = rng.normal(size=(2, 20, 3))
    settings = SolveSettings(sparsity=0.0, smooth=0.0, bounds=None, damping=0.2)
    confidence = np.repeat([1.0, 0.0], 10)
    half = frame_solver(shapes, "ab", np.zeros((2, 2)), confidence, settings).step(shapes[0], None)
    alone = frame_solver(shapes[:, :10], "ab", np.zeros((2, 2)), np.ones(10), settings).step(shapes[0, :10], None)
    assert half == pytest.approx(alone, abs=1e-6)
