"""OBJ: vertex order, seams, polygons, groups, and folders of shapes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core import FileError, InputError, Mesh
from mien.io import obj
from tests.conftest import grid_rig
from tests.io.hostile import survives

PLANE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def mesh_of(tmp_path: Path, text: str, scale: float = 1.0) -> Mesh:
    path = tmp_path / "mesh.obj"
    path.write_bytes(text.encode())
    return obj.read_mesh(path, scale)


def same(a: Mesh, b: Mesh) -> None:
    np.testing.assert_array_equal(a.vertices, b.vertices)
    np.testing.assert_array_equal(a.triangles, b.triangles)
    assert a.faces == b.faces
    assert set(a.groups) == set(b.groups)
    for name, ids in a.groups.items():
        np.testing.assert_array_equal(ids, b.groups[name])
    assert (a.uv is None) == (b.uv is None)
    if a.uv is not None and b.uv is not None:
        np.testing.assert_array_equal(a.uv, b.uv)


@pytest.mark.parametrize(
    "face", ["1 2 3", "1/1 2/2 3/3", "1//1 2//1 3//1", "1/1/1 2/2/1 3/3/1", "-4 -3 -2", "1 2/2 3//1"]
)
def test_every_way_to_write_a_corner_gives_the_same_triangle(tmp_path: Path, face: str) -> None:
    mesh = mesh_of(tmp_path, f"{PLANE}vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf {face}\n")
    assert mesh.triangles.tolist() == [[0, 1, 2]]
    assert (mesh.uv is not None) == ("1/1" in face or "2/2" in face)


def test_negative_indices_count_from_where_they_stand(tmp_path: Path) -> None:
    mesh = mesh_of(tmp_path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 2 0 0\nv 3 0 0\nv 3 1 0\nf -3 -2 -1\n")
    assert mesh.triangles.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_unused_vertices_keep_their_place(tmp_path: Path) -> None:
    mesh = mesh_of(tmp_path, f"v 9 9 9\n{PLANE}f 2 3 4\n")
    assert mesh.vertices[0].tolist() == [9, 9, 9]
    assert mesh.triangles.tolist() == [[1, 2, 3]]


def test_a_quad_is_cut_along_its_shorter_diagonal_and_kept(tmp_path: Path) -> None:
    mesh = mesh_of(tmp_path, "v 0 0 0\nv 1 0 0\nv 3 1 0\nv 0 1 0\nf 1 2 3 4\n")
    assert [sorted(t) for t in mesh.triangles.tolist()] == [[1, 2, 3], [0, 1, 3]]
    assert mesh.faces == ((0, 1, 2, 3),)


def test_polygons_of_all_sizes_stay_in_order_and_keep_their_orientation(tmp_path: Path) -> None:
    angles = np.linspace(0, 2 * np.pi, 7)[:-1]
    ring = "".join(f"v {np.cos(a)} {np.sin(a)} 0\n" for a in angles)
    mesh = mesh_of(tmp_path, f"{ring}f 1 2 3 4 5 6\nf 1 2 3\nf 1 2 3 4\nf 2 3 4 5 6\n")
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normals[:, 2] > 0).all()
    assert len(mesh.triangles) == 4 + 1 + 2 + 3
    assert mesh.triangles[4].tolist() == [0, 1, 2]


def test_a_seam_keeps_both_texture_coordinates_of_a_vertex(tmp_path: Path) -> None:
    mesh = mesh_of(tmp_path, f"{PLANE}vt 0 0\nvt .5 0\nvt 1 1\nvt .9 .9\nf 1/1 2/2 3/3\nf 1/4 3/3 4/2\n")
    assert mesh.uv is not None
    assert mesh.uv[0, 0].tolist() == [0, 1]  # OBJ counts up from the bottom, mien down from the top
    assert np.allclose(mesh.uv[1, 0], [0.9, 0.1])


def test_text_is_read_as_programs_write_it(tmp_path: Path) -> None:
    text = (
        "# made by hand\r\nmtllib a.mtl\r\no head\r\nv 0 0 0 1 .5 0\r\n  v\t1 0 0 1 0 0\r\nv 1 1 0 0 0 1\r\ns off\r\n"
    )
    mesh = mesh_of(tmp_path, text + "g skin lip\r\nf 1 2 \\\r\n 3 # a face\r\n")
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    assert set(mesh.groups) == {"head", "skin", "lip"}
    assert mesh.groups["lip"].tolist() == [0, 1, 2]


def test_scale_multiplies_and_nothing_is_guessed(tmp_path: Path) -> None:
    assert mesh_of(tmp_path, PLANE).vertices.max() == 1
    assert mesh_of(tmp_path, PLANE, scale=0.01).vertices.max() == 0.01


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("hello\n", "no vertex"),
        (PLANE + "f 1 2 9\n", "line 5"),
        (PLANE + "f 0 1 2\n", "not there"),
        (PLANE + "f -9 1 2\n", "not there"),
        (PLANE + "f 1/5 2/5 3/5\n", "texture"),
        (PLANE + "f 1/-5 2/5 3/5\n", "texture"),
        (PLANE + "f 1 2\n", "2 corners"),
        (PLANE + "f a b c\n", "indices"),
        (PLANE + f"f 1 2 {'9' * 30}\n", "not there"),
        ("v 0 0\n", "2 numbers"),
        ("v 0 0 x\n", "numbers"),
        ("v 0 0 1e999\n", "infinite"),
    ],
)
def test_errors_say_what_and_where(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(FileError, match=said):
        mesh_of(tmp_path, text)


def test_a_mesh_with_seams_polygons_and_groups_survives_a_round_trip(tmp_path: Path, rng: np.random.Generator) -> None:
    points = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in rng.normal(size=(8, 3)).tolist())
    coordinates = "".join(f"vt {u!r} {v!r}\n" for u, v in rng.random((9, 2)).tolist())
    text = (
        f"{points}{coordinates}f 1/1 2/2 3/3\ng a\nf 2/5 3/6 4/7 5/8\ng a b\nf 3/1 4/2 5/3 6/4 7/9\ng\nf 1/1 6/2 7/3\n"
    )
    first = mesh_of(tmp_path, text)
    obj.write_mesh(tmp_path / "again.obj", first)
    same(first, obj.read_mesh(tmp_path / "again.obj"))


def test_a_rig_survives_a_round_trip(tmp_path: Path) -> None:
    rig = grid_rig()
    obj.write_rig(tmp_path / "rig", rig)
    again = obj.read_rig(tmp_path / "rig")
    same(rig.neutral, again.neutral)
    assert again.blendshapes.names == rig.blendshapes.names
    np.testing.assert_allclose(again.blendshapes.deltas, rig.blendshapes.deltas, atol=1e-16)
    assert obj.read_rig(tmp_path / "rig" / "neutral.obj").blendshapes.names == rig.blendshapes.names


def test_a_shape_of_another_mesh_is_named_with_both_counts(tmp_path: Path) -> None:
    (tmp_path / "Neutral.OBJ").write_text(PLANE)
    (tmp_path / "smile.obj").write_text(PLANE + "v 5 5 5\n")
    with pytest.raises(FileError, match=r"smile\.obj has 5 vertices, but the neutral Neutral\.OBJ 4"):
        obj.read_rig(tmp_path)
    rig = obj.read_rig(tmp_path / "Neutral.OBJ")
    assert [note.code for note in rig.notes] == ["not-a-shape"]


def test_a_folder_without_a_clear_neutral_asks_for_it(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"no \.obj"):
        obj.read_rig(tmp_path)
    (tmp_path / "head.obj").write_text(PLANE)
    assert len(obj.read_rig(tmp_path).blendshapes) == 0
    (tmp_path / "smile.obj").write_text(PLANE)
    with pytest.raises(FileError, match="none is"):
        obj.read_rig(tmp_path)
    (tmp_path / "base.obj").write_text(PLANE)
    (tmp_path / "rest.obj").write_text(PLANE)
    with pytest.raises(FileError, match="more than one is"):
        obj.read_rig(tmp_path)


@pytest.mark.parametrize("name", ["a/b", "..", "neutral", "c:d"])
def test_a_shape_that_cannot_be_a_file_is_refused_before_anything_is_written(tmp_path: Path, name: str) -> None:
    rig = grid_rig(shapes=(name,))
    with pytest.raises(InputError, match="rename"):
        obj.write_rig(tmp_path / "rig", rig)
    assert not (tmp_path / "rig").exists()


def test_polygons_that_are_not_what_was_cut_are_written_as_triangles(tmp_path: Path) -> None:
    mesh = replace(grid_rig().neutral, faces=((0, 1, 2, 3),))
    obj.write_mesh(tmp_path / "a.obj", mesh)
    np.testing.assert_array_equal(obj.read_mesh(tmp_path / "a.obj").triangles, mesh.triangles)


def test_damaged_files_are_refused_in_words(tmp_path: Path, rng: np.random.Generator) -> None:
    path = tmp_path / "a.obj"
    obj.write_mesh(path, replace(grid_rig(4).neutral, groups={"all": np.arange(16)}))
    survives(obj.read_mesh, path, rng)


@pytest.mark.real
def test_a_real_head_with_quads_and_seams_survives_a_round_trip(data: Path, tmp_path: Path) -> None:
    head = obj.read_mesh(data / "bones" / "base.obj")
    assert (len(head.vertices), len(head.triangles)) == (19158, 36972)
    obj.write_mesh(tmp_path / "head.obj", head)
    same(head, obj.read_mesh(tmp_path / "head.obj"))
