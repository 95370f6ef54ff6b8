from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Blendshapes, Examples, InputError, Labels
from mien.library.characters import globe
from mien.retargeting.layers import (
    Layer,
    LayeredFace,
    Pick,
    composed,
    layer_clip,
    picked_layers,
    regions_of_groups,
    rig_face,
    shared,
    split_clip,
    split_rig,
    table_of,
)
from mien.retargeting.layers.model import natural_regions, told_apart
from mien.retargeting.layers.sources import picks_of
from mien.vocabularies.expressions import BLINKS, LAYER_EMOTIONS, VISEMES
from tests.retargeting.actors import face

TABLE = {
    "emotion": {"neutral": {}, "joy": {"smile_L": 1.0, "smile_R": 1.0}, "surprise": {"browUp": 1.0, "jawOpen": 0.5}},
    "speech": {"mm": {}, "aa": {"jawOpen": 1.0}, "wide": {"smile_L": 0.4, "smile_R": 0.4, "jawOpen": 0.2}},
    "blink": {"blink_open": {}, "blink_closed": {"blink_L": 1.0, "blink_R": 1.0}},
}


def shares(frames: int, face: LayeredFace, seed: int = 2) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(len(face.layers)), (frames, len(face.regions.names)))
    return weights, np.concatenate([rng.dirichlet(np.ones(k), frames) for k in face.sizes], axis=1)


def test_the_composition_is_the_written_sum() -> None:
    model = rig_face(face(), TABLE)
    weights, alpha = shares(3, model)
    written = np.repeat(model.rest[None], 3, axis=0)
    for j, layer in enumerate(model.layers):
        part = alpha[:, model.starts[j] : model.starts[j + 1]]
        for region in range(3):
            mask = (model.regions.of == region)[:, None]
            written += weights[:, region, j][:, None, None] * mask * np.tensordot(part, layer.offsets, axes=1)
    assert np.abs(model.compose(weights, alpha) - written).max() < 1e-15


def test_where_the_mean_is_does_not_matter() -> None:
    """Weights and coefficients sum to 1, so an offset may move from the extremes to the mean."""
    model = rig_face(face(), TABLE)
    shift = np.random.default_rng(0).normal(0, 0.01, model.rest.shape)
    moved = replace(
        model,
        rest=model.rest + shift,
        layers=tuple(Layer(layer.name, layer.extremes, layer.offsets - shift) for layer in model.layers),
    )
    weights, alpha = shares(5, model)
    assert np.abs(model.compose(weights, alpha) - moved.compose(weights, alpha)).max() < 1e-15


def test_regions_told_from_movement_are_mouth_eyes_and_the_rest() -> None:
    model = rig_face(face(), TABLE)
    x, y, _ = model.rest.T
    assert model.regions.names == ("face", "mouth", "eyes")
    eyes, mouth = model.regions.of == 2, model.regions.of == 1
    assert y[eyes].mean() == pytest.approx(0.03, abs=0.01)
    assert abs(x[eyes].mean()) < 0.005
    assert y[mouth].max() < 0
    assert (model.regions.of[(np.abs(x) < 0.01) & (y > 0.05)] == 0).all()


def test_a_rig_with_named_expressions_has_all_of_them() -> None:
    rig = globe()
    table = table_of(rig)
    assert tuple(table["emotion"]) == LAYER_EMOTIONS
    assert tuple(table["speech"]) == tuple(VISEMES)
    assert tuple(table["blink"]) == BLINKS
    model = rig_face(rig, masks=("body", "mouths", "eyes"))
    assert model.sizes == (29, 12, 3)
    assert model.regions.names == ("body", "mouths", "eyes")


def test_a_rig_without_named_expressions_offers_its_own_shapes() -> None:
    table = table_of(face())
    assert set(table) == {"emotion", "speech", "blink"}
    assert set(table["blink"]) == {"blink_open", "blink_L", "blink_R", "blink"}
    assert table["blink"]["blink"] == {"blink_L": 1.0, "blink_R": 1.0}
    assert set(table["speech"]) == {"viseme_sil", "jawOpen"}
    assert {"neutral", "smile", "smile_L", "browUp"} <= set(table["emotion"])


def test_curves_go_to_a_clip_and_back() -> None:
    model = rig_face(face(), TABLE)
    weights, alpha = shares(7, model)
    clip = layer_clip(model, weights, alpha, 30.0)
    assert "emotion.joy" in clip.names
    assert "weight.mouth.speech" in clip.names
    assert np.abs(composed(model, clip) - model.compose(weights, alpha)).max() < 1e-15


def test_edited_shares_are_scaled_to_their_sum_and_counted() -> None:
    model = rig_face(face(), TABLE)
    weights, alpha = shares(4, model)
    clip = layer_clip(model, weights, alpha, 30.0)
    values = clip.values.copy()
    values[1, clip.names.index("emotion.joy")] += 1
    out = split_clip(model, replace(clip, values=values))
    assert [note.code for note in out.notes] == ["shares-scaled"]
    assert "1 frames" in out.notes[0].message
    values[2, clip.names.index("emotion.joy")] = -0.5
    with pytest.raises(InputError, match="frame 2"):
        composed(model, replace(clip, values=values))
    with pytest.raises(InputError, match="lack 1"):
        composed(model, replace(clip, names=clip.names[1:], values=clip.values[:, 1:]))


