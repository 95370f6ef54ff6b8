from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.capture import Neutral
from mien.core import Clip, Examples, InputError, Markers
from mien.geometry.align import head_motion
from mien.library.characters import globe
from mien.retargeting import make_method
from mien.retargeting.layers import LayeredFace, composed, layer_clip, rig_face, split_rig
from mien.retargeting.layers.actor import make_actor
from mien.retargeting.layers.comparison import compare_layers
from mien.retargeting.layers.decompose import BEGINNING, Decomposer, Lips, residual_mm
from mien.retargeting.layers.dynamics import Dynamics
from mien.retargeting.layers.head import head_of_curves, with_head_curves
from mien.retargeting.layers.planar import planar_stabiliser
from mien.retargeting.layers.still import hold_still
from mien.solve.layered import Bias, solve_layered
from tests.retargeting.actors import at_rest, capture, face, points_on, weights
from tests.retargeting.test_layers_model import TABLE, shares

PICKED = (
    "emotion.neutral",
    "emotion.joy",
    "speech.viseme_PP",
    "speech.viseme_aa",
    "blink.blink_open",
    "blink.blink_closed",
)
POSES = np.array(
    [[0] * 6, [0, 1, 1, 0, 0, 0.5], [0.1, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0.02], [0, 0, 0, 1, 1, 0]]
)


def acted(frames: int = 60) -> tuple[LayeredFace, np.ndarray]:
    """The small face in layers at 49 points [cm], and a performance that its layers make, with noise."""
    rig = face()
    points = points_on(rig)
    model = rig_face(rig, TABLE)
    at = points.corners[:, 0]
    layers = tuple(replace(layer, offsets=100 * layer.offsets[:, at]) for layer in model.layers)
    small = LayeredFace(100 * model.rest[at], layers, replace(model.regions, of=model.regions.of[at]))
    w, alpha = shares(frames, small)
    smooth = np.exp(-0.5 * (np.arange(-9, 10) / 3.0) ** 2)
    w, alpha = (np.apply_along_axis(np.convolve, 0, v, smooth / smooth.sum(), "same") for v in (w, alpha))
    w /= w.sum(axis=2, keepdims=True)
    for a, b in zip(small.starts[:-1], small.starts[1:], strict=True):
        alpha[:, a:b] /= alpha[:, a:b].sum(axis=1, keepdims=True)
    moved = small.compose(w, alpha) - small.rest
    return small, moved + np.random.default_rng(8).normal(0, 0.01, moved.shape)


def decomposer(model: LayeredFace, smooth: float = 1e-3) -> Decomposer:
    return Decomposer(model, np.ones(len(model.rest)), smooth)


def test_missing_points_are_left_out_exactly() -> None:
    model, moved = acted(20)
    gone = np.zeros(len(model.rest), bool)
    gone[::5] = True
    holes = moved.copy()
    holes[:, gone] = np.nan
    rest = LayeredFace(
        model.rest[~gone],
        tuple(replace(layer, offsets=layer.offsets[:, ~gone]) for layer in model.layers),
        replace(model.regions, of=model.regions.of[~gone]),
    )
    whole, parted = decomposer(model), decomposer(rest)
    share = len(rest.rest) / len(model.rest)
    gram = whole.problem(~gone, 1e-3).gram
    assert np.abs(gram - share * parted.problem(np.ones(len(rest.rest), bool), 1e-3).gram).max() < 1e-14
    data, energy = whole.project(holes)
    peer = parted.project(moved[:, ~gone])
    assert np.abs(data - share * peer[0]).max() < 1e-14
    assert np.abs(energy - share * peer[1]).max() < 1e-14


def test_a_frame_that_sees_nothing_holds_the_one_before() -> None:
    model, moved = acted(20)
    moved[[0, 9, 10]] = np.nan
    found = decomposer(model).decompose(moved)
    assert np.array_equal(found.coefficients[8], found.coefficients[10])
    assert np.array_equal(found.weights[8], found.weights[10])
    assert np.abs(model.compose(found.weights[:1], found.coefficients[:1]) - model.rest).max() < 1e-6


