"""What every method promises, whatever is inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Blendshapes, InputError, Markers, Rig
from mien.retargeting import METHODS, make_method, parameters
from tests.retargeting.actors import at_rest, capture, clip_of, face, pairs_of, points_on, weights

BY_EXAMPLE = [name for name, method in METHODS.items() if getattr(method, "by_example", False)]
UNLABELLED = [name for name in METHODS if name not in BY_EXAMPLE]
CAUSAL = [name for name in UNLABELLED if getattr(METHODS[name], "causal", True)]
POINT_METHODS = [name for name in UNLABELLED if name != "copy"]
EXACT = {"bounds": (0.0, 1.5), "sparsity": 1e-6, "prior": 0.0, "damping": 0.0, "smooth": 0.0}


def fitted(name: str, take: Markers, rig: Rig, **settings: object) -> object:
    points = points_on(rig)
    return make_method(name, settings).fit(rig, take, pairs_of(points))


@pytest.mark.parametrize("name", UNLABELLED)
def test_retargeting_changes_neither_its_inputs_nor_its_mind(name: str) -> None:
    rig = face()
    performance = clip_of(weights()) if name == "copy" else capture(rig, weights(), points_on(rig), head=True)
    before = (performance.values if name == "copy" else performance.points).copy()
    retargeter = fitted(name, performance, rig)
    first, _ = retargeter.retarget(performance)
    second, _ = fitted(name, performance, rig).retarget(performance)
    assert np.array_equal(first.values, second.values)
    assert np.array_equal(before, performance.values if name == "copy" else performance.points)


@pytest.mark.parametrize("smooth", [0.0, 0.01])
@pytest.mark.parametrize("name", CAUSAL)
def test_frame_by_frame_gives_what_the_whole_take_gives(name: str, smooth: float) -> None:
    rig = face()
    if name == "copy":
        retargeter = fitted(name, clip_of(weights()), rig)
        performance, frames = clip_of(weights()), weights()
    else:
        performance = capture(rig, weights(), points_on(rig), head=True, noise=1e-4)
        points = performance.points.copy()
        points[50:53, 4] = np.nan
        points[80] = np.nan
        performance = replace(performance, points=points)
        ahead = {"ahead": False} if "ahead" in parameters(make_method(name)) else {}
        retargeter = fitted(name, performance, rig, smooth=smooth, **ahead)
        frames = points
    whole, _ = retargeter.retarget(performance)
    state, folded = retargeter.start(), []
    for frame in frames:
        state, w = retargeter.step(state, frame)
        folded.append(w)
    assert np.abs(np.array(folded) - whole.values).max() < 1e-9


AHEAD = [name for name in UNLABELLED if "ahead" in parameters(make_method(name))]
NOT_CAUSAL = [name for name in UNLABELLED if name not in CAUSAL]


@pytest.mark.parametrize(
    ("name", "smooth"), [*((name, 0.0) for name in NOT_CAUSAL), *((name, 0.0005) for name in AHEAD)]
)
def test_frame_by_frame_comes_close_where_the_whole_take_knows_the_future(name: str, smooth: float) -> None:
    rig = face()
    performance = capture(rig, weights(), points_on(rig), head=True, noise=1e-4)
    retargeter = fitted(name, performance, rig, smooth=smooth)
    whole, _ = retargeter.retarget(performance)
    state, folded = retargeter.start(), []
    for frame in performance.points:
        state, w = retargeter.step(state, frame)
        folded.append(w)
    off = np.abs(np.array(folded) - whole.values)
    assert off.mean() < 0.01
    assert off.max() < 0.05
    assert off.max() > 0


def test_an_actor_who_is_the_character_gets_the_very_weights() -> None:
    rig = face()
    take = capture(rig, weights(), points_on(rig))
    points = points_on(rig)
    known = {"neutral": at_rest(rig, points), "head_moves": False}
    clip, report = make_method("rbf", EXACT).fit(rig, take, pairs_of(points), **known).retarget(take)
    assert np.abs(clip.values - weights()).max() < 1e-3
    assert report.gain == pytest.approx(1, abs=1e-3)
    assert np.nanmax(report.fit_mm) < 0.05


@pytest.mark.parametrize("name", POINT_METHODS)
def test_units_size_and_place_of_either_file_change_nothing(name: str) -> None:
    rig = face()
    big = Rig(
        replace(rig.neutral, vertices=rig.neutral.vertices * 100 + [5, 0, 1]),
        Blendshapes(rig.blendshapes.names, rig.blendshapes.deltas * 100),
    )
    reference = None
    for character, scale in ((rig, 1.0), (rig, 1000.0), (big, 1.0)):
        take = capture(rig, weights(), points_on(rig), scale=scale, head=True)
        clip, report = fitted(name, take, character).retarget(take)
        values = clip.values if reference is None else clip.values - reference
        reference = clip.values if reference is None else reference
        assert np.abs(values).max() < 1e-4 or (scale == 1.0 and character is rig)
        assert report.gain == pytest.approx(report.gain)


@pytest.mark.parametrize("name", POINT_METHODS)
def test_head_motion_changes_the_weights_little_and_is_carried_over(name: str) -> None:
    rig = face()
    still, moving = (capture(rig, weights(), points_on(rig), head=head) for head in (False, True))
    calm, _ = fitted(name, still, rig).retarget(still)
    turned, _ = fitted(name, moving, rig).retarget(moving)
    assert np.abs(calm.values - turned.values).mean() < 0.01
    assert turned.head is not None
    angle = np.arccos(np.clip((np.trace(turned.head[:, :3, :3], axis1=1, axis2=2) - 1) / 2, -1, 1))
    assert np.degrees(angle.max()) > 5


@pytest.mark.parametrize("smooth", [0.0, 0.1, 10.0])
def test_a_held_pose_is_held_at_any_smoothness(smooth: float) -> None:
    rig = face()
    values = np.repeat(np.array([[0.7, 0.5, 0, 0, 0, 0.3]]), 400, axis=0)
    take = capture(rig, weights(), points_on(rig))
    retargeter = make_method("rbf", {**EXACT, "smooth": smooth}).fit(
        rig, take, pairs_of(points_on(rig)), head_moves=False
    )
    held, _ = retargeter.retarget(capture(rig, values, points_on(rig)))
    assert np.abs(held.values[-1] - values[-1]).max() < 0.01


def test_a_one_sided_expression_stays_on_its_side() -> None:
    rig = face()
    take = capture(rig, weights(), points_on(rig))
    values = np.zeros((30, 6))
    values[:, 1] = np.linspace(0, 0.8, 30)
    for name in POINT_METHODS:
        known = parameters(make_method(name))
        settings = {key: value for key, value in (("bounds", (0.0, 1.1)), ("sparsity", 0.02)) if key in known}
        retargeter = make_method(name, settings).fit(rig, take, pairs_of(points_on(rig)), head_moves=False)
        clip, _ = retargeter.retarget(capture(rig, values, points_on(rig)))
        assert np.abs(clip.values[-1, 2]) < 0.05 * clip.values[-1, 1]


def test_bounds_exclusion_and_symmetry_are_kept() -> None:
    rig = face()
    take = capture(rig, weights(), points_on(rig), noise=5e-4)
    settings = {
        "bounds": (0.0, 0.6),
        "exclusive": [("smile_L", "smile_R")],
        "symmetric": [("blink_L", "blink_R")],
        "symmetry": 1e6,
    }
    clip, _ = fitted("rbf", take, rig, **settings).retarget(take)
    assert clip.values.min() >= 0
    assert clip.values.max() <= 0.6
    assert not ((clip.values[:, 1] != 0) & (clip.values[:, 2] != 0)).any()
    assert np.abs(clip.values[:, 3] - clip.values[:, 4]).max() < 1e-4


def test_a_shape_can_be_made_dear() -> None:
    rig = face()
    take = capture(rig, weights(), points_on(rig))
    free, _ = fitted("rbf", take, rig, sparsity=0.02).retarget(take)
    dear, _ = fitted("rbf", take, rig, sparsity=0.02, shape_sparsity={"browUp": 1e6}).retarget(take)
    assert free.values[:, 5].max() > 0.1
    assert not dear.values[:, 5].any()


def test_missing_markers_are_left_out_of_the_fit() -> None:
    rig = face()
    take = capture(rig, weights(), points_on(rig))
    retargeter = make_method("rbf", EXACT).fit(rig, take, pairs_of(points_on(rig)), head_moves=False)
    points = take.points.copy()
    points[:, ::7] = np.nan
    clip, report = retargeter.retarget(replace(take, points=points))
    assert np.abs(clip.values - weights()).max() < 0.01
    assert report.figures["missing_samples"] == 240 * 7


@pytest.mark.parametrize("name", POINT_METHODS)
def test_bad_input_is_refused_in_words(name: str) -> None:
    rig = face()
    points = points_on(rig)
    take = capture(rig, weights(), points)
    method = make_method(name)
    nothing = Rig(rig.neutral, Blendshapes((), np.zeros((0, len(rig.neutral.vertices), 3))))
    empty = Rig(rig.neutral, Blendshapes(SHAPES := ("a", "b"), np.zeros((len(SHAPES), len(rig.neutral.vertices), 3))))
    pairs = pairs_of(points)
    mirrored = replace(take, points=take.points * [-1, 1, 1])
    still = replace(take, points=np.repeat(take.points[:1], 50, axis=0))
    gone = replace(take, points=np.full_like(take.points, np.nan))
    for character, training, use, why in (
        (nothing, take, pairs, "no blendshapes"),
        (empty, take, pairs, "empty"),
        (rig, take, pairs.take(np.arange(3)), "at least 4"),
        (rig, take, pairs.take(np.arange(7)), "one plane|plane"),
        (rig, mirrored, pairs, "mirror"),
        (rig, still, pairs, "no movement"),
        (rig, gone, pairs, "only 0 of 49"),
        (rig, take.only(take.names[:20]), pairs, "unknown marker"),
        (rig, take, None, "--pairs"),
        (rig, clip_of(weights()), pairs, "--actor"),
    ):
        with pytest.raises(InputError, match=why):
            method.fit(character, training, use)


def test_a_single_frame_is_refused_for_training_but_not_for_solving() -> None:
    rig = face()
    take = capture(rig, weights(), points_on(rig))
    one = replace(take, points=take.points[30:31])
    with pytest.raises(InputError, match="no movement"):
        fitted("range-of-motion", one, rig)
    clip, _ = fitted("range-of-motion", take, rig).retarget(one)
    assert len(clip) == 1


def test_unknown_methods_and_parameters_list_the_known_ones() -> None:
    with pytest.raises(InputError, match="range-of-motion"):
        make_method("range-of-motoin")
    with pytest.raises(InputError, match="steepness"):
        make_method("range-of-motion", {"steepnes": 3})
    with pytest.raises(InputError, match="float"):
        make_method("range-of-motion", {"steepness": "high"})
    assert parameters(make_method("rbf", {"sparsity": "0.5"}))["sparsity"] == 0.5
    for key, value in (
        ("full", "2"),
        ("freedom", "-1"),
        ("steepness", "1e6"),
        ("smoothing", "-1"),
        ("keep", "5"),
        ("damping", "-1"),
    ):
        with pytest.raises(InputError, match=key):
            make_method("range-of-motion", {key: value})


def test_copying_maps_spellings_and_says_what_is_left_over() -> None:
    rig = face()
    clip = replace(clip_of(weights()), names=("JawOpen", "smileLeft", "smileRight", "blinkLeft", "blinkRight", "nod"))
    out, report = make_method("copy").fit(rig, clip).retarget(clip)
    assert np.array_equal(out.values[:, :5], clip.values[:, :5])
    assert not out.values[:, 5].any()
    assert {note.code for note in report.notes} == {"channels-unused", "shapes-undriven"}


def test_copying_holds_frames_without_tracking() -> None:
    rig = face()
    values = weights()
    values[10:20] = np.nan
    out, report = make_method("copy").fit(rig, clip_of(values)).retarget(clip_of(values))
    assert np.array_equal(out.values[19], values[9])
    assert "10 frames" in report.notes[-1].message


def test_parameters_that_are_not_one_number_have_a_written_form() -> None:
    method = make_method(
        "range-of-motion",
        {
            "off": "viseme_*, tongueOut",
            "exclusive": "jawLeft:jawRight",
            "shape_sparsity": "browUp:3",
            "bounds": "-0.5:1.5",
            "full_range": "false",
        },
    )
    found = parameters(method)
    assert found["off"] == ("viseme_*", "tongueOut")
    assert found["exclusive"] == (("jawLeft", "jawRight"),)
    assert found["shape_sparsity"] == {"browUp": 3.0}
    assert found["bounds"] == (-0.5, 1.5)
    assert found["full_range"] is False
    assert parameters(make_method("rbf", {"bounds": "none"}))["bounds"] is None
    for key, value in (("exclusive", "jawLeft"), ("bounds", "wide"), ("shape_sparsity", "browUp:much")):
        with pytest.raises(InputError, match="as in"):
            make_method("rbf", {key: value})


def test_shapes_that_are_off_stay_at_rest_and_are_named() -> None:
    rig = face()
    take = capture(rig, weights(), points_on(rig))
    clip, report = fitted("range-of-motion", take, rig, off="smile_*").retarget(take)
    assert not clip.values[:, 1:3].any()
    assert any(note.code == "shapes-off" and "smile_L, smile_R" in note.message for note in report.notes)


def test_the_published_preset_sets_every_published_constant() -> None:
    found = parameters(make_method("range-of-motion", {"preset": "paper"}))
    wanted = {
        "shapes": "alignment",
        "steepness": 15,
        "mesh": 0.01,
        "cross": 0.1,
        "keep": 0,
        "prominence": 0,
        "smoothing": 0,
        "prior": 0.3,
        "sparsity": 0.6,
        "smooth": 0,
        "bounds": None,
        "off": (),
    }
    assert {key: found[key] for key in wanted} == wanted
    with pytest.raises(InputError, match="paper"):
        make_method("range-of-motion", {"preset": "papre"})


def test_smoothing_is_alike_at_any_frame_rate() -> None:
    """Half the frame rate, every second frame: the same curve up to the sampling."""
    rig = face()
    values = np.repeat(weights(120), 2, axis=0)
    points = points_on(rig)
    take = capture(rig, values, points)
    fit = make_method("rbf", {**EXACT, "smooth": 0.02}).fit(rig, take, pairs_of(points), head_moves=False)
    fast, _ = fit.retarget(replace(take, fps=60.0))
    slow, _ = fit.retarget(replace(take, points=take.points[::2], fps=30.0))
    plain, _ = fit.retarget(replace(take, points=take.points[::2], fps=60.0))
    assert np.abs(fast.values[1::2] - slow.values).mean() < np.abs(fast.values[1::2] - plain.values).mean()
