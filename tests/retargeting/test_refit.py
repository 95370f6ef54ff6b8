"""The actor's own shapes found from what the take shows: refit and calibration."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from mien.core import Examples, InputError
from mien.retargeting.prepare import prepare
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.range_of_motion.refit import (
    DOUBT,
    FRAMES,
    INDEPENDENT,
    LARGEST,
    NOISE_CM,
    Refit,
    Take,
    calibrated,
    personalise,
    refitted,
    strengthened,
)
from mien.retargeting.shape_retargeter import ShapeRetargeter
from tests.retargeting.actors import SHAPES, at_rest, capture, face, pairs_of, points_on, weights

SMALL = np.array([0.6, 0.8, 0.5, 1.3, 1.2, 0.7])
"""An actor's range, shape by shape."""


def acting(values: np.ndarray, *, noise: float = 0.0, scale: float = 1.0) -> tuple[Take, np.ndarray]:
    """A take of the face acting, and its shapes in the same terms."""
    rig, points = face(), points_on(face())
    take = capture(rig, values, points, noise=noise, scale=scale)
    prepared = prepare(rig, take, pairs_of(points), neutral=at_rest(rig, points, scale), head_moves=False)
    frames = prepared.take
    return Take(SHAPES, frames, np.ones(len(points)), (), frames[:0], np.empty((0, len(SHAPES)))), prepared.terms.deltas


def fitted(values: np.ndarray, examples: Examples | None = None, **settings: bool) -> ShapeRetargeter:
    rig, points = face(), points_on(face())
    known = {"neutral": at_rest(rig, points), "head_moves": False, "examples": examples}
    return RangeOfMotion(**settings).fit(rig, capture(rig, values, points), pairs_of(points), **known)


def explained(shapes: np.ndarray, take: Take) -> float:
    """The root mean square of what the shapes leave unexplained [cm]."""
    found = take.weights(shapes, take.frames, 1.0)
    return float(np.sqrt(((np.tensordot(found, shapes, axes=1) - take.frames) ** 2).mean()))


