"""Methods that learn from labelled frames, from takes to clips and through files."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mien.core import Clip, Examples, InputError
from mien.retargeting.few_labels import Latent
from mien.retargeting.labelled import capture_noise, unlabelled
from mien.retargeting.latent.model import LatentModel
from mien.retargeting.regions import ApartModel
from mien.retargeting.regression import RidgeModel
from mien.retargeting.regression.methods import Ridge
from mien.retargeting.samples import samples
from mien.retargeting.saved import packed, unpacked
from tests.retargeting.actors import SHAPES, capture, clip_of, face, pairs_of, points_on, weights

QUICK = LatentModel(floor=1e-3, beginning="principal", iterations=60)
METHODS = [Latent(), Latent(model=QUICK), Latent(regions=("brow", "eye")), Ridge()]


def labels(count: int = 24) -> Examples:
    frames = np.linspace(5, 230, count).astype(int)
    return Examples(frames, SHAPES, weights()[frames])


@pytest.mark.parametrize("method", METHODS, ids=("transport", "paper", "regions", "ridge"))
def test_a_take_is_learned_from_its_labels_kept_in_a_model_and_folded(method) -> None:
    rig = face()
    points = points_on(rig)
    take = capture(rig, weights(), points, noise=1e-4, head=True)
    fitted = method.fit(rig, take, pairs_of(points), examples=labels())
    seen = take.points[60:120].copy()
    seen[20:23, 4] = np.nan
    seen[30] = np.nan
    part = replace(take, points=seen)
    clip, report = fitted.retarget(part)
    assert clip.names == SHAPES
    assert clip.head is not None
    assert np.sqrt(((clip.values - weights()[60:120]) ** 2).mean()) < 0.2
    assert len(report.figures["uncertainty"]) == 60
    assert "frames-held" in {note.code for note in report.notes}
    state, folded = fitted.start(), []
    for frame in seen:
        state, values = fitted.step(state, frame)
        folded.append(values)
    assert np.abs(np.array(folded) - clip.values).max() < 1e-9
    header, arrays = packed(fitted)
    again, _ = unpacked(json.loads(json.dumps(header)), arrays).retarget(part)
    assert np.array_equal(again.values, clip.values)


def test_weights_are_learned_from_too_and_animations_help() -> None:
    rig, clip = face(), clip_of(weights())
    names = ("open", "wide")
    values = np.column_stack([weights()[:, 0] ** 2, weights()[:, 1] + weights()[:, 2]])
    frames = np.arange(3, 240, 8)
    method = Latent(model=QUICK, animations=(Clip(names, values, 60.0),))
    fitted = method.fit(rig, clip, examples=Examples(frames, names, values[frames]))
    assert fitted.figures["unlabelled"] == [100, 100]
    found, _ = fitted.retarget(clip)
    assert np.sqrt(((found.values - values) ** 2).mean()) < 0.1
    with pytest.raises(InputError, match="markers"):
        fitted.retarget(capture(rig, weights(), points_on(rig)))


def test_bad_labels_are_refused_in_words() -> None:
    rig, clip = face(), clip_of(weights())
    good = labels()
    twice = Examples(np.array([5, 9, 5]), SHAPES, np.eye(6)[:3])
    for examples, why in (
        (None, "labelled frames"),
        (Examples(np.zeros(0, dtype=int), SHAPES, np.zeros((0, 6))), "there are none"),
        (replace(good, frames=good.frames + 100), "outside of the training take of 240"),
        (twice, "frame 5 is labelled 2 times.*'jawOpen'"),
    ):
        with pytest.raises(InputError, match=why):
            Ridge().fit(rig, clip, examples=examples)
    repeated = Examples(np.tile(good.frames, 12), SHAPES, np.tile(good.values, (12, 1)))
    assert Ridge().fit(rig, clip, examples=repeated).figures["labels"] == 24


def test_a_garbled_model_is_refused_in_words() -> None:
    fitted = Latent(model=QUICK).fit(face(), clip_of(weights()), examples=labels())
    header, arrays = packed(fitted)
    for name in arrays:
        for broken in (arrays[name].ravel()[:-1], arrays[name].astype(object)):
            with pytest.raises(InputError):
                unpacked(header, {**arrays, name: broken})
    with pytest.raises(InputError):
        unpacked({**header, "fitted": {"record": "Popen", "fields": {}}}, arrays)


def test_regions_learned_apart_do_not_touch_each_other() -> None:
    rng = np.random.default_rng(0)
    x = rng.normal(size=(12, 6))
    y = x[:, [0, 5]] * 2
    parts = ((np.arange(3), np.arange(3, 6)), (np.array([0]), np.array([1])))
    learnt = ApartModel(RidgeModel(), *parts).learn(samples(x, y))
    moved = x.copy()
    moved[:, 3:] += 1
    assert np.array_equal(learnt.map(moved)[:, 0], learnt.map(x)[:, 0])
    assert np.abs(learnt.map(x) - y).max() < 1e-4
    with pytest.raises(InputError, match="divide"):
        ApartModel(RidgeModel(), parts[0], (np.array([0]), np.array([0]))).learn(samples(x, y))


def test_regions_are_told_by_names_and_each_completes_its_own_pose() -> None:
    rig = face()
    points = points_on(rig)
    fitted = Latent(regions=("brow",)).fit(rig, capture(rig, weights(), points), pairs_of(points), examples=labels())
    upper, lower = fitted.figures["regions"]
    assert upper == [name for name in SHAPES if "brow" in name.lower()]
    assert sorted([*upper, *lower]) == sorted(SHAPES)
    one, two = fitted.complete({lower[0]: 0.9}), fitted.complete({lower[0]: 0.1})
    at = [SHAPES.index(name) for name in upper]
    np.testing.assert_array_equal(one[at], two[at])
    assert one[SHAPES.index(lower[0])] == 0.9


def test_channels_that_never_have_a_value_are_left_out_and_named() -> None:
    values = weights()
    values[:, 2] = np.nan
    fitted = Ridge().fit(face(), clip_of(values), examples=labels())
    assert [note.where for note in fitted.notes if note.code == "channels-never-seen"] == [SHAPES[2]]
    assert SHAPES[2] not in fitted.reading.names


@pytest.mark.parametrize("words", [("nothing",), ("",)])
def test_regions_that_divide_nothing_are_refused(words: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match="no two regions"):
        Ridge(regions=words).fit(face(), clip_of(weights()), examples=labels())


def test_unlabelled_frames_are_spread_whole_and_not_labelled() -> None:
    take = np.random.default_rng(0).normal(size=(200, 4))
    take[50:60, 1] = np.nan
    found = unlabelled(take, np.array([10, 20]), 30)
    assert len(np.unique(found)) == 30
    assert not np.isin(found, [10, 20, *range(50, 60)]).any()
    assert np.diff(found).max() < 20


def test_the_noise_of_a_capture_is_measured() -> None:
    t = np.linspace(0, 6, 600)[:, None]
    smooth = np.sin(t + np.arange(8))
    noise, change = capture_noise(smooth + np.random.default_rng(0).normal(0, 0.02, smooth.shape))
    spread = smooth.std(axis=0).max()
    assert noise == pytest.approx(0.02 / spread, rel=0.1)
    assert change == pytest.approx(np.sqrt((np.diff(smooth, axis=0) ** 2).mean()) / spread, rel=0.3)
