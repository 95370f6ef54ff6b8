"""Edges of teeth: split where they are sharp, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Blendshapes, InputError, Mesh, Rig
from mien.core.arrays import Floats, Ints
from mien.look.camera import Camera
from mien.look.creases import Creases
from mien.look.parts import surface_of
from mien.look.player import scene_of
from mien.look.portrait import Portrait
from mien.look.raster import vertex_normals
from tests.look.solids import ball

CAMERA = Camera(np.array([0.0, 0, 6]), np.zeros(3))


def roof(angle: float, columns: int = 6) -> tuple[Floats, Ints]:
    """Two sheets that meet along the x axis; their normals are `angle` [degrees] apart."""
    half = np.radians(angle) / 2
    x = np.linspace(-1, 1, columns)
    slopes = [np.stack([x, 0 * x + side * np.cos(half), 0 * x - np.sin(half)], axis=1) for side in (-1, 1)]
    points = np.concatenate([slopes[0], np.stack([x, 0 * x, 0 * x], axis=1), slopes[1]])
    a = (np.arange(2)[:, None] * columns + np.arange(columns - 1)).ravel()
    return points, np.concatenate(
        [np.stack([a, a + 1, a + columns], 1), np.stack([a + 1, a + columns + 1, a + columns], 1)]
    )


def creased(points: Floats, triangles: Ints, hard: bool = True) -> Creases:
    return Creases.of(points, triangles, np.arange(len(points)), np.full(len(points), hard))


def corner_normals(points: Floats, creases: Creases) -> Floats:
    """The normal at each corner of each triangle."""
    return vertex_normals(creases.split(points), creases.triangles, creases.same)[creases.triangles]


def face_normals(points: Floats, triangles: Ints) -> Floats:
    a, b, c = points[triangles].swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


@pytest.mark.parametrize("angle", [61.0, 90.0, 150.0, 179.0])
def test_the_two_sides_of_a_sharp_edge_keep_their_own_normals(angle: float) -> None:
    points, triangles = roof(angle)
    creases = creased(points, triangles)
    assert len(creases.doubled) == 6
    assert np.abs(corner_normals(points, creases) - face_normals(points, triangles)[:, None]).max() < 1e-12


@pytest.mark.parametrize(("angle", "hard"), [(59.0, True), (150.0, False)])
def test_a_blunt_edge_and_a_fold_of_skin_stay_whole(angle: float, hard: bool) -> None:
    points, triangles = roof(angle)
    creases = creased(points, triangles, hard)
    assert not len(creases.doubled)
    assert np.array_equal(creases.triangles, triangles)
    assert np.array_equal(creases.split(points), points)


def test_a_crease_that_fades_is_split_up_to_its_last_sharp_edge_only() -> None:
    points, triangles = roof(0.0, 12)
    points[:, 2] = -np.abs(points[:, 1]) * np.linspace(2, 0, 12)[np.arange(len(points)) % 12]
    normals = face_normals(points, triangles)
    sharp = (normals[22:33] * normals[11:22]).sum(axis=1) < 0.5  # the triangles on both sides of the ridge
    assert 2 < sharp.sum() < 9
    assert np.array_equal(creased(points, triangles).doubled, 12 + np.arange(sharp.sum()))


def test_a_seam_of_doubled_vertices_still_shares_its_normals() -> None:
    points, triangles = ball(60)
    _, first, inverse = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    same = first[inverse.ravel()]
    creases = Creases.of(points, triangles, same, np.ones(len(points), np.bool_))
    assert not len(creases.doubled)
    assert np.array_equal(vertex_normals(points, triangles, creases.same), vertex_normals(points, triangles, same))


def test_parts_that_touch_without_a_common_edge_do_not_share_normals() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, -1], [0, -1, 0]])
    triangles = np.array([[0, 1, 2], [3, 4, 5]])
    creases = Creases.of(points, triangles, np.array([0, 1, 2, 0, 4, 5]), np.ones(6, np.bool_))
    assert np.abs(corner_normals(points, creases) - face_normals(points, triangles)[:, None]).max() < 1e-12


def test_a_surface_without_triangles_has_no_creases() -> None:
    creases = creased(np.zeros((4, 3)), np.empty((0, 3), np.int64))
    assert np.array_equal(creases.same, np.arange(4))


def band(group: str, back: bool) -> Rig:
    """A sheet that faces the camera and, folded over its lower edge, one behind it, called by a name."""
    x = np.array([-1.0, 0, 1])
    front = [np.stack([x, 0 * x + y, 0 * x], axis=1) for y in (0.8, 0.0, -0.8)]
    points = np.concatenate([*front, front[0] - [0, 0, 0.4]])
    a = np.array([0, 1, 3, 4, 6, 7] if back else [0, 1, 3, 4])
    triangles = np.concatenate([np.stack([a, a + 3, a + 1], 1), np.stack([a + 1, a + 3, a + 4], 1)])
    mesh = Mesh(points, triangles, groups={group: np.arange(len(points))})
    return Rig(mesh, Blendshapes(("a",), 0.1 * points[None]))


@pytest.mark.parametrize("pose", [0.0, 1.0])
def test_a_folded_band_of_teeth_looks_like_its_front_alone(pose: float) -> None:
    one, both = (
        Portrait.of(band("teeth", back), camera=CAMERA, size=(64, 64)).picture(np.array([pose]))
        for back in (False, True)
    )
    assert np.array_equal(one, both)


def test_only_teeth_are_creased_in_pictures_and_pages() -> None:
    for group, doubles in (("lower_teeth", 3), ("chin", 0)):
        rig = band(group, True)
        assert len(Portrait.of(rig, camera=CAMERA).creases.doubled) == doubles
        _, arrays = scene_of(rig)
        assert len(arrays["positions"]) == len(rig.neutral.vertices) + doubles
        assert len(arrays["colours"]) == len(arrays["same"]) == len(arrays["positions"])


def test_teeth_are_told_whatever_their_colour() -> None:
    rig = band("teeth", True)
    assert surface_of(replace(rig, colours={"teeth": (0.9, 0.1, 0.1)})).teeth.all()
    assert not surface_of(band("chin", True)).teeth.any()


def test_colours_given_for_a_picture_are_those_of_the_rigs_own_vertices() -> None:
    rig = band("teeth", True)
    sitter = Portrait.of(rig, camera=CAMERA, size=(64, 64))
    green = np.broadcast_to([0.1, 0.8, 0.1], rig.neutral.vertices.shape)
    assert (sitter.picture(colours=green)[24:40, 24:40, 1] > sitter.picture(colours=green)[24:40, 24:40, 0]).all()
    with pytest.raises(InputError, match="vertex colours"):
        sitter.picture(colours=green[:3])
