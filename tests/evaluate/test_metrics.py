"""The figures say what they are named for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import InputError, Mesh, SurfacePoints
from mien.evaluate.metrics import (
    LANDMARK_RADIUS_MM,
    active_per_frame,
    jerk_ratio,
    millimetre,
    moving_surface,
    other_side,
    shape_error,
    vertex_error,
    weight_figures,
)
from mien.evaluate.yardstick import sides
from tests.conftest import grid_rig


@pytest.fixture
def truth(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(0, 1, (200, 3))


def test_the_truth_itself_scores_perfectly(truth: np.ndarray) -> None:
    found = weight_figures(truth, truth)
    assert found.rmse == 0
    assert found.correlation == pytest.approx(1)
    assert found.correlation_each == pytest.approx(1)
    assert found.gain == pytest.approx(1)
    assert jerk_ratio(truth, truth) == pytest.approx(1)


@pytest.mark.parametrize("factor", [0.3, 1.7])
def test_gain_is_the_factor_of_a_scaled_result_and_correlation_does_not_see_it(
    truth: np.ndarray, factor: float
) -> None:
    found = weight_figures(factor * truth, truth)
    assert found.gain == pytest.approx(factor)
    np.testing.assert_allclose(found.per_shape_gain, factor)
    assert found.correlation == pytest.approx(1)
    assert found.rmse == pytest.approx(abs(factor - 1) * np.sqrt((truth**2).mean()))


def test_gain_is_not_biased_by_noise_that_has_nothing_to_do_with_the_truth(rng: np.random.Generator) -> None:
    truth = rng.uniform(0, 1, (20000, 2))
    assert weight_figures(truth + rng.normal(0, 0.3, truth.shape), truth).gain == pytest.approx(1, abs=0.02)


def test_a_constant_result_has_no_correlation(truth: np.ndarray) -> None:
    found = weight_figures(np.full_like(truth, 0.5), truth)
    assert found.correlation_each == 0
    assert found.correlation == 0


def test_shapes_that_do_not_move_or_do_not_count_are_left_out(truth: np.ndarray) -> None:
    still = np.hstack([truth, np.zeros((len(truth), 1))])
    wrong = still.copy()
    wrong[:, 2:] = 7
    found = weight_figures(wrong, still, np.array([True, True, False, True]))
    assert found.moving.tolist() == [True, True, False, False]
    assert found.rmse == 0
    assert np.isnan(found.per_shape_rmse[2:]).all()


def test_a_take_in_which_nothing_moves_has_no_figures() -> None:
    assert np.isnan(weight_figures(np.ones((5, 2)), np.zeros((5, 2))).gain)


def test_arrays_of_different_size_are_refused(truth: np.ndarray) -> None:
    with pytest.raises(InputError, match="same size"):
        weight_figures(truth[:-1], truth)


def test_jitter_raises_the_jerk_ratio_and_smoothing_lowers_it(rng: np.random.Generator) -> None:
    wave = np.sin(np.linspace(0, 20, 300))[:, None]
    assert jerk_ratio(wave + rng.normal(0, 0.01, wave.shape), wave) > 2
    assert jerk_ratio(0.5 * wave, wave) == pytest.approx(0.5)


def test_active_weights_are_counted_per_frame() -> None:
    assert active_per_frame(np.array([[0.5, 0, -0.2], [0, 0, 0.0]])) == 1


def test_what_leaks_to_the_other_side_is_counted_as_a_share() -> None:
    truth = np.array([[0.8, 0.0], [0.0, 0.6], [0.5, 0.5]])
    assert other_side(truth, truth, [(0, 1)]) == 0
    leaking = np.array([[0.8, 0.4], [0.3, 0.6], [0.9, 0.1]])
    assert other_side(leaking, truth, [(0, 1)]) == pytest.approx(0.5)
    assert np.isnan(other_side(truth[2:], truth[2:], [(0, 1)]))


def test_sides_are_found_by_name_and_directions_are_not_sides() -> None:
    names = ("mouthSmileRight", "jawOpen", "jawLeft", "jawRight", "mouthSmileLeft")
    assert sides(names) == [(4, 0)]


@pytest.mark.parametrize("scale", [1.0, 30.0])
def test_a_millimetre_grows_with_the_head(scale: float) -> None:
    rig = grid_rig()
    vertices = rig.neutral.vertices * scale
    marked = replace(
        rig,
        neutral=Mesh(vertices, rig.neutral.triangles),
        landmarks={"all": SurfacePoints.at_vertices(np.arange(len(vertices)))},
    )
    radius = np.sqrt(((vertices - vertices.mean(axis=0)) ** 2).sum(axis=1).mean())
    assert millimetre(marked) == pytest.approx(radius / LANDMARK_RADIUS_MM)


def test_a_head_without_landmarks_has_no_millimetre() -> None:
    with pytest.raises(InputError, match="landmarks"):
        millimetre(grid_rig())


def test_vertex_error_is_the_distance_between_the_posed_surfaces(rng: np.random.Generator) -> None:
    rig = grid_rig()
    result, truth = rng.uniform(0, 1, (2, 300, 3))
    surface = moving_surface(rig, truth, 0.001)
    apart = 1000 * np.linalg.norm(rig.pose(result) - rig.pose(truth), axis=2)
    moving = 1000 * np.linalg.norm(rig.pose(truth) - rig.neutral.vertices, axis=2).max(axis=0) > 1
    found = vertex_error(surface, result, truth)
    assert surface.shape == (3, 3, moving.sum())
    assert found.mean_mm == pytest.approx(apart[:, moving].mean(), rel=1e-4)
    assert found.p95_mm == pytest.approx(np.quantile(apart[:, moving], 0.95), rel=1e-4)


def test_shape_error_is_relative_to_the_true_shapes(rng: np.random.Generator) -> None:
    shapes = rng.normal(size=(4, 9, 3))
    counted = np.array([True, True, False, True])
    assert shape_error(1.5 * shapes, shapes, counted) == pytest.approx(0.5)