def test_a_take_and_its_frames_give_the_same_to_the_bit() -> None:
    model, moved = acted(25)
    moved[7, 3:9] = np.nan
    take = decomposer(model).decompose(moved)
    memory, one = BEGINNING, decomposer(model)
    for f in range(25):
        found, memory = one.follow(moved[f : f + 1], memory=memory)
        assert np.array_equal(found.coefficients[0], take.coefficients[f])
        assert np.array_equal(found.weights[0], take.weights[f])


def test_doubling_every_point_changes_nothing() -> None:
    model, moved = acted(25)
    twice = LayeredFace(
        np.repeat(model.rest, 2, axis=0),
        tuple(replace(layer, offsets=np.repeat(layer.offsets, 2, axis=1)) for layer in model.layers),
        replace(model.regions, of=np.repeat(model.regions.of, 2)),
    )
    one, other = decomposer(model).decompose(moved), decomposer(twice).decompose(np.repeat(moved, 2, axis=1))
    assert np.abs(one.objective - other.objective).max() < 1e-12
    assert np.abs(one.coefficients - other.coefficients).max() < 1e-7


def test_the_order_of_extremes_and_of_layers_within_the_face_changes_nothing() -> None:
    """From the first frame's many starts on: a tie between starts must not be decided by order."""
    model, moved = acted(25)
    plain = decomposer(model).decompose(moved)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        orders = [rng.permutation(size) for size in model.sizes]
        layers = tuple(
            replace(layer, extremes=tuple(layer.extremes[k] for k in order), offsets=layer.offsets[order])
            for layer, order in zip(model.layers, orders, strict=True)
        )
        found = decomposer(replace(model, layers=layers)).decompose(moved)
        where = np.concatenate([start + order for start, order in zip(model.starts, orders, strict=False)])
        assert np.abs(found.weights - plain.weights).max() < 1e-6
        assert np.abs(found.coefficients - plain.coefficients[:, where]).max() < 1e-6
        assert np.abs(found.objective - plain.objective).max() < 1e-9 * plain.objective.max()


def test_the_layered_model_reconstructs_better_than_any_layer_alone() -> None:
    model, moved = acted()
    figures = compare_layers(decomposer(model, 1e-5), moved).figures()
    assert figures["frames_layered_below_all"] > 0.95
    assert all(figures[layer.name]["mean_ratio"] < 1 for layer in model.layers)
    assert figures["layered_mm"] < 0.3


def picked(rig_scale: float = 1.0) -> tuple[Markers, Examples, Neutral]:
    rig = face()
    points = points_on(rig)
    take = capture(rig, POSES, points, scale=rig_scale)
    examples = Examples(np.arange(6), PICKED, np.where(np.eye(6) > 0, 1.0, np.nan))
    return take, examples, at_rest(rig, points, rig_scale)


def test_content_goes_to_a_face_with_no_point_in_common() -> None:
    """The actor's smile and closed eyes become the globe's, which has four mouths and five eyes."""
    take, examples, neutral = picked()
    hero = globe()
    method = make_method("layers", {"masks": ("body", "mouths", "eyes"), "closure": 0, "smooth": 1e-6})
    fitted = method.fit(hero, take, neutral=neutral, examples=examples, head_moves=False)
    clip, report = fitted.retarget(take)
    for frame, name in ((1, "joy"), (5, "blink_closed"), (3, "viseme_aa")):
        assert hero.blendshapes.names[int(np.argmax(clip.values[frame]))] == name
    curves = fitted.layers(take)
    shape = composed(fitted.character, curves)[1] - hero.neutral.vertices
    joy = hero.blendshapes.deltas[hero.blendshapes.index("joy")]
    assert (shape * joy).sum() / (joy * joy).sum() > 0.9
    assert {note.code for note in report.notes} >= {"extremes-unshared"}
    assert report.figures["outside"]["mean"] < 0.2


