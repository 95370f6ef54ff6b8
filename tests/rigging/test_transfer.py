"""A whole rig on another face: what plays there is what plays on the rig."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import InputError, Rig
from mien.core.arrays import Floats
from mien.geometry.align import rigid, transform
from mien.geometry.templates import template_shapes
from mien.library.generic import generic_rig
from mien.library.heads import cartoon_head, tortoise_head
from mien.rigging.baking import baked, scripted
from mien.rigging.transfer import Transfer, transfer_rig
from tests.rigging.moved import SCALE, TURN, bare, radius, similar, similar_face, skin_only

FEW = ("jawOpen", "eyeBlinkLeft", "mouthSmileLeft", "mouthPucker", "eyeLookUpLeft", "amazement", "disgust", "viseme_O")


@pytest.fixture(scope="module")
def generic() -> Rig:
    return generic_rig()


@pytest.fixture(scope="module")
def on_itself(generic: Rig) -> Transfer:
    return transfer_rig(generic, bare(generic))


@pytest.fixture(scope="module")
def on_similar(generic: Rig) -> Transfer:
    return transfer_rig(generic, similar_face())


@pytest.fixture(scope="module")
def on_skin(generic: Rig) -> Transfer:
    return transfer_rig(generic, skin_only())


@pytest.fixture(scope="module")
def on_tortoise(generic: Rig) -> Transfer:
    return transfer_rig(generic, tortoise_head())


def test_on_its_own_face_a_rig_plays_what_it_played(generic: Rig, on_itself: Transfer) -> None:
    assert on_itself.notes == ()
    difference = template_shapes(on_itself.rig).deltas - template_shapes(generic).deltas
    assert np.abs(difference).max() < 1e-6 * radius(generic)


def test_on_a_turned_and_larger_face_it_plays_the_same_turned_and_larger(generic: Rig, on_similar: Transfer) -> None:
    wanted = SCALE * template_shapes(generic).deltas @ TURN.T
    difference = template_shapes(on_similar.rig).deltas - wanted
    assert np.abs(difference).max() < 1e-6 * SCALE * radius(generic)
    assert on_similar.rig.skeleton is not None
    assert generic.skeleton is not None
    assert np.allclose(on_similar.rig.skeleton.rest[:, :3, 3], similar(generic.skeleton.rest[:, :3, 3]))


def test_the_face_itself_is_not_altered(on_tortoise: Transfer, on_skin: Transfer) -> None:
    for given, moved in ((tortoise_head(), on_tortoise), (skin_only(), on_skin)):
        count, rig = len(given.neutral.vertices), moved.rig
        assert np.array_equal(rig.neutral.vertices[:count], given.neutral.vertices)
        assert np.array_equal(rig.neutral.triangles[: len(given.neutral.triangles)], given.neutral.triangles)
        assert len(rig.neutral.vertices) == count + len(moved.brought.vertices)
        if given.neutral.uv is not None:
            assert rig.neutral.uv is not None
            assert np.array_equal(rig.neutral.uv[: len(given.neutral.uv)], given.neutral.uv)


@pytest.mark.parametrize("most", [1, 2, 4])
def test_weights_sum_to_one_over_as_many_joints_as_asked(generic: Rig, most: int) -> None:
    skin = transfer_rig(generic, cartoon_head(), influences=most).rig.skin
    assert skin is not None
    assert skin.joints.shape[1] <= most
    assert skin.weights.min() >= 0
    assert np.abs(skin.weights.sum(axis=1) - 1).max() < 1e-12


def test_labels_are_those_of_the_rig_and_never_blended(generic: Rig, on_tortoise: Transfer) -> None:
    assert generic.anatomy is not None
    assert on_tortoise.rig.anatomy is not None
    own, carried = generic.anatomy.labels["region"], on_tortoise.rig.anatomy.labels["region"]
    skin = np.flatnonzero(on_tortoise.fit.target_skin)
    beneath = own.of[on_tortoise.fit.back.corners[skin]]
    assert carried.names == own.names
    assert (carried.of[skin][:, None] == beneath).any(axis=1).all()


def test_landmarks_are_met(on_tortoise: Transfer) -> None:
    fit = on_tortoise.fit
    exact = np.abs(fit.warp(fit.warp.centres) - _nearest(fit.target.vertices, fit.warp(fit.warp.centres)))
    assert exact.max() < 1e-9 * radius(on_tortoise.rig)


@pytest.mark.parametrize("group", ["eye_left", "eye_right"])
def test_eyes_are_rigid_in_every_template(on_tortoise: Transfer, on_skin: Transfer, group: str) -> None:
    for moved in (on_tortoise, on_skin):
        ids = moved.rig.neutral.groups[group]
        rest = moved.rig.neutral.vertices[ids]
        posed = rest + template_shapes(moved.rig).deltas[:, ids]
        motion = rigid(rest, posed, np.ones(posed.shape[:2]))
        assert np.abs(transform(motion, rest) - posed).max() < 1e-9


def test_an_eye_turns_about_its_own_centre(on_tortoise: Transfer) -> None:
    ids = on_tortoise.rig.neutral.groups["eye_left"]
    rest = on_tortoise.rig.neutral.vertices[ids]
    delta = template_shapes(on_tortoise.rig, ["eyeLookUpLeft"]).deltas[0, ids]
    size = float(np.ptp(rest, axis=0).max())
    assert np.linalg.norm(delta, axis=1).max() > 0.1 * size
    assert np.linalg.norm(delta.mean(axis=0)) < 0.08 * size


def test_left_is_left(on_tortoise: Transfer) -> None:
    shapes = template_shapes(on_tortoise.rig, ["eyeBlinkLeft", "eyeBlinkRight"]).deltas
    x = on_tortoise.rig.neutral.vertices[:, 0]
    size = np.linalg.norm(shapes, axis=2)
    assert size[0][x < 0].max() == 0
    assert size[1][x > 0].max() == 0
    assert size[0].max() == pytest.approx(size[1].max(), rel=0.05)


def test_baked_lids_close_on_a_stranger(generic: Rig, on_tortoise: Transfer) -> None:
    own = on_tortoise.fit.target
    upper, lower = (own.groups[f"{lid}_lid_left"] for lid in ("upper", "lower"))
    apart = _gap(own.vertices[upper], own.vertices[lower])
    shapes, _ = baked(on_tortoise, generic, ["eyeBlinkLeft"])
    posed = own.vertices + shapes.deltas[0, : len(own.vertices)]
    assert _gap(posed[upper], posed[lower]) < 0.1 * apart


def test_all_templates_are_baked_and_scripts_become_their_weights(generic: Rig, on_skin: Transfer) -> None:
    anatomy = on_skin.rig.anatomy
    assert anatomy is not None
    shapes, _ = baked(on_skin, generic, FEW)
    assert shapes.names == FEW
    script = next(iter(anatomy.scripts.values()))
    clip = scripted(script, shapes)
    assert clip.names == FEW
    assert np.array_equal(clip.values[:, 5], script.channels(["amazement"])[:, 0])


def test_a_baseline_moves_the_templates_as_shapes(generic: Rig) -> None:
    few = replace(generic.anatomy, templates={"jawOpen": generic.anatomy.templates["jawOpen"]}, bases={}, scripts={})  # type: ignore[union-attr, type-var]
    moved = transfer_rig(replace(generic, anatomy=few), cartoon_head(), method="rbf")
    assert moved.rig.blendshapes.names == ("jawOpen",)
    assert np.linalg.norm(moved.rig.blendshapes.deltas, axis=2).max() > 0.01


def test_words_it_does_not_know_are_refused(generic: Rig) -> None:
    with pytest.raises(InputError, match="warp-and-stick"):
        transfer_rig(generic, bare(generic), method="magic")
    with pytest.raises(InputError, match="auto"):
        transfer_rig(generic, bare(generic), parts="some")


def _nearest(points: Floats, queries: Floats) -> Floats:
    return points[np.linalg.norm(points[None] - queries[:, None], axis=2).argmin(axis=1)]


def _gap(upper: Floats, lower: Floats) -> float:
    """The mean distance from the upper edge to the lower one, its corners left out."""
    line = lower[np.argsort(lower[:, 0])]
    steps = np.linspace(0, len(line) - 1, 200)
    fine = np.stack([np.interp(steps, np.arange(len(line)), line[:, axis]) for axis in range(3)], axis=1)
    inner = upper[np.argsort(upper[:, 0])][2:-2]
    return float(np.linalg.norm(inner[:, None] - fine, axis=2).min(axis=1).mean())