def test_split_shapes_make_the_composition_exactly() -> None:
    rig = face()
    model = rig_face(rig, TABLE)
    clip = layer_clip(model, *shares(6, model), 30.0)
    split = split_rig(rig, model)
    played = split_clip(model, clip)
    assert set(played.names) == set(split.blendshapes.names)
    assert np.abs(split.pose(played.channels(split.blendshapes.names)) - composed(model, clip)).max() < 1e-15
    again = rig_face(split)
    assert again.regions.names == tuple(dict.fromkeys(n.rpartition("@")[2] for n in split.blendshapes.names))
    joy = again.layers[again.layer("emotion")]
    assert np.abs(joy.offsets[joy.extremes.index("joy")] - model.layers[0].offsets[1]).max() < 1e-15


def test_names_that_one_side_has_are_dropped_from_both_and_named() -> None:
    actor = rig_face(face(), TABLE)
    theirs = {layer: dict(extremes) for layer, extremes in TABLE.items()}
    del theirs["emotion"]["joy"]
    del theirs["blink"]["blink_open"]
    theirs["emotion"]["rage"] = {"browUp": 0.2}
    theirs["blink"]["blink_half"] = {"blink_L": 0.5, "blink_R": 0.5}
    theirs["dance"] = {"a": {"browUp": 0.3}, "b": {}}
    mine, other, notes = shared(actor, replace(rig_face(face(), theirs), name="hero"))
    assert mine.extremes == other.extremes
    assert mine.layers[0].extremes == ("neutral", "surprise")
    assert mine.layers[2].extremes == ("blink_open", "blink_closed")
    said = " ".join(note.message for note in notes)
    for word in ("joy", "rage", "blink_half", "dance"):
        assert word in said


def test_a_face_at_rest_is_kept_if_one_side_names_it() -> None:
    actor = rig_face(face(), TABLE)
    theirs = {**TABLE, "blink": {"blink_closed": TABLE["blink"]["blink_closed"], "wink": {"blink_L": 1.0}}}
    mine, other, _ = shared(actor, rig_face(face(), theirs))
    blink = other.layers[other.layer("blink")]
    assert blink.extremes == ("blink_open", "blink_closed")
    assert not blink.offsets[0].any()
    assert mine.extremes == other.extremes


def test_picked_frames_are_the_extremes() -> None:
    take = np.random.default_rng(0).normal(size=(9, 4, 3))
    picks = picks_of(
        Examples(np.array([2, 5, 7]), ("emotion.neutral", "emotion.joy"), np.array([[1, 0], [np.nan, 1], [0, np.nan]]))
    )
    assert picks == (Pick("emotion", "neutral", 2), Pick("emotion", "joy", 5))
    (layer,) = picked_layers(picks, take, "abcd")
    assert np.array_equal(layer.offsets, take[[2, 5]])


def test_bad_faces_are_refused_in_words() -> None:
    rng = np.random.default_rng(1)
    offsets = rng.normal(size=(3, 6, 3))
    layer = Layer("emotion", ("a", "b", "c"), offsets)
    regions = Labels(("face",), np.zeros(6, np.int64))
    rest = rng.normal(size=(6, 3))
    take = rng.normal(size=(4, 6, 3))
    take[1, 2] = np.nan
    names = [f"p{i}" for i in range(6)]
    label = Examples(np.array([1]), ("joy",), np.ones((1, 1)))
    twice = Examples(np.array([1, 2]), ("emotion.joy",), np.ones((2, 1)))
    good = LayeredFace(rest, (layer,), regions)
    bare = replace(face(), blendshapes=Blendshapes((), np.zeros((0, 576, 3))))
    for call, why in (
        (lambda: Layer("emotion", ("a",), offsets[:1]), "at least two"),
        (lambda: Layer("emotion", (), offsets[:0]), "at least two"),
        (lambda: told_apart(Layer("emotion", ("a", "b", "c"), offsets[[0, 1, 0]])), "'a' and 'c'"),
        (lambda: Layer("emotion", ("a", "b", "c"), np.full_like(offsets, np.nan)), "NaN"),
        (lambda: LayeredFace(rest, (), regions), "no layers"),
        (lambda: LayeredFace(rest[:5], (layer,), regions), "5 points"),
        (lambda: regions_of_groups({"a": np.array([0, 1]), "b": np.array([1, 2])}, 3), "more than one mask.*a, b"),
        (lambda: regions_of_groups({"a": np.array([0, 1])}, 3), "in no mask"),
        (lambda: regions_of_groups({"a": np.array([0, 9])}, 3), "index 9"),
        (lambda: shared(good, replace(good, regions=Labels(("x", "y"), regions.of))), "as many"),
        (lambda: shared(good, replace(good, layers=(replace(layer, name="dance"),))), "name them alike"),
        (lambda: rig_face(face(), {"emotion": {"a": {}, "b": {"grin": 1.0}}}), "grin"),
        (lambda: rig_face(face(), TABLE, ("snout",)), "snout"),
        (lambda: rig_face(bare), "nothing in the names"),
        (lambda: picked_layers([], take, names), "no frames"),
        (lambda: picked_layers([Pick("emotion", "joy", 4)], take, names), "0 … 3"),
        (lambda: picked_layers([Pick("emotion", "joy", 1)], take, names), "misses p2"),
        (lambda: picked_layers([Pick("e", "joy", 0), Pick("e", "joy", 2)], take, names), "two frames"),
        (lambda: picked_layers([Pick("e", "a", 0), Pick("e", "b", 0)], take[:1], names), "'a' and 'b'"),
        (lambda: picks_of(label), "layer.extreme"),
        (lambda: picks_of(twice), "exactly one"),
    ):
        with pytest.raises(InputError, match=why):
            call()


def test_without_blinks_there_are_no_eyes() -> None:
    layers = rig_face(face(), {"emotion": TABLE["emotion"], "speech": TABLE["speech"]}).layers
    assert not (natural_regions(layers).of == 2).any()