def test_a_split_character_is_driven_exactly() -> None:
    take, examples, neutral = picked()
    whole = rig_face(globe(), masks=("body", "mouths", "eyes"))
    hero = split_rig(globe(), whole)
    fitted = make_method("layers").fit(hero, take, neutral=neutral, examples=examples, head_moves=False)
    clip, report = fitted.retarget(take)
    assert np.abs(hero.pose(clip.values) - composed(fitted.character, fitted.layers(take))).max() < 1e-6
    assert report.figures["projection_loss_mm"]["max"] < 1e-2


def test_units_of_the_take_change_nothing() -> None:
    reference = None
    for scale in (1.0, 100.0):
        take, examples, neutral = picked(scale)
        fitted = make_method("layers").fit(globe(), take, neutral=neutral, examples=examples, head_moves=False)
        values = fitted.layers(take).values
        assert reference is None or np.abs(values - reference).max() < 1e-7
        reference = values


def test_closed_lips_draw_the_mouth_to_the_closed_viseme() -> None:
    take, examples, neutral = picked()
    lips = {"lips": "m21,m22", "closure": 1.0, "closing": 0.0, "sigma": 10.0}
    rng = np.random.default_rng(4)
    acted = replace(take, points=take.points[[0, 1, 1, 1]] + rng.normal(0, 1e-5, (4, 49, 3)))
    free = make_method("layers", {"closure": 0}).fit(
        globe(), take, neutral=neutral, examples=examples, head_moves=False
    )
    drawn = make_method("layers", lips).fit(globe(), take, neutral=neutral, examples=examples, head_moves=False)
    name = f"weight.{drawn.character.regions.names[drawn.decomposer.lips.bias.region]}.speech"
    loose, tight = free.layers(acted), drawn.layers(acted)
    assert tight.channels([name])[-1] > loose.channels([name])[-1] + 0.5
    assert tight.channels(["speech.viseme_PP"])[-1] > 0.9


def test_lips_count_as_closed_when_they_close_and_not_while_they_rest() -> None:
    gap = np.concatenate([np.zeros(10), np.ones(10), np.zeros(40)])
    points = np.zeros((len(gap), 2, 3))
    points[:, 0, 1] = gap
    points[13] = np.nan
    lips = Lips(0, 1, 0.0, 0.02, 0.5, 0.05, Bias(0, 0, np.ones(2)))
    apart = lips.gap(points, np.zeros((2, 3)))
    gamma, opened = lips.gamma(apart, 30.0)
    assert gamma[:10].max() == 0
    assert gamma[10:20].max() < 1e-9
    assert gamma[20] > 0.49
    assert gamma[40:].max() < 1e-6
    assert gamma[13] == 0
    parts, lately = [], 0.0
    for f in range(len(gap)):
        part, lately = lips.gamma(apart[f : f + 1], 30.0, lately)
        parts.append(part[0])
    assert np.array_equal(parts, gamma)
    assert lately == opened
    published, _ = replace(lips, closing=0.0).gamma(apart, 30.0)
    assert np.all(published[:10] == 0.5)


def test_bad_input_is_refused_in_words() -> None:
    take, examples, neutral = picked()
    rig = face()
    clip = Clip(rig.blendshapes.names, POSES, 60.0)
    still = replace(take, points=np.repeat(take.points[:1], 6, axis=0))
    lost = replace(take, points=np.full_like(take.points, np.nan))
    late = Examples(np.arange(1, 7), PICKED, examples.values)
    for settings, training, labels, why in (
        ({}, clip, examples, "--actor"),
        ({}, still, examples, "no movement"),
        ({}, lost, examples, "no frame"),
        ({}, take, late, "0 … 5"),
        ({"masks": "snout"}, take, examples, "snout"),
        ({"lips": "m1,x"}, take, examples, "lips m1 and x"),
    ):
        with pytest.raises(InputError, match=why):
            make_method("layers", settings).fit(globe(), training, neutral=neutral, examples=labels)
    with pytest.raises(InputError, match="two markers"):
        make_method("layers", {"lips": "m1"})
    one = replace(take, points=take.points[:1])
    with pytest.raises(InputError, match="no movement"):
        make_method("layers").fit(
            globe(), one, neutral=neutral, examples=Examples(np.zeros(1), ("emotion.a",), np.ones((1, 1)))
        )