def distorted(shapes: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Shapes that are a little wrong wherever they act."""
    return np.asarray(shapes @ (np.eye(3) + 0.3 * rng.normal(size=(len(shapes), 3, 3))))


def strength(shapes: np.ndarray, true: np.ndarray) -> np.ndarray:
    """How much of each true shape is in each shape."""
    return np.asarray((shapes * true).sum(axis=(1, 2)) / (true**2).sum(axis=(1, 2)))


def alike(shapes: np.ndarray, true: np.ndarray) -> np.ndarray:
    """The cosine of each shape and the true one."""
    sizes = np.linalg.norm(shapes, axis=(1, 2)) * np.linalg.norm(true, axis=(1, 2))
    return np.asarray((shapes * true).sum(axis=(1, 2)) / sizes)


def test_after_calibration_the_strongest_weight_of_every_shape_is_one() -> None:
    take, shapes = acting(weights() * SMALL)
    found = take.weights(calibrated(shapes, take, 0.99), take.frames, LARGEST)
    assert np.quantile(found, 0.99, axis=0) == pytest.approx(1, abs=0.03)


def test_calibration_changes_the_strength_of_shapes_and_never_their_direction() -> None:
    take, shapes = acting(weights() * SMALL, noise=2e-4)
    ratio = calibrated(shapes, take, 0.99)[:, :, 1] / shapes[:, :, 1]
    assert np.ptp(ratio, axis=1) == pytest.approx(0, abs=1e-9)


def test_half_a_calibration_twice_over_is_a_whole_one() -> None:
    """In powers, for weights that answer to their own shape only."""
    take, shapes = acting(weights() * SMALL)
    whole = calibrated(shapes, take, 0.99)
    half = calibrated(shapes, take, 0.99, share=0.5)
    assert half**2 == pytest.approx(whole * shapes)


def test_a_shape_that_is_not_shown_keeps_its_strength() -> None:
    values = weights() * SMALL
    values[:, 2] *= 0.1
    take, shapes = acting(values)
    assert np.array_equal(calibrated(shapes, take, 0.99)[2], shapes[2])


def test_every_round_of_refitting_explains_the_take_better(rng: np.random.Generator) -> None:
    take, true = acting(weights(), noise=2e-4)
    shapes = distorted(true, rng)
    errors = [explained(shapes, take)]
    for _ in range(3):
        shapes = refitted(shapes, take, Refit())
        errors.append(explained(shapes, take))
    assert (np.diff(errors) < 0).all()


def test_refitting_turns_shapes_towards_the_true_ones(rng: np.random.Generator) -> None:
    take, true = acting(weights(), noise=2e-4)
    wrong = distorted(true, rng)
    astray = [1 - alike(shapes, true) for shapes in (wrong, refitted(wrong, take, Refit(freedom=1.0)))]
    assert (astray[1] < 0.3 * astray[0]).all()


def test_without_freedom_shapes_stay_as_they_are(rng: np.random.Generator) -> None:
    take, true = acting(weights())
    wrong = distorted(true, rng)
    assert refitted(wrong, take, Refit(freedom=1e-6)) == pytest.approx(wrong, abs=1e-3)


def test_an_actor_who_is_the_character_keeps_its_shapes() -> None:
    take, shapes = acting(weights(), noise=1e-4)
    found = personalise(shapes, take, Refit(), full_range=False)
    assert np.linalg.norm(found - shapes) < 0.02 * np.linalg.norm(shapes)


def test_the_actors_range_is_found_only_where_the_take_is_said_to_show_all_of_it() -> None:
    calibrated_shapes, kept = (fitted(weights() * SMALL, full_range=full) for full in (True, False))
    original = kept.alignment.original
    assert strength(calibrated_shapes.shapes, original) == pytest.approx(SMALL, rel=0.1)
    assert strength(kept.shapes, original) == pytest.approx(1, abs=0.15)


def test_a_labelled_frame_gives_its_shape_the_strength_it_is_labelled_with() -> None:
    values = weights() * 0.5
    frame = int(np.argmax(values[:150, 0]))
    plain = fitted(values, full_range=False)
    labelled = [
        fitted(values, Examples(np.array([frame]), SHAPES[:1], np.array([[label]])), full_range=False)
        for label in (1.0, 0.3)
    ]
    original = plain.alignment.original
    weak, strong = (strength(found.shapes, original)[0] for found in labelled)
    assert weak < strength(plain.shapes, original)[0] < strong
    assert strength(labelled[0].shapes, original)[1:] == pytest.approx(strength(plain.shapes, original)[1:], abs=0.1)


def test_a_labelled_shape_is_not_calibrated_by_the_take() -> None:
    take, shapes = acting(weights() * 0.5)
    labels = np.full((1, len(SHAPES)), np.nan)
    labels[0, 0] = 1.0
    known = Take(take.names, take.frames, take.confidence, take.off, take.frames[33:34], labels)
    found = calibrated(shapes, known, 0.99, but=known.known)
    assert np.array_equal(found[0], shapes[0])
    assert strength(found, shapes)[1:] == pytest.approx(0.5, abs=0.05)


def labelled(take: Take, frames: list[int], labels: np.ndarray) -> Take:
    """The take with some of its frames labelled."""
    return replace(take, labelled=take.frames[frames], labels=labels)


def test_the_strengths_that_labels_tell_are_those_that_scipy_finds(rng: np.random.Generator) -> None:
    take, true = acting(weights(), noise=2e-4)
    shapes, values = distorted(true, rng) * rng.uniform(0.7, 1.4, (len(true), 1, 1)), weights()[[20, 60, 110]]
    told = labelled(take, [20, 60, 110], values)

    def left(scale: np.ndarray) -> np.ndarray:
        error = told.labelled - np.tensordot(values * scale, shapes, axes=1)
        return np.concatenate([np.sqrt(INDEPENDENT) / NOISE_CM * error.ravel(), (scale - 1) / DOUBT])

    best = least_squares(left, np.ones(len(shapes))).x
    assert np.abs(best - 1).max() > 0.05
    assert strength(strengthened(shapes, told), shapes) == pytest.approx(best, abs=1e-6)


def test_labels_tell_the_strength_of_a_shape_that_the_take_never_shows_in_full() -> None:
    """The take alone would have the actor's limit at half of it."""
    values = weights() * 0.5
    take, shapes = acting(values)
    frame = int(np.argmax(values[:150, 0]))
    told = labelled(take, [frame], values[[frame]])
    alone, helped = (strength(personalise(shapes, t, Refit(), full_range=True), shapes)[0] for t in (take, told))
    assert alone == pytest.approx(0.5, abs=0.06)
    assert helped > 0.8


def test_labels_leave_shapes_that_they_do_not_name() -> None:
    take, shapes = acting(weights() * 0.5)
    values = np.full((1, len(SHAPES)), np.nan)
    values[0, 0] = 1.0
    found = strengthened(shapes, labelled(take, [33], values))
    assert np.array_equal(found[1:], shapes[1:])
    assert 0.4 < strength(found, shapes)[0] < 0.9


@pytest.mark.parametrize("values", [np.empty((0, len(SHAPES))), np.full((2, len(SHAPES)), np.nan), np.zeros((1, 6))])
def test_labels_that_show_nothing_change_no_strength(values: np.ndarray) -> None:
    take, shapes = acting(weights())
    assert np.array_equal(strengthened(shapes, labelled(take, [3, 4][: len(values)], values)), shapes)


def test_a_labelled_frame_may_miss_markers_but_not_most_of_them() -> None:
    """For longer than gaps are filled."""
    rig, points, values = face(), points_on(face()), weights() * 0.5
    take = capture(rig, values, points)
    frame = int(np.argmax(values[:150, 0]))
    examples = Examples(np.array([frame]), SHAPES, values[[frame]])

    def fit(missing: int, examples: Examples | None = examples) -> ShapeRetargeter:
        gappy = take.points.copy()
        gappy[: frame + 30, :missing] = np.nan
        known = {"neutral": at_rest(rig, points), "head_moves": False, "examples": examples}
        return RangeOfMotion().fit(rig, replace(take, points=gappy), pairs_of(points), **known)

    some, most, none = fit(3), fit(int(0.6 * len(take.names))), fit(3, None)
    original = none.alignment.original
    assert strength(some.shapes, original)[0] > 0.9 > 0.7 > strength(none.shapes, original)[0]
    assert most.shapes == pytest.approx(fit(int(0.6 * len(take.names)), None).shapes)
    assert [note.where for note in most.notes if note.code == "labels-unseen"] == [f"frame {frame}"]
    assert not any(note.code == "labels-unseen" for note in some.notes)


def test_a_marker_lost_for_a_while_does_not_cost_what_the_others_show() -> None:
    """For longer than gaps are filled, and where the take shows one of the shapes."""
    rig, points, values = face(), points_on(face()), weights() * SMALL
    take = capture(rig, values, points)
    gappy = take.points.copy()
    peak = int(np.argmax(values[:150, 1]))
    gappy[peak - 20 : peak + 20, 0] = np.nan
    known = {"neutral": at_rest(rig, points), "head_moves": False}

    def fit(seen: np.ndarray) -> ShapeRetargeter:
        return RangeOfMotion().fit(rig, replace(take, points=seen), pairs_of(points), **known)

    whole, found = fit(take.points), fit(gappy)
    assert np.linalg.norm(found.shapes - whole.shapes) < 0.02 * np.linalg.norm(whole.shapes)
    gone = int(np.isnan(gappy).any(axis=(1, 2)).sum())
    assert [note.message[:10] for note in found.notes if note.code == "frames-completed"] == [f"{gone} of 240 "]


def test_a_marker_that_is_never_seen_is_left_out_with_its_place_in_the_neutral() -> None:
    rig, points = face(), points_on(face())
    take = capture(rig, weights(), points)
    lost = take.points.copy()
    lost[:, 3] = np.nan
    known = {"neutral": at_rest(rig, points), "head_moves": False}
    found = RangeOfMotion().fit(rig, replace(take, points=lost), pairs_of(points), **known)
    assert found.markers == tuple(name for name in take.names if name != "m3")
    assert found.neutral == pytest.approx(np.delete(at_rest(rig, points).points, 3, axis=0))


def test_a_neutral_of_other_points_than_the_pairs_is_refused() -> None:
    rig, points = face(), points_on(face())
    rest = at_rest(rig, points)
    short = replace(rest, points=rest.points[1:])
    with pytest.raises(InputError, match="48 points, but there are 49 pairs"):
        RangeOfMotion().fit(rig, capture(rig, weights(), points), pairs_of(points), neutral=short)


def test_a_take_whose_every_frame_misses_most_markers_is_refused() -> None:
    rig, points = face(), points_on(face())
    take = capture(rig, weights(), points)
    seen = (np.arange(len(take.points))[:, None] + np.arange(len(points))) % 3 == 0
    blind = np.where(seen[..., None], take.points, np.nan)
    known = {"neutral": at_rest(rig, points), "head_moves": False}
    with pytest.raises(InputError, match="misses too many paired markers"):
        RangeOfMotion().fit(rig, replace(take, points=blind, fps=1.0), pairs_of(points), **known)


def test_shapes_kept_off_are_used_neither_for_explaining_nor_changed_by_it() -> None:
    take, shapes = acting(weights() * SMALL)
    without = Take(take.names, take.frames, take.confidence, ("smile_*",), take.labelled, take.labels)
    found = personalise(shapes, without, Refit(), full_range=True)
    assert found[1:3] == pytest.approx(shapes[1:3])
    assert not without.weights(shapes, take.frames, 1.0)[:, 1:3].any()


@pytest.mark.parametrize("scale", [0.01, 100.0])
def test_shapes_do_not_depend_on_the_unit_of_the_capture(scale: float) -> None:
    (one, shapes), (other, _) = acting(weights() * SMALL), acting(weights() * SMALL, scale=scale)
    first, second = (personalise(shapes, take, Refit(), full_range=True) for take in (one, other))
    assert second == pytest.approx(first, abs=1e-6)


def test_a_long_take_gives_the_shapes_that_its_thinned_frames_give() -> None:
    values = np.repeat(weights(), 2 * FRAMES // len(weights()) + 1, axis=0)
    (short, shapes), (long, _) = acting(weights()), acting(values)
    first, second = (personalise(shapes, take, Refit(), full_range=True) for take in (short, long))
    assert np.linalg.norm(second - first) < 0.05 * np.linalg.norm(first)
