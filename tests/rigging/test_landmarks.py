"""Landmarks that pair two faces: what is refused, and in which words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import InputError, Mesh, Rig, SurfacePoints
from mien.core.rig import no_blendshapes
from mien.geometry.surface import closest_points
from mien.library import actor, character
from mien.rigging.dense import lay
from mien.rigging.landmarks import check_is_face, paired_landmarks


@pytest.fixture(scope="module")
def source() -> Rig:
    return actor()


@pytest.fixture(scope="module")
def target() -> Rig:
    return character()


def with_landmarks(rig: Rig, **changes: SurfacePoints | None) -> Rig:
    marks = {**rig.landmarks, **changes}
    return replace(rig, landmarks={name: point for name, point in marks.items() if point is not None})


def only(rig: Rig, *names: str) -> Rig:
    return replace(rig, landmarks={name: rig.landmarks[name] for name in names})


def ball(sides: int) -> Mesh:
    """A sphere of 9 cm."""
    a, b = np.meshgrid(np.linspace(0, np.pi, sides), np.arange(2 * sides) * np.pi / sides, indexing="ij")
    vertices = 0.09 * np.stack([np.sin(a) * np.sin(b), np.cos(a), np.sin(a) * np.cos(b)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(sides - 1), np.arange(2 * sides), indexing="ij")
    here, beside = (i * 2 * sides + j).ravel(), (i * 2 * sides + (j + 1) % (2 * sides)).ravel()
    below, across = here + 2 * sides, beside + 2 * sides
    return Mesh(vertices, np.concatenate([np.stack([here, below, across], 1), np.stack([here, across, beside], 1)]))


def box() -> Mesh:
    """A cube of 18 cm, made from the sphere by pushing every vertex out to the nearest face."""
    mesh = ball(24)
    return Mesh(0.09 * mesh.vertices / np.abs(mesh.vertices).max(axis=1, keepdims=True), mesh.triangles)


@pytest.mark.parametrize("shape", [ball(24), box()], ids=["ball", "box"])
@pytest.mark.parametrize("count", [10, 61])
def test_a_mesh_that_is_no_face_is_refused_with_a_number(source: Rig, shape: Mesh, count: int) -> None:
    names = sorted(source.landmarks)[:: max(1, 61 // count)]
    marks = paired_landmarks(only(source, *names), source).source
    points = marks.of(source.neutral.vertices)
    on_shape, _, _ = closest_points(shape.vertices, shape.triangles, points - points.mean(axis=0) + [0, 0, 0.06])
    fit = lay(source.neutral, marks, shape, on_shape, repair=False)
    with pytest.raises(InputError, match=r"does not look like the face .* \d+ %"):
        check_is_face(fit, "shape")


def test_a_face_is_a_face(source: Rig, target: Rig) -> None:
    pairs = paired_landmarks(source, target)
    check_is_face(lay(source.neutral, pairs.source, target.neutral, pairs.target, repair=False), target.name)


def test_too_few_landmarks_are_refused(source: Rig, target: Rig) -> None:
    with pytest.raises(InputError, match="share 3 landmarks"):
        paired_landmarks(source, only(target, "ibug_30", "ibug_36", "ibug_45"))


def test_one_missing_on_a_side_is_left_out(source: Rig, target: Rig) -> None:
    pairs = paired_landmarks(with_landmarks(source, ibug_30=None), target)
    assert "ibug_30" not in {name for _, name in pairs.names}
    assert "ibug_30" in " ".join(note.message for note in pairs.notes)


def test_two_at_one_place_are_named(source: Rig, target: Rig) -> None:
    with pytest.raises(InputError, match=r"'ibug_36' and 'ibug_39'|'ibug_39' and 'ibug_36'"):
        paired_landmarks(source, with_landmarks(target, ibug_36=target.landmarks["ibug_39"]))


def test_landmarks_in_one_plane_are_refused(source: Rig, target: Rig) -> None:
    with pytest.raises(InputError, match="in one plane"):
        paired_landmarks(source, only(target, "ibug_27", "ibug_30", "ibug_33", "chin_tip"))


def test_two_swapped_left_for_right_are_named(source: Rig, target: Rig) -> None:
    swapped = with_landmarks(target, ibug_36=target.landmarks["ibug_45"], ibug_45=target.landmarks["ibug_36"])
    with pytest.raises(InputError, match=r"swapped.*ibug_45 and ibug_36|swapped.*ibug_36 and ibug_45"):
        paired_landmarks(source, swapped)


def test_a_landmark_beyond_the_mesh_is_named(source: Rig, target: Rig) -> None:
    beyond = SurfacePoints.at_vertices(np.array([len(target.neutral.vertices)]))
    with pytest.raises(InputError, match=r"'ibug_30' .* belongs to another mesh"):
        paired_landmarks(source, with_landmarks(target, ibug_30=beyond))


def test_a_landmark_off_the_surface_is_named(source: Rig, target: Rig) -> None:
    mesh = target.neutral
    floating = Mesh(np.vstack([mesh.vertices, mesh.vertices.max(axis=0) + 0.05]), mesh.triangles)
    off = SurfacePoints.at_vertices(np.array([len(mesh.vertices)]))
    rig = Rig(floating, no_blendshapes(len(floating.vertices)), landmarks={**target.landmarks, "ibug_30": off})
    with pytest.raises(InputError, match=r"'ibug_30' .* off the surface"):
        paired_landmarks(source, rig)