def test_the_head_is_held_as_the_reference_holds_it() -> None:
    rig = face()
    take = capture(rig, weights(), points_on(rig), head=True)
    points, rest = take.points[:40].copy(), take.points[0]
    points[5, 3:9] = np.nan
    points[7, 2:] = np.nan
    stability = np.linspace(0, 1, 49)
    still, motion = np.empty_like(points), np.empty((40, 4, 4))
    hold_still(rest, stability, 0.002, points, np.eye(4), still, motion)
    wanted, _ = head_motion(rest, points, stability, softness=0.002)
    assert np.abs(motion - wanted).max() < 1e-9
    assert np.isnan(still).any(axis=2).sum() == np.isnan(points).any(axis=2).sum()


def test_planar_points_are_held_still_apart_from_the_markers() -> None:
    rng = np.random.default_rng(6)
    rest = rng.normal(0, 40, (22, 2))
    frames = np.repeat(rest[None], 30, axis=0)
    frames[:, :3] += rng.normal(0, 6, (30, 3, 2))
    angle, scale, shift = rng.normal(0, 0.2, 30), rng.uniform(0.7, 1.4, 30), rng.normal(0, 100, (30, 1, 2))
    turn = np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], axis=1).reshape(-1, 2, 2)
    seen = scale[:, None, None] * frames @ np.swapaxes(turn, 1, 2) + shift
    seen[4, 10:] = np.nan
    still, _ = planar_stabiliser(rest)(seen)
    ok = ~np.isnan(seen)
    assert np.abs(still - frames)[ok].max() < 0.2
    assert np.isnan(still[~ok]).all()


def test_markers_and_image_points_share_one_face() -> None:
    rig = face()
    points = points_on(rig)
    take = capture(rig, POSES, points, head=True)
    flat = capture(rig, POSES, points).points[:, 14:28] @ Rotation.from_euler("x", 40, degrees=True).as_matrix()
    flat = 4000 * flat
    flat[..., 2] = 7.0
    names = (*take.names, *(f"pixel{i}" for i in range(14)))
    both = Markers(names, np.concatenate([take.points, flat], axis=1), 60.0)
    actor = make_actor(names, both.points[0] * [1, 1, 1], both.points, planar=names[49:])
    moved, motion = actor.displacements(both.points)
    assert motion is not None
    assert moved.shape == (6, 63, 3)
    assert not moved[:, 49:, 2].any()
    assert np.abs(moved[0]).max() < 1e-6
    examples = Examples(np.arange(6), PICKED, np.where(np.eye(6) > 0, 1.0, np.nan))
    fitted = make_method("layers", {"planar": names[49:]}).fit(
        globe(), both, neutral=Neutral(both.points[0], None, 0.0), examples=examples
    )
    clip, _ = fitted.retarget(both)
    assert globe().blendshapes.names[int(np.argmax(clip.values[5]))] == "blink_closed"


def test_dynamics_keep_shares_and_do_what_they_say() -> None:
    model = rig_face(face(), TABLE)
    head = np.tile(np.eye(4), (50, 1, 1))
    head[:, :3, :3] = Rotation.from_euler("y", np.linspace(0, 0.5, 50)[:, None]).as_matrix()
    clip = layer_clip(model, *shares(50, model), 30.0, head)
    same = Dynamics().apply(model, clip)
    assert np.array_equal(same.values, clip.values)
    half = Dynamics({"emotion": 0.5}).apply(model, clip)
    assert np.abs(half.channels(["emotion.joy"]) - 0.5 * clip.channels(["emotion.joy"])).max() < 1e-15
    slow = Dynamics(
        {"emotion": 3.0},
        lag=0.2,
        speed=0.5,
        head_gain=0.5,
        head_map=Rotation.from_euler("z", 90, degrees=True).as_matrix(),
    )
    out = slow.apply(model, clip)
    assert len(out) == 99
    assert np.abs(out.values[:, :3].sum(axis=1) - 1).max() < 1e-12
    assert out.values.min() >= -1e-15
    assert np.abs(np.diff(out.values, axis=0)).max() < np.abs(np.diff(clip.values, axis=0)).max()
    turned = Rotation.from_matrix(out.head[-1, :3, :3]).as_rotvec()
    assert turned == pytest.approx([-0.25, 0, 0], abs=1e-12)
    for wrong, why in (({"speed": 0}, "speed"), ({"lag": -1}, "lag"), ({"head_map": 2 * np.eye(3)}, "rotation")):
        with pytest.raises(InputError, match=why):
            Dynamics(**wrong)
    with pytest.raises(InputError, match="unknown layer"):
        Dynamics({"dance": 1.0}).apply(model, clip)


