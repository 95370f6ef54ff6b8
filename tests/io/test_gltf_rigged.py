"""A rig written into a face's own file: the face is as it was, and it moves as the rig does."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest

from mien.core import Blendshapes, Clip, InputError, Rig, Skin
from mien.io.gltf import read_clip, read_rig, write_rigged
from mien.library import actor
from tests.conftest import grid_rig
from tests.io.gltf_samples import FACES, SQUARE, Sample, contents, matrix, skinned, turn
from tests.io.rigged_samples import fitted, moved, played, with_parts
from tests.io.test_gltf_write import faults  # noqa: F401


def sheet_file(path, **node):
    """A bent sheet in a file of its own, its node turned, moved and scaled."""
    s, face = Sample(), grid_rig()
    points, faces = np.float32(face.neutral.vertices), np.uint16(face.neutral.triangles)
    s.mesh(s.primitive(points, faces, np.float32(face.blendshapes.deltas)), shapes=face.blendshapes.names)
    s.node(mesh=0, **(node or {"translation": [0.1, 1, 0], "rotation": turn(1, 0.3).tolist(), "scale": [2, 1, 3]}))
    return s, s.save(path)


def moves_alike(rig: Rig, again: Rig, tolerance: float = 1e-6) -> None:
    """Both go to the same places; shapes and joints are found by name."""
    weights = np.random.default_rng(1).random((2, len(rig.blendshapes)))
    other = np.zeros((2, len(again.blendshapes)))
    for k, name in enumerate(rig.blendshapes.names):
        other[:, again.blendshapes.index(name)] = weights[:, k]
    joints = moved(rig, 2)
    place = [rig.skeleton.names.index(name) for name in again.skeleton.names]
    expected = rig.pose(weights, joints)
    assert np.abs(again.pose(other, joints[:, place])[:, : expected.shape[1]] - expected).max() < tolerance


def test_a_rig_in_a_turned_scaled_node_moves_as_it_should(tmp_path, faults):  # noqa: F811
    _, path = sheet_file(tmp_path / "a.glb")
    face = read_rig(path)
    rig = fitted(face)
    assert write_rigged(tmp_path / "b.glb", rig) == ()
    again = read_rig(tmp_path / "b.glb")
    assert np.abs(again.neutral.vertices - face.neutral.vertices).max() < 1e-6
    assert again.blendshapes.names == (*face.blendshapes.names, *rig.blendshapes.names)
    assert np.abs(again.blendshapes.deltas[:3] - face.blendshapes.deltas).max() < 1e-7
    moves_alike(rig, again)
    assert faults(tmp_path / "b.glb") == []


def test_everything_else_of_the_face_stays(tmp_path):
    s, _ = sheet_file(tmp_path / "a.glb")
    s.root["extensionsUsed"] = ["ACME_hair"]
    s.root["extensions"] = {"ACME_hair": {"strands": [1, 2.5]}}
    s.root["materials"] = [{"name": "skin", "extensions": {"ACME_hair": True}}]
    s.root["meshes"][0]["primitives"][0] |= {"material": 0, "extras": {"mine": 1}}
    s.root["extras"] = {"author": "someone"}
    before, data = contents(s.save(tmp_path / "a.glb"))
    rig = fitted(read_rig(tmp_path / "a.glb"))
    write_rigged(tmp_path / "b.glb", rig, {"act": played(rig)})
    after, longer = contents(tmp_path / "b.glb")
    assert longer.startswith(data)
    left = copy.deepcopy(after)
    for kind in ("accessors", "bufferViews", "nodes"):
        left[kind] = left[kind][: len(before[kind])]
    primitive = left["meshes"][0]["primitives"][0]
    primitive["targets"] = primitive["targets"][:3]
    assert set(primitive["attributes"]) == {"POSITION", "JOINTS_0", "WEIGHTS_0"}
    primitive["attributes"] = {"POSITION": primitive["attributes"]["POSITION"]}
    left["meshes"][0]["extras"]["targetNames"] = left["meshes"][0]["extras"]["targetNames"][:3]
    left["scenes"][0]["nodes"] = left["scenes"][0]["nodes"][:1]
    left["buffers"] = before["buffers"]
    del left["skins"], left["animations"], left["nodes"][0]["skin"]
    assert left == before


def test_several_clips_are_animations_by_name_in_their_order(tmp_path):
    _, path = sheet_file(tmp_path / "a.glb")
    rig = fitted(read_rig(path))
    clips = {"speech": played(rig, 6), "nod": Clip((), np.zeros((4, 0)), 24.0, joints=moved(rig))}
    write_rigged(tmp_path / "b.gltf", rig, clips)
    root_names = read_clip(tmp_path / "b.gltf", 0), read_clip(tmp_path / "b.gltf", "nod")
    assert len(root_names[0]) == 6
    again = read_rig(tmp_path / "b.gltf")
    for name, clip in clips.items():
        back = read_clip(tmp_path / "b.gltf", name)
        expected = rig.pose(clip.channels(rig.blendshapes.names), clip.joints)
        assert np.abs(again.pose(back.values, back.joints) - expected).max() < 2e-6


def test_parts_beyond_the_file_follow_behind_its_vertices(tmp_path, faults):  # noqa: F811
    _, path = sheet_file(tmp_path / "a.glb")
    rig = with_parts(fitted(read_rig(path)))
    write_rigged(tmp_path / "b.glb", rig, colours={"eye_left": (1, 1, 1)})
    again = read_rig(tmp_path / "b.glb")
    assert np.abs(again.neutral.vertices - rig.neutral.vertices).max() < 1e-6
    assert np.array_equal(again.neutral.triangles, rig.neutral.triangles)
    moves_alike(rig, again)
    assert again.skeleton.names == rig.skeleton.names
    assert [m["name"] for m in contents(tmp_path / "b.glb")[0]["materials"]] == ["eye_left"]
    assert faults(tmp_path / "b.glb") == []


def test_a_mesh_shown_twice_gets_a_rig_at_each_place(tmp_path, faults):  # noqa: F811
    s, _ = sheet_file(tmp_path / "a.glb")
    s.node(mesh=0, translation=[0, 5, 0], weights=[0, 0, 0])
    rig = fitted(read_rig(s.save(tmp_path / "a.glb")))
    write_rigged(tmp_path / "b.glb", rig, {"act": played(rig)})
    moves_alike(rig, read_rig(tmp_path / "b.glb"), 2e-6)
    assert faults(tmp_path / "b.glb") == []


def test_animations_of_a_mesh_that_got_more_shapes_still_play(tmp_path, faults):  # noqa: F811
    s, _ = sheet_file(tmp_path / "a.glb")
    keys, cubic = np.random.default_rng(1).random((3, 3)), np.random.default_rng(2).random((3, 3, 3))
    times = np.arange(3) / 24
    s.animate((0, "weights", times, keys, "LINEAR"), name="old")
    s.animate((0, "weights", times, cubic, "CUBICSPLINE"), name="smooth")
    s.root["meshes"][0]["weights"] = [0, 0, 0]
    rig = fitted(read_rig(s.save(tmp_path / "a.glb")))
    write_rigged(tmp_path / "b.glb", rig)
    for name in ("old", "smooth"):
        was, now = read_clip(tmp_path / "a.glb", name), read_clip(tmp_path / "b.glb", name)
        assert np.array_equal(now.values[:, :3], was.values)
        assert not now.values[:, 3:].any()
    assert faults(tmp_path / "b.glb") == []


def test_a_shape_of_the_same_name_is_replaced_and_an_equal_one_left_alone(tmp_path):
    _, path = sheet_file(tmp_path / "a.glb")
    face = read_rig(path)
    deltas = face.blendshapes.deltas.copy()
    deltas[1] *= -0.5
    write_rigged(tmp_path / "b.glb", replace(face, blendshapes=Blendshapes(face.blendshapes.names, deltas)))
    again = read_rig(tmp_path / "b.glb")
    assert again.blendshapes.names == face.blendshapes.names
    assert np.abs(again.blendshapes.deltas - deltas).max() < 1e-7
    before, after = (contents(tmp_path / n)[0]["meshes"][0]["primitives"][0]["targets"] for n in ("a.glb", "b.glb"))
    assert [a == b for a, b in zip(before, after, strict=True)] == [True, False, True]


def test_targets_with_normals_stay_uniform(tmp_path, faults):  # noqa: F811
    s, _ = sheet_file(tmp_path / "a.glb")
    for target in s.root["meshes"][0]["primitives"][0]["targets"]:
        target["NORMAL"] = target["POSITION"]
    s.root["meshes"][0]["primitives"].append(
        {
            "attributes": {"POSITION": 0},
            "mode": 0,
            "targets": [dict(target) for target in s.root["meshes"][0]["primitives"][0]["targets"]],
        }
    )
    s.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = s.array(np.float32([[0, 0, 1]] * 36))
    s.root["meshes"][0]["primitives"][1]["attributes"]["NORMAL"] = len(s.root["accessors"]) - 1
    rig = fitted(read_rig(s.save(tmp_path / "a.glb")))
    write_rigged(tmp_path / "b.glb", rig)
    for primitive in contents(tmp_path / "b.glb")[0]["meshes"][0]["primitives"]:
        assert [set(target) for target in primitive["targets"]] == [{"POSITION", "NORMAL"}] * 6
    moves_alike(rig, read_rig(tmp_path / "b.glb"))
    assert faults(tmp_path / "b.glb") == []


def test_a_skinned_body_carries_the_new_joints_by_what_held_the_face(tmp_path, faults):  # noqa: F811
    s = Sample()
    joints, weights = np.zeros((4, 4), np.uint8), np.float32([[0.9, 0.1, 0, 0]] * 4)
    joints[:, :2] = 1, 0
    inverse = np.stack([np.eye(4), matrix((0, -1, 0))]).swapaxes(1, 2).reshape(2, 16)
    s.mesh(s.primitive(SQUARE, FACES, attributes={"JOINTS_0": s.array(joints), "WEIGHTS_0": s.array(weights)}))
    s.add("skins", {"joints": [1, 2], "inverseBindMatrices": s.array(np.float32(inverse))})
    s.node(mesh=0, skin=0)
    s.node(name="hips", children=[2])
    s.node(root=False, name="skull", translation=[0, 1, 0])
    rig = fitted(read_rig(s.save(tmp_path / "a.glb")))
    notes = write_rigged(tmp_path / "b.glb", rig)
    assert [note.code for note in notes] == ["carriers-replaced"]
    assert "10.0 %" in notes[0].message
    root, _ = contents(tmp_path / "b.glb")
    assert [root["nodes"][i]["name"] for i in root["nodes"][2]["children"]] == ["head"]
    moves_alike(rig, read_rig(tmp_path / "b.glb"), 2e-6)
    assert faults(tmp_path / "b.glb") == []


def test_a_face_that_its_own_skin_poses_at_rest_is_refused(tmp_path):
    rig = fitted(read_rig(skinned(animated=False).save(tmp_path / "a.glb")))
    with pytest.raises(InputError, match="posed at rest"):
        write_rigged(tmp_path / "b.glb", rig)
    assert not (tmp_path / "b.glb").exists()


def test_a_rig_that_is_the_files_own_keeps_its_skin_and_gets_shapes(tmp_path, faults):  # noqa: F811
    rig = read_rig(skinned(animated=False).save(tmp_path / "a.glb"))
    more = Blendshapes(
        (*rig.blendshapes.names, "new"), np.concatenate([rig.blendshapes.deltas, np.full((1, 8, 3), 0.1)])
    )
    rig = replace(rig, blendshapes=more)
    assert write_rigged(tmp_path / "b.glb", rig) == ()
    again = read_rig(tmp_path / "b.glb")
    assert again.skeleton.names == rig.skeleton.names
    assert np.abs(again.blendshapes.deltas - more.deltas).max() < 1e-6
    assert len(contents(tmp_path / "b.glb")[0]["nodes"]) == 5
    assert faults(tmp_path / "b.glb") == []


def test_a_face_on_a_moving_node_keeps_moving_with_it(tmp_path):
    s, _ = sheet_file(tmp_path / "a.glb", name="face")
    s.node(name="cart", children=[0])
    s.root["scenes"][0]["nodes"] = [1]
    s.animate((1, "translation", np.arange(3) / 24, np.float32([[0, 0, 0], [1, 0, 0], [2, 0, 0]]), "LINEAR"))
    face, rolling = read_rig(s.save(tmp_path / "a.glb")), read_clip(tmp_path / "a.glb")
    rig = fitted(face)
    write_rigged(tmp_path / "b.glb", rig)
    again, clip = read_rig(tmp_path / "b.glb"), read_clip(tmp_path / "b.glb")
    expected = face.pose(rolling.values, rolling.joints)
    assert np.abs(again.pose(clip.values, clip.joints) - expected).max() < 1e-6


def test_only_the_strongest_influences_are_kept_and_that_is_said(tmp_path):
    _, path = sheet_file(tmp_path / "a.glb")
    face = read_rig(path)
    rig = fitted(face)
    many = len(face.neutral.vertices)
    rest = np.repeat(rig.skeleton.rest, 3, axis=0)[:9]
    skeleton = replace(rig.skeleton, names=tuple(f"j{i}" for i in range(9)), parents=np.arange(9) - 1, rest=rest)
    weights = np.random.default_rng(3).random((many, 9))
    weights /= weights.sum(axis=1, keepdims=True)
    rig = replace(rig, skeleton=skeleton, skin=Skin(np.tile(np.arange(9), (many, 1)), weights, np.linalg.inv(rest)))
    for most, sets in ((4, 1), (8, 2)):
        (note,) = write_rigged(tmp_path / "b.glb", rig, influences=most)
        assert note.code == "influences-dropped"
        primitive = contents(tmp_path / "b.glb")[0]["meshes"][0]["primitives"][0]
        assert sum(name.startswith("JOINTS_") for name in primitive["attributes"]) == sets
        again = read_rig(tmp_path / "b.glb").skin
        assert np.abs(again.weights.sum(axis=1) - 1).max() < 1e-6
        strongest = -np.sort(-weights, axis=1)[:, :most]
        assert np.abs(again.weights - strongest / strongest.sum(axis=1, keepdims=True)).max() < 1e-6


def test_a_rig_bound_in_another_pose_is_bound_at_rest_and_that_is_said(tmp_path):
    _, path = sheet_file(tmp_path / "a.glb")
    rig = fitted(read_rig(path))
    bound = rig.skin.inverse_bind.copy()
    bound[1] = bound[1] @ matrix((0, 0.1, 0), turn(0, 0.4))
    (note,) = write_rigged(tmp_path / "b.glb", replace(rig, skin=replace(rig.skin, inverse_bind=bound)))
    assert note.code == "bound-at-rest"
    moves_alike(rig, read_rig(tmp_path / "b.glb"))


def test_a_rig_bound_in_a_space_of_its_own_is_written_exactly(tmp_path):
    _, path = sheet_file(tmp_path / "a.glb")
    rig = fitted(read_rig(path))
    own = matrix((3, 0, 1), turn(2, 0.5), (2, 2, 2))
    rig = replace(rig, skin=replace(rig.skin, inverse_bind=rig.skin.inverse_bind @ own))
    assert write_rigged(tmp_path / "b.glb", rig) == ()
    moves_alike(rig, read_rig(tmp_path / "b.glb"))


def test_what_cannot_be_written_is_refused(tmp_path):
    _, path = sheet_file(tmp_path / "a.glb")
    rig = fitted(read_rig(path))
    with pytest.raises(InputError, match="4 or 8"):
        write_rigged(tmp_path / "b.glb", rig, influences=5)
    other = replace(rig, neutral=replace(rig.neutral, vertices=rig.neutral.vertices + [0, 0.5, 0]))
    with pytest.raises(InputError, match=r"not the file that this rig was made for: vertex \d+"):
        write_rigged(tmp_path / "b.glb", other)
    parts = with_parts(rig)
    bare = replace(parts, neutral=replace(parts.neutral, triangles=rig.neutral.triangles))
    with pytest.raises(InputError, match="triangles of their own"):
        write_rigged(tmp_path / "b.glb", bare)
    with pytest.raises(InputError, match="2 joints"):
        write_rigged(
            tmp_path / "b.glb", rig, {"a": Clip((), np.zeros((1, 0)), 30, joints=np.tile(np.eye(4), (1, 2, 1, 1)))}
        )
    assert not (tmp_path / "b.glb").exists()


def test_a_face_without_a_gltf_file_becomes_a_new_one(tmp_path, faults):  # noqa: F811
    rig = with_parts(fitted(actor()))
    assert write_rigged(tmp_path / "b.glb", rig, {"act": played(rig)}) == ()
    again, clip = read_rig(tmp_path / "b.glb"), read_clip(tmp_path / "b.glb", "act")
    n = len(rig.neutral.vertices)
    expected = rig.pose(played(rig).values, played(rig).joints)
    assert np.abs(again.pose(clip.values, clip.joints)[:, :n] - expected).max() < 1e-6
    assert faults(tmp_path / "b.glb") == []


@pytest.mark.real
@pytest.mark.parametrize("name", ["adult_draco", "adult_meshopt", "adult_quantized", "adult_sparse", "../toon"])
def test_real_faces_take_a_rig(data, tmp_path, name, faults):  # noqa: F811
    if "draco" in name:
        pytest.importorskip("DracoPy")
    source = data / "rigs" / "variants" / f"{name}.glb"
    face = read_rig(source)
    rig = with_parts(fitted(face))
    assert write_rigged(tmp_path / "b.glb", rig, {"act": played(rig)}) == ()
    again = read_rig(tmp_path / "b.glb")
    assert np.abs(again.neutral.vertices[: len(face.neutral.vertices)] - face.neutral.vertices).max() < 1e-6
    moves_alike(rig, again)
    assert faults(tmp_path / "b.glb") == []
