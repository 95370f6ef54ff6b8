"""The embedded library: valid meshes, shapes that do what their names say, and a take that repeats itself."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from mien.core import Rig
from mien.geometry.muscles import on_polyline
from mien.library import actor, character, performance
from mien.library.cast import cast_member, rigged
from mien.rigging.parts import centre_of

CAST = {"actor": actor, "character": character}


@cache
def played(name: str) -> Rig:
    return CAST[name]()


@pytest.fixture(params=list(CAST))
def rig(request: pytest.FixtureRequest) -> Rig:
    return played(request.param)


def point(rig: Rig, name: str, vertices: np.ndarray | None = None) -> np.ndarray:
    return rig.landmarks[name].of(rig.neutral.vertices if vertices is None else vertices)[0]


def posed(rig: Rig, **weights: float) -> np.ndarray:
    values = np.zeros(len(rig.blendshapes))
    for name, value in weights.items():
        values[rig.blendshapes.index(name)] = value
    return rig.pose(values)


def test_every_shape_moves_something_and_a_left_one_moves_the_left(rig: Rig) -> None:
    assert rig.blendshapes.empty == ()
    reach = np.linalg.norm(rig.blendshapes.deltas, axis=2)
    assert (reach.max(axis=1) > 0.001).all()
    x = rig.neutral.vertices[:, 0]
    for name, moved in zip(rig.blendshapes.names, reach, strict=True):
        if name.endswith(("Left", "_L")) and not name.lower().startswith(("jaw", "mouthleft", "mouth_shift", "look")):
            assert moved[x < -0.02].max() < 0.25 * moved[x > 0].max(), name


BLINKS = [("actor", "eyeBlinkLeft", "left"), ("actor", "eyeBlinkRight", "right")]
BLINKS += [("character", "Blink_L", "left"), ("character", "Blink_R", "right")]


@pytest.mark.parametrize(("name", "blink", "side"), BLINKS)
def test_a_blink_closes_the_lids_and_leaves_the_skin_on_the_eyeball(name: str, blink: str, side: str) -> None:
    rig = played(name)
    upper, lower = rig.neutral.groups[f"upper_lid_{side}"], rig.neutral.groups[f"lower_lid_{side}"]
    along = lower[np.argsort(rig.neutral.vertices[lower, 0])]

    def apart(v: np.ndarray) -> np.ndarray:
        return np.asarray(v[upper] - on_polyline(v[along], v[upper])[2])

    shut = posed(rig, **{blink: 1.0})
    opened = np.linalg.norm(apart(rig.neutral.vertices), axis=1)
    wide = opened > 0.3 * opened.max()
    assert opened.max() > 0.008
    left_open = np.maximum(apart(shut)[wide, 1], 0)
    assert np.median(left_open / opened[wide]) < 0.01
    assert (left_open / opened[wide]).max() < 0.1
    assert np.median(np.linalg.norm(apart(shut)[wide], axis=1) / opened[wide]) < 0.1  # a little of one over the other
    ball = rig.neutral.vertices[rig.neutral.groups[f"sclera_{side}"]]
    centre = centre_of(ball)
    skin = np.setdiff1d(rig.neutral.groups["face"], rig.neutral.groups["mouth"])
    radius = np.linalg.norm(ball - centre, axis=1).max()
    assert np.linalg.norm(shut[skin] - centre, axis=1).min() > radius - 2e-4


@pytest.mark.parametrize(("name", "opened"), [("actor", "jawOpen"), ("character", "Jaw_Open")])
def test_the_jaw_opens_the_lips_and_takes_the_lower_teeth_along(name: str, opened: str) -> None:
    rig = played(name)
    v = posed(rig, **{opened: 1.0})
    assert 0 < point(rig, "ibug_62")[1] - point(rig, "ibug_66")[1] < 0.0005
    assert point(rig, "ibug_62", v)[1] - point(rig, "ibug_66", v)[1] > 0.02
    drop = rig.neutral.vertices - v
    assert drop[rig.neutral.groups["teeth_lower"], 1].min() > 0.01
    assert not drop[rig.neutral.groups["teeth_upper"]].any()
    assert abs(drop[rig.landmarks["ibug_33"].corners[0, 0]]).max() < 0.001


def test_the_actor_is_human_sized_and_the_character_is_not_like_them() -> None:
    a, c = played("actor"), played("character")
    height = a.neutral.vertices[:, 1].max() - point(a, "chin_tip")[1]
    assert 0.21 < height < 0.24
    assert len(a.neutral.vertices) != len(c.neutral.vertices)
    assert not set(a.blendshapes.names) & set(c.blendshapes.names)
    assert len(c.blendshapes) < len(a.blendshapes)

    def eye(rig: Rig) -> float:
        return float(np.linalg.norm(point(rig, "ibug_45") - point(rig, "ibug_42")))

    assert eye(c) > 1.4 * eye(a)


def test_the_cast_repeats_itself(rig: Rig) -> None:
    rigged.cache_clear()
    cast_member.cache_clear()
    again = CAST[rig.name]()
    assert np.array_equal(again.neutral.vertices, rig.neutral.vertices)
    assert np.array_equal(again.neutral.triangles, rig.neutral.triangles)
    assert np.array_equal(again.blendshapes.deltas, rig.blendshapes.deltas)


def test_the_take_shows_every_shape_at_its_extreme() -> None:
    clip, _ = performance(played("actor"))
    assert clip.values.min() >= 0
    assert clip.values.max(axis=0) == pytest.approx(1, abs=1e-9)
    assert not clip.values[0].any()
    assert np.abs(np.diff(clip.values, axis=0)).max() < 0.3


def test_the_markers_ride_on_the_posed_face_with_a_little_noise() -> None:
    rig = played("actor")
    clip, markers = performance(rig)
    assert markers.names == tuple(rig.landmarks)
    assert clip.head is not None
    for frame in (0, 200, 700):
        v = rig.pose(clip.values[frame])
        truth = np.stack([point(rig, name, v) for name in rig.landmarks])
        truth = truth @ clip.head[frame, :3, :3].T + clip.head[frame, :3, 3]
        off = (markers.points[frame] - truth)[markers.seen[frame]]
        assert 0.0001 < off.std() < 0.0002


def test_the_markers_have_short_gaps_and_a_long_one() -> None:
    _, markers = performance(played("actor"))
    lost = ~markers.seen
    assert 90 <= lost.sum(axis=0).max() < 150
    assert (lost.any(axis=0)).sum() > 4
    assert lost.mean() < 0.01


def test_the_head_turns_and_stays_rigid() -> None:
    clip, _ = performance(played("actor"))
    assert clip.head is not None
    turn = clip.head[:, :3, :3]
    assert np.allclose(turn @ turn.transpose(0, 2, 1), np.eye(3))
    assert np.array_equal(clip.head[0], np.eye(4))
    assert np.degrees(np.arccos((np.trace(turn, axis1=1, axis2=2).min() - 1) / 2)) > 10


def test_the_take_repeats_itself_and_another_generator_gives_other_noise(rng: np.random.Generator) -> None:
    rig = played("actor")
    first, second = performance(rig)[1], performance(rig)[1]
    assert np.array_equal(first.points, second.points, equal_nan=True)
    assert not np.array_equal(first.points, performance(rig, rng)[1].points, equal_nan=True)
