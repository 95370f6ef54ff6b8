"""What the right answer is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Blendshapes, InputError, Markers, SurfacePoints
from mien.evaluate.conditions import Conditions, captured, missing, moving_head
from mien.evaluate.gaps import gap_figures, gaps
from mien.evaluate.truth import semantics, shown_range, split_sides
from tests.conftest import grid_rig


def test_merged_shapes_are_the_sum_of_their_parts_and_take_the_mean_of_their_weights() -> None:
    found = semantics(("browInnerUp_L", "browInnerUp_R", "jawOpen"), ("browInnerUp", "jawOpen", "wings"))
    np.testing.assert_array_equal(found.parts, [[1, 1, 0], [0, 0, 1], [0, 0, 0]])
    np.testing.assert_array_equal(found.drivers, [[0.5, 0.5, 0], [0, 0, 1], [0, 0, 0]])
    assert found.driven.tolist() == [True, True, False]


def test_small_parts_shape_a_shape_but_do_not_drive_it() -> None:
    found = semantics(("smile", "squint"), ("Grin",), {"Grin": {"smile": 2.0, "squint": 0.5}})
    np.testing.assert_array_equal(found.parts, [[1, 0.25]])
    np.testing.assert_array_equal(found.drivers, [[1, 0]])


@pytest.mark.parametrize("table", [{"grin": {"smile": 1.0}}, {"Grin": {"smle": 1.0}}])
def test_a_table_of_meanings_with_an_unknown_name_is_refused(table: dict[str, dict[str, float]]) -> None:
    with pytest.raises(InputError, match="Did you mean"):
        semantics(("smile",), ("Grin",), table)


def test_the_range_of_a_shape_is_its_99th_percentile_and_1_where_it_was_not_shown() -> None:
    training = np.stack([np.linspace(0, 0.8, 101), np.full(101, 0.02)], axis=1)
    full, shown = shown_range(training)
    np.testing.assert_allclose(full, [0.792, 1])
    assert shown.tolist() == [True, False]


def test_split_halves_add_up_to_the_whole_and_each_keeps_to_its_side() -> None:
    rig = grid_rig(shapes=("browInnerUp", "jawOpen"))
    x = rig.neutral.vertices[:, 0]
    corners = {"ibug_36": np.argmin(x), "ibug_45": np.argmax(x)}
    marked = replace(rig, landmarks={n: SurfacePoints.at_vertices(np.array([v])) for n, v in corners.items()})
    halves = split_sides(marked, ("browInnerUpLeft", "browInnerUpRight", "jawOpen"))
    assert halves.blendshapes.names == ("browInnerUp_L", "browInnerUp_R", "jawOpen")
    left, right, jaw = halves.blendshapes.deltas
    np.testing.assert_allclose(left + right, rig.blendshapes.deltas[0])
    np.testing.assert_array_equal(jaw, rig.blendshapes.deltas[1])
    assert not left[x == x.min()].any()
    assert not right[x == x.max()].any()


def test_a_rig_whose_sides_are_already_right_is_not_touched() -> None:
    rig = grid_rig()
    assert split_sides(rig, rig.blendshapes.names) is rig


def test_a_capture_without_noise_gaps_or_head_is_the_face_itself(rng: np.random.Generator) -> None:
    clean = Markers(("a", "b", "c", "d"), rng.normal(size=(50, 4, 3)), 30.0)
    np.testing.assert_array_equal(captured(clean, Conditions(noise_mm=0), 0.001, rng).points, clean.points)


def test_noise_is_in_millimetres_of_the_head(rng: np.random.Generator) -> None:
    clean = Markers(("a",), np.zeros((20000, 1, 3)), 30.0)
    noisy = captured(clean, Conditions(noise_mm=0.5), 0.002, rng).points
    assert noisy.std() == pytest.approx(0.001, rel=0.02)


def test_about_the_wanted_share_of_samples_is_missing(rng: np.random.Generator) -> None:
    assert missing((2000, 40), 0.05, 30.0, rng).mean() == pytest.approx(0.05, abs=0.005)


def test_a_moving_head_is_rigid_and_begins_at_rest(rng: np.random.Generator) -> None:
    motion = moving_head(300, 30.0, np.array([0, 1.5, 0.1]), 0.001, rng)
    np.testing.assert_allclose(motion[0], np.eye(4), atol=1e-12)
    turn = motion[:, :3, :3]
    np.testing.assert_allclose(turn @ np.swapaxes(turn, 1, 2), np.broadcast_to(np.eye(3), turn.shape), atol=1e-12)
    assert np.degrees(np.arccos((np.trace(turn[150]) - 1) / 2)) > 1


def test_lids_that_stop_short_are_off_by_the_gap_they_leave() -> None:
    rig = lidded_rig()
    blink = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 1.0]])
    truth = gaps(rig, blink, 0.001)
    assert truth is not None
    np.testing.assert_allclose(truth.lids, [[10, 10], [0, 0], [0, 0], [10, 10]], atol=1e-9)
    np.testing.assert_allclose(truth.lips, [0, 0, 4, 8], atol=1e-9)
    short = gaps(rig, blink * [0.9, 1], 0.001)
    assert short is not None
    found = gap_figures(short, truth)
    assert found.lid_mm == pytest.approx(1)
    assert found.blinks == 4
    over = gaps(rig, blink * [1.3, 1], 0.001)
    assert over is not None
    assert gap_figures(over, truth).lid_mm == pytest.approx(0), "lids that overlap are closed"


def test_a_take_without_blinks_and_closures_has_no_figures_of_them() -> None:
    rig = lidded_rig()
    still = gaps(rig, np.full((5, 2), 0.1), 0.001)
    assert still is not None
    found = gap_figures(still, still)
    assert found.blinks == 0
    assert np.isnan(found.lid_mm)


def lidded_rig() -> object:
    """Fourteen landmarks: lids 10 mm apart that one shape closes, lips that another opens by 8 mm."""
    numbers = [37, 41, 38, 40, 43, 47, 44, 46, 61, 67, 62, 66, 63, 65]
    rig = grid_rig(4)
    rest, close, part = np.zeros((16, 3)), np.zeros((16, 3)), np.zeros((16, 3))
    for i in range(7):
        lid = i < 4
        rest[2 * i], rest[2 * i + 1] = (0.01 * i, 0.005 if lid else -0.04, 0), (0.01 * i, -0.005 if lid else -0.041, 0)
        (close if lid else part)[2 * i, 1] = -0.01 if lid else 0.008
    marks = {f"ibug_{n}": SurfacePoints.at_vertices(np.array([i])) for i, n in enumerate(numbers)}
    return replace(
        rig,
        neutral=replace(rig.neutral, vertices=rest),
        blendshapes=Blendshapes(("blink", "part"), np.stack([close, part])),
        landmarks=marks,
    )
