"""Framing: everything of the face in the picture, and little else."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import Blendshapes, InputError, Mesh, Rig
from mien.look.camera import Camera, face_points, frame_all, frame_face
from tests.conftest import grid_rig


@pytest.mark.parametrize("view", ["front", "three-quarter", "side"])
@pytest.mark.parametrize("aspect", [0.7, 1.0, 16 / 9])
def test_all_points_lie_in_the_picture_and_touch_its_margin(view: str, aspect: float, rng: np.random.Generator) -> None:
    points = rng.normal(0, 0.1, (200, 3)) + np.array([1.0, 2.0, -3.0])
    camera = frame_face(points, view, aspect=aspect, margin=0.1)
    width, height = round(1000 * aspect), 1000
    x, y, distance = camera.project(points, width, height).T
    assert (distance > 0).all()
    reach = max(np.abs(x / width - 0.5).max(), np.abs(y / height - 0.5).max())
    assert reach == pytest.approx(0.4, abs=0.002)


def test_from_the_front_the_subjects_left_is_on_the_right_and_up_is_up() -> None:
    camera = frame_face(np.array([[-1.0, -1, 0], [1, 1, 0]]), "front")
    (left, low, _), (right, high, _) = camera.project(np.array([[-1.0, -1, 0], [1, 1, 0]]), 100, 100)
    assert left < right
    assert low > high


def test_from_the_side_the_nose_points_left() -> None:
    points = np.array([[0.0, 0, 1], [0, 0, -1]])
    nose, nape = frame_face(points, "side").project(points, 100, 100)
    assert nose[0] < nape[0]


def test_a_rig_is_framed_where_its_shapes_move_things() -> None:
    face = grid_rig()
    body = np.array([[0.0, -2.0, 0.0], [0.4, -1.0, 0.0], [-0.4, -1.5, 0.0]])
    vertices = np.concatenate([face.neutral.vertices, body])
    deltas = np.concatenate([face.blendshapes.deltas, np.zeros((3, 3, 3))], axis=1)
    whole = Rig(Mesh(vertices, face.neutral.triangles), Blendshapes(face.blendshapes.names, deltas))
    assert np.allclose(frame_face(whole).position, frame_face(face).position)
    assert face_points(whole)[:, 1].min() > -0.5


def test_a_rig_that_moves_nothing_is_framed_whole() -> None:
    rig = grid_rig()
    still = Rig(rig.neutral, Blendshapes(("a",), np.zeros((1, len(rig.neutral.vertices), 3))))
    assert np.array_equal(np.unique(face_points(still), axis=0), np.unique(rig.neutral.vertices, axis=0))


def test_horns_above_the_face_are_in_the_picture_and_shoulders_below_it_are_not() -> None:
    rig = grid_rig(12)
    more = np.array([[0.05, 0.16, 0.0], [0.3, -0.3, 0.0]])
    vertices = np.concatenate([rig.neutral.vertices, more])
    deltas = np.pad(rig.blendshapes.deltas, ((0, 0), (0, 2), (0, 0)))
    horned = Rig(Mesh(vertices, rig.neutral.triangles), Blendshapes(rig.blendshapes.names, deltas))
    (_, horn, _), (shoulder, _, _) = frame_face(horned).project(more, 100, 100)
    assert 0 < horn < 100
    assert shoulder > 100


@pytest.mark.parametrize("view", ["front", "three-quarter", "side"])
def test_framing_many_clouds_is_framing_all_their_points(view: str, rng: np.random.Generator) -> None:
    clouds = rng.normal(size=(30, 40, 3))
    assert np.allclose(
        frame_all(iter(clouds), view, aspect=1.5).position, frame_face(clouds, view, aspect=1.5).position
    )
    x, y, _ = np.moveaxis(frame_all(clouds, view, aspect=1.5).project(clouds, 150, 100), -1, 0)
    assert max(np.abs(x / 150 - 0.5).max(), np.abs(y / 100 - 0.5).max()) == pytest.approx(0.42, abs=1e-6)


def test_framing_scales_with_the_face() -> None:
    points = np.random.default_rng(1).normal(size=(50, 3))
    small, large = frame_face(points), frame_face(100 * points)
    assert np.allclose(100 * small.position, large.position)


@pytest.mark.parametrize("position", [(0.0, 0, 0), (0.0, 5, 0)])
def test_a_camera_without_a_horizon_is_refused(position: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="straight up or down"):
        Camera(np.array(position), np.zeros(3))


def test_an_unknown_view_is_refused_with_the_known_ones() -> None:
    with pytest.raises(InputError, match="three-quarter"):
        frame_face(np.eye(3), "above")  # type: ignore[arg-type]
