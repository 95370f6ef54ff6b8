"""What every method that learns from labels promises, whatever is inside: as `test_contract`, with labels."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mien.core import Examples, InputError, Markers
from mien.retargeting import METHODS, make_method, parameters
from mien.retargeting.by_example import ExampleRetargeter
from mien.retargeting.latent.model import PUBLISHED
from mien.retargeting.saved import packed, unpacked
from tests.retargeting.actors import SHAPES, capture, clip_of, face, points_on, weights

NAMES = [name for name, method in METHODS.items() if getattr(method, "by_example", False)]
QUICK = {"latent": {"count": 30}, "sgplvm": {"count": 30, "iterations": 40, "floor": 1e-3}}
PAPER = {"preset": "paper", "count": 20, "iterations": 40}
WAYS = [(name, QUICK.get(name, {})) for name in NAMES] + [("latent", PAPER)]
LABELS = Examples(np.arange(4, 240, 15), SHAPES, weights()[4::15])


def take() -> Markers:
    return capture(face(), weights(), points_on(face(), 25), noise=1e-4, head=True)


@cache
def fitted(way: int) -> ExampleRetargeter:
    name, settings = WAYS[way]
    return make_method(name, settings).fit(face(), take(), examples=LABELS)  # type: ignore[return-value]


def spoiled() -> Markers:
    points = take().points[60:110].copy()
    points[20:23, 4] = np.nan
    points[30:32] = np.nan
    return replace(take(), points=points)


def test_there_is_a_way_for_every_method() -> None:
    assert {name for name, _ in WAYS} == set(NAMES) >= {"latent", "sgplvm", "gpr", "svr", "ridge", "cross-mapping"}


@pytest.mark.parametrize("way", range(len(WAYS)))
def test_fitting_and_retargeting_change_neither_inputs_nor_mind(way: int) -> None:
    performance, labels = take(), replace(LABELS)
    points, values = performance.points.copy(), labels.values.copy()
    name, settings = WAYS[way]
    again = make_method(name, settings).fit(face(), performance, examples=labels)
    clip, _ = again.retarget(performance)
    assert np.array_equal(clip.values, fitted(way).retarget(performance)[0].values)
    assert np.array_equal(points, performance.points)
    assert np.array_equal(values, labels.values)


@pytest.mark.parametrize("way", range(len(WAYS)))
def test_frame_by_frame_gives_what_the_whole_take_gives(way: int) -> None:
    whole, report = fitted(way).retarget(spoiled())
    state, folded = fitted(way).start(), []
    for frame in spoiled().points:
        state, values = fitted(way).step(state, frame)
        folded.append(values)
    assert np.abs(np.array(folded) - whole.values).max() < 1e-9
    assert np.array_equal(whole.values[31], whole.values[29])
    assert "frames-held" in {note.code for note in report.notes}


@pytest.mark.parametrize("way", range(len(WAYS)))
def test_what_is_saved_is_what_is_loaded(way: int) -> None:
    header, arrays = packed(fitted(way))
    header = json.loads(json.dumps(header))
    loaded = unpacked(header, {name: np.ascontiguousarray(array) for name, array in arrays.items()})
    assert np.abs(loaded.retarget(spoiled())[0].values - fitted(way).retarget(spoiled())[0].values).max() < 1e-12
    for name in (name for name, array in arrays.items() if array.size):
        for broken in (arrays[name].ravel()[:-1], arrays[name].astype(object)):
            with pytest.raises(InputError):
                unpacked(header, {**arrays, name: broken})


@pytest.mark.parametrize("way", range(len(WAYS)))
def test_units_and_place_of_the_capture_change_nothing(way: int) -> None:
    name, settings = WAYS[way]
    moved = replace(take(), points=take().points * 1000 + [5, 0, 1])
    clip, _ = make_method(name, settings).fit(face(), moved, examples=LABELS).retarget(moved)
    assert np.abs(clip.values - fitted(way).retarget(take())[0].values).max() < 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_bad_input_is_refused_in_words(name: str) -> None:
    method = make_method(name)
    gone = replace(take(), points=np.full_like(take().points, np.nan))
    still = clip_of(np.ones((50, 6)))
    for training, examples, why in (
        (take(), None, "mien label"),
        (gone, LABELS, "only 0 of 25"),
        (still, replace(LABELS, frames=np.arange(16)), "ever changes"),
        (take(), replace(LABELS, frames=LABELS.frames + 100), "outside of the training take"),
    ):
        with pytest.raises(InputError, match=why):
            method.fit(face(), training, examples=examples)


def test_values_stay_within_bounds() -> None:
    clip, _ = make_method("ridge", {"bounds": "0:0.4"}).fit(face(), take(), examples=LABELS).retarget(take())
    assert clip.values.min() == 0
    assert clip.values.max() == 0.4


def test_the_published_preset_is_the_published_model() -> None:
    found = parameters(make_method("latent", {"preset": "paper"}))
    assert {key: found[key] for key in PUBLISHED} == dict(PUBLISHED)
    changed = parameters(make_method("latent", {"preset": "paper", "dimensions": "6"}))
    assert changed["dimensions"] == 6
    assert "rounds" in parameters(make_method("latent"))