def test_a_layer_without_rest_is_shown_more_or_less_about_its_mean() -> None:
    model = rig_face(face(), TABLE)
    spoken = model.layers[model.layer("speech")]
    bare = replace(spoken, offsets=spoken.offsets + 0.01)
    model = replace(model, layers=tuple(bare if layer is spoken else layer for layer in model.layers))
    clip = layer_clip(model, *shares(50, model), 30.0)
    names = [name for name in clip.names if name.startswith("speech.")]
    own = clip.channels(names)
    (note,) = Dynamics({"speech": 0.5}).notes(model)
    assert note.code == "gain-about-mean"
    still = Dynamics({"speech": 0.0}).apply(model, clip).channels(names)
    assert np.abs(still - own.mean(axis=0)).max() < 1e-12
    half = Dynamics({"speech": 0.5}).apply(model, clip).channels(names)
    assert np.abs(half - 0.5 * (own + own.mean(axis=0))).max() < 1e-12
    more = Dynamics({"speech": 3.0}).apply(model, clip).channels(names)
    assert more.min() >= 0
    assert np.abs(more.sum(axis=1) - 1).max() < 1e-12
    assert more.std(axis=0).min() > own.std(axis=0).min()


def test_head_motion_goes_through_curves_and_to_faces_of_another_size() -> None:
    model = rig_face(face(), TABLE)
    head = np.tile(np.eye(4), (20, 1, 1))
    head[:, :3, :3] = Rotation.from_euler("yxz", np.linspace([0, 0, 0], [0.5, -0.2, 0.1], 20)).as_matrix()
    head[:, :3, 3] = np.linspace([0, 0, 0], [0.02, -0.01, 0.03], 20)
    curves = with_head_curves(model, layer_clip(model, *shares(20, model), 30.0), head)
    assert np.abs(head_of_curves(model, curves) - head).max() < 1e-12
    giant = replace(
        model,
        rest=10 * model.rest + [1, 2, 3],
        layers=tuple(replace(layer, offsets=10 * layer.offsets) for layer in model.layers),
    )
    there = head_of_curves(giant, curves)
    here = np.einsum("fab,pb->fpa", head[:, :3, :3], model.rest) + head[:, None, :3, 3]
    wanted = np.einsum("fab,pb->fpa", there[:, :3, :3], giant.rest) + there[:, None, :3, 3]
    assert np.abs(wanted - (10 * here + [1, 2, 3])).max() < 1e-9
    gap = replace(curves, values=np.where(np.arange(20)[:, None] == 5, np.nan, curves.values))
    assert np.array_equal(head_of_curves(model, gap)[5], head_of_curves(model, curves)[4])
    assert head_of_curves(model, layer_clip(model, *shares(3, model), 30.0)) is None


def test_the_first_frame_at_rest_is_all_emotion() -> None:
    model, moved = acted(2)
    found = decomposer(model).decompose(np.zeros_like(moved))
    assert np.abs(found.weights[:, :, 0] - 1).max() < 1e-9
    assert residual_mm(model, found, np.zeros_like(moved)).max() < 1e-6
    assert solve_layered(decomposer(model).problem(np.ones(49, bool), 0.0), np.zeros((1, 3, 8)), np.zeros(1)).converged
