"""Writing glTF: what was there stays, what is added reads back, and the Khronos validator agrees."""

from __future__ import annotations

import copy
import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.core import Clip, InputError, Mesh, Rig, Skeleton, Skin
from mien.io.gltf import read_clip, read_rig, write_clip, write_rig
from tests.conftest import grid_rig
from tests.io.gltf_samples import SQUARE, Sample, contents, matrix, skinned, turn

TOOLS = Path(__file__).parents[1] / "tools"


@pytest.fixture(scope="module")
def faults():
    """Return the validator's errors about files, as `(file name, code, message)`."""
    node = shutil.which("node")
    if node is None or not (TOOLS / "node_modules" / "gltf-validator").is_dir():
        pytest.skip("the Khronos validator is not installed: npm install --no-package-lock in tests/tools")

    def validated(*paths: Path) -> list[tuple[str, str, str]]:
        command = [node, str(TOOLS / "validate_gltf.mjs"), *map(str, paths)]
        reports = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        assert len(reports) == len(paths)
        pairs = zip(paths, reports, strict=True)
        return [(path.name, m["code"], m["message"]) for path, found in pairs for m in found if m["severity"] == 0]

    return validated


def nod(count: int) -> np.ndarray:
    motion = np.tile(np.eye(4), (count, 1, 1))
    turns = np.linspace(0, 7, count)[:, None] * [0.3, 1, 0.2]
    motion[:, :3, :3] = Rotation.from_rotvec(turns).as_matrix()
    motion[:, :3, 3] = 0.1 * np.sin(turns)
    return motion


def played(rig: Rig, rng, count: int = 40, **more) -> Clip:
    return Clip(rig.blendshapes.names, rng.random((count, len(rig.blendshapes))), 30.0, **more)


def seamed_rig() -> Rig:
    """A rig whose texture is cut at every seventh triangle."""
    rig = grid_rig()
    uv = rig.neutral.vertices[rig.neutral.triangles][..., :2].copy()
    uv[::7] += 1
    return replace(rig, neutral=Mesh(rig.neutral.vertices, rig.neutral.triangles, uv))


def test_a_rig_written_and_read_is_the_same_to_single_precision(tmp_path):
    rig = grid_rig()
    write_rig(tmp_path / "a.glb", rig)
    again = read_rig(tmp_path / "a.glb")
    assert again.blendshapes.names == rig.blendshapes.names
    assert np.array_equal(again.neutral.triangles, rig.neutral.triangles)
    assert np.array_equal(again.neutral.vertices, np.float32(rig.neutral.vertices))
    assert np.array_equal(again.blendshapes.deltas, np.float32(rig.blendshapes.deltas))


def test_texture_seams_add_vertices_behind_the_others(tmp_path):
    rig = seamed_rig()
    write_rig(tmp_path / "a.glb", rig)
    again = read_rig(tmp_path / "a.glb")
    n = len(rig.neutral.vertices)
    assert len(again.neutral.vertices) > n
    assert np.array_equal(again.neutral.vertices[:n], np.float32(rig.neutral.vertices))
    assert np.array_equal(again.neutral.uv, np.float32(rig.neutral.uv))
    corners = rig.neutral.vertices[rig.neutral.triangles]
    assert np.array_equal(again.neutral.vertices[again.neutral.triangles], np.float32(corners))


def test_a_skinned_rig_written_anew_poses_the_same(tmp_path, rng):
    source = read_rig(skinned().save(tmp_path / "a.glb"))
    clip = read_clip(tmp_path / "a.glb")
    write_clip(tmp_path / "b.glb", clip, replace(source, source=None))
    again, replayed = read_rig(tmp_path / "b.glb"), read_clip(tmp_path / "b.glb")
    assert again.skeleton.names == source.skeleton.names
    assert np.array_equal(again.skeleton.parents, source.skeleton.parents)
    expected = source.pose(clip.values, clip.joints)
    assert np.abs(again.pose(replayed.values, replayed.joints) - expected).max() < 1e-5


def test_a_joint_named_twice_by_a_vertex_is_written_once(tmp_path, rng, faults):
    rig = grid_rig()
    n = len(rig.neutral.vertices)
    weights = rng.random((n, 5))
    weights /= weights.sum(1, keepdims=True)
    skeleton = Skeleton(("root", "tip"), np.array([-1, 0]), np.stack([matrix(), matrix((0, 1, 0), turn(0, 0.5))]))
    skin = Skin(rng.integers(0, 2, (n, 5)), weights, np.stack([matrix((1, 0, 0)), matrix(scale=(2, 2, 2))]))
    rig = replace(rig, skeleton=skeleton, skin=skin)
    write_rig(tmp_path / "a.glb", rig)
    assert faults(tmp_path / "a.glb") == []
    posed = np.stack([matrix((0, 0, 1)), matrix((0, 1, 0), turn(1, 1))])
    again = read_rig(tmp_path / "a.glb").pose(np.ones(3), posed)
    assert np.abs(again - rig.pose(np.ones(3), posed)).max() < 1e-5


def test_coloured_groups_become_materials_and_vertices_keep_their_order(tmp_path, faults):
    rig = seamed_rig()
    ids = np.arange(len(rig.neutral.vertices))
    groups = {"all": ids, "low": ids[: len(ids) // 2], "none": ids[:1]}
    rig = replace(rig, neutral=replace(rig.neutral, groups=groups))
    colours = {"low": (0.5, 0.2, 0.1), "none": (0.0, 0.0, 0.0)}
    write_rig(tmp_path / "a.glb", rig, colours=colours)
    write_rig(tmp_path / "b.glb", rig)
    again, plain = read_rig(tmp_path / "a.glb"), read_rig(tmp_path / "b.glb")
    assert np.array_equal(again.neutral.vertices, plain.neutral.vertices)
    assert np.array_equal(again.blendshapes.deltas, plain.blendshapes.deltas)
    assert sorted(map(tuple, again.neutral.triangles)) == sorted(map(tuple, plain.neutral.triangles))
    root, _ = contents(tmp_path / "a.glb")
    looks = {m["name"]: m["pbrMetallicRoughness"]["baseColorFactor"] for m in root["materials"]}
    assert list(looks) == ["skin", "low"]
    assert looks["low"] == [0.5, 0.2, 0.1, 1.0]
    painted = next(found for name, found in again.neutral.groups.items() if name.endswith("/low"))
    assert set(painted[painted < len(ids)]) <= set(groups["low"])
    assert faults(tmp_path / "a.glb") == []


def test_shapes_are_stored_sparsely_and_empty_ones_not_at_all(tmp_path):
    rig = grid_rig(20)
    deltas = rig.blendshapes.deltas.copy()
    deltas[0], deltas[1, 5:] = 0, 0
    write_rig(tmp_path / "a.glb", replace(rig, blendshapes=replace(rig.blendshapes, deltas=deltas)))
    root, _ = contents(tmp_path / "a.glb")
    targets = [root["accessors"][t["POSITION"]] for t in root["meshes"][0]["primitives"][0]["targets"]]
    assert ["sparse" in t for t in targets] == [False, True, False]
    assert ["bufferView" in t for t in targets] == [False, False, True]
    assert np.array_equal(read_rig(tmp_path / "a.glb").blendshapes.deltas, np.float32(deltas))


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_a_clip_written_into_its_character_reads_back(tmp_path, rng, suffix):
    rig = read_rig(skinned(animated=False).save(tmp_path / "a.glb"))
    clip = played(rig, rng)
    out = tmp_path / f"b{suffix}"
    write_clip(out, clip, rig)
    again = read_clip(out)
    assert again.fps == clip.fps
    assert again.names == clip.names
    assert np.array_equal(again.values, np.float32(clip.values))
    assert np.abs(again.joints - rig.skeleton.rest).max() < 1e-12


def test_everything_the_file_had_is_still_there(tmp_path, rng):
    s = skinned()
    s.root["extensionsUsed"] = ["ACME_hair"]
    s.root["extensions"] = {"ACME_hair": {"strands": [1, 2.5, {"deep": None}]}}
    s.root["extras"] = {"note": "ünïcode \u2028", "number": 0.1}
    s.root["nodes"][0]["extras"] = [1, "two"]
    s.root["materials"] = [{"name": "skin", "extensions": {"ACME_hair": True}}]
    s.root["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}]
    before, data = contents(s.save(tmp_path / "a.glb"))
    write_clip(tmp_path / "b.glb", played(read_rig(tmp_path / "a.glb"), rng), read_rig(tmp_path / "a.glb"))
    after, longer = contents(tmp_path / "b.glb")
    assert longer.startswith(data)
    added = copy.deepcopy(after)
    ours = added["animations"].pop(0)
    assert ours["name"] == "mien"
    for kind in ("accessors", "bufferViews"):
        added[kind] = added[kind][: len(before[kind])]
    added["buffers"][0]["byteLength"] = before["buffers"][0]["byteLength"]
    assert added == before


def test_absent_channels_are_zero_and_lost_frames_hold_the_last_one(tmp_path):
    rig = read_rig(skinned(animated=False).save(tmp_path / "a.glb"))
    values = np.array([[np.nan], [0.5], [np.nan], [0.25], [np.nan]])
    write_clip(tmp_path / "b.glb", Clip(("smile",), values, 30), rig)
    again = read_clip(tmp_path / "b.glb")
    assert again.names == ("jawOpen", "smile")
    assert np.array_equal(again.values, [[0, 0.5], [0, 0.5], [0, 0.5], [0, 0.25], [0, 0.25]])


def test_the_head_moves_by_its_joint_rigidly_in_the_world(tmp_path, rng):
    rig = read_rig(skinned(animated=False).save(tmp_path / "a.glb"))
    head = nod(50)
    write_clip(tmp_path / "b.glb", played(rig, rng, 50, head=head), rig)
    root, _ = contents(tmp_path / "b.glb")
    assert len(root["nodes"]) == 5
    assert "matrix" not in root["nodes"][2]
    clip = read_clip(tmp_path / "b.glb")
    at = clip.joints[:, rig.skeleton.names.index("mixamorig:Head")]
    assert np.abs(at - head @ rig.skeleton.rest[1]).max() < 1e-6
    channel = next(c for c in root["animations"][0]["channels"] if c["target"]["path"] == "rotation")
    accessor = root["accessors"][root["animations"][0]["samplers"][channel["sampler"]]["output"]]
    _, data = contents(tmp_path / "b.glb")
    q = np.frombuffer(data, "<f4", 200, root["bufferViews"][accessor["bufferView"]]["byteOffset"]).reshape(50, 4)
    assert ((q[1:] * q[:-1]).sum(1) > 0).all()


def test_a_character_without_joints_moves_as_a_whole_under_a_new_node(tmp_path, rng):
    s = Sample()
    s.mesh(s.primitive(deltas=[SQUARE]), shapes=["a"])
    s.node(mesh=0, translation=[0, 1, 0])
    s.node(name="lamp")
    rig = read_rig(s.save(tmp_path / "a.glb"))
    head = nod(50)
    write_clip(tmp_path / "b.glb", played(rig, rng, 50, head=head), rig)
    root, _ = contents(tmp_path / "b.glb")
    assert root["scenes"][0]["nodes"] == [2]
    assert root["nodes"][2] == {"name": "mien_head", "children": [0, 1]}
    moved, clip = read_rig(tmp_path / "b.glb"), read_clip(tmp_path / "b.glb")
    expected = rig.pose(clip.values) @ head[:, :3, :3].swapaxes(1, 2) + head[:, None, :3, 3]
    assert np.abs(moved.pose(clip.values, clip.joints) - expected).max() < 1e-6
    write_clip(tmp_path / "c.glb", played(rig, rng, 50, head=head), moved)
    again, _ = contents(tmp_path / "c.glb")
    assert len(again["nodes"]) == 3
    assert [animation["name"] for animation in again["animations"]] == ["mien_2", "mien"]


@pytest.mark.parametrize(
    ("names", "best"),
    [
        (["hips", "HeadTop_End", "Head"], 2),
        (["forehead", "CC_Base_Head", "headFront"], 1),
        (["head.x", "mixamorig:Head_End", "Armature|head_05"], 2),
        (["neck", "jaw", "lid"], None),
    ],
)
def test_the_joint_named_most_like_a_head_is_chosen(tmp_path, names, best, rng):
    s = skinned(animated=False)
    first = len(s.root["nodes"])
    s.root["skins"] = [{"joints": [first + i for i in range(3)]}]
    for name in names:
        s.node(name=name)
    rig = read_rig(s.save(tmp_path / "a.glb"))
    write_clip(tmp_path / "b.glb", played(rig, rng, head=nod(40)), rig)
    root, _ = contents(tmp_path / "b.glb")
    moved = {c["target"]["node"] for c in root["animations"][0]["channels"] if c["target"]["path"] == "rotation"}
    assert moved == {first + 3 if best is None else first + best}


def test_the_joints_of_a_clip_are_written_too(tmp_path):
    rig = read_rig(skinned().save(tmp_path / "a.glb"))
    clip = read_clip(tmp_path / "a.glb")
    write_clip(tmp_path / "b.glb", clip, rig)
    assert np.abs(read_clip(tmp_path / "b.glb").joints - clip.joints).max() < 1e-5


def test_buffers_and_images_beside_the_file_are_packed_into_it(tmp_path, rng):
    s = skinned(animated=False)
    expected = read_rig(s.save(tmp_path / "a.glb"))
    half = s.root["bufferViews"][0]["byteLength"]
    (tmp_path / "one.bin").write_bytes(s.binary[:half])
    (tmp_path / "two.bin").write_bytes(b"??" + s.binary[half:])
    (tmp_path / "skin.png").write_bytes(b"\x89PNG not really")
    s.root["buffers"] = [
        {"uri": "one.bin", "byteLength": half},
        {"uri": "two.bin", "byteLength": 2 + len(s.binary) - half},
    ]
    for view in s.root["bufferViews"][1:]:
        view["buffer"], view["byteOffset"] = 1, view["byteOffset"] - half + 2
    s.root["images"] = [{"uri": "skin.png"}, {"uri": "gone.png"}]
    (tmp_path / "a.gltf").write_text(json.dumps(s.root))
    rig = read_rig(tmp_path / "a.gltf")
    write_clip(tmp_path / "b.glb", played(rig, rng), rig)
    root, data = contents(tmp_path / "b.glb")
    assert len(root["buffers"]) == 1
    view = root["bufferViews"][root["images"][0]["bufferView"]]
    assert data[view["byteOffset"] :][: view["byteLength"]] == b"\x89PNG not really"
    assert root["images"][1] == {"uri": "gone.png"}
    assert np.array_equal(read_rig(tmp_path / "b.glb").neutral.vertices, expected.neutral.vertices)


def test_writing_without_a_character_frames_or_anything_to_move_is_refused(tmp_path):
    rig = grid_rig()
    with pytest.raises(InputError, match="character"):
        write_clip(tmp_path / "a.glb", Clip(("a",), np.zeros((1, 1)), 30), None)
    with pytest.raises(InputError, match="no frames"):
        write_clip(tmp_path / "a.glb", Clip(("a",), np.zeros((0, 1)), 30), rig)
    bare = grid_rig(shapes=())
    with pytest.raises(InputError, match="no blendshapes"):
        write_clip(tmp_path / "a.glb", Clip((), np.zeros((3, 0)), 30), bare)
    with pytest.raises(InputError, match="triangles"):
        write_rig(tmp_path / "a.glb", rig.only(np.arange(3)))
    assert list(tmp_path.iterdir()) == []


def test_the_validator_finds_no_errors_in_what_is_written(tmp_path, rng, faults):
    arm = read_rig(skinned(animated=False).save(tmp_path / "a.glb"))
    moving = read_rig(skinned().save(tmp_path / "b.glb"))
    write_clip(tmp_path / "1.glb", played(arm, rng, head=nod(40)), arm)
    write_clip(tmp_path / "2.gltf", played(arm, rng, head=nod(40)), arm)
    write_clip(tmp_path / "3.glb", read_clip(tmp_path / "b.glb"), moving)
    write_clip(tmp_path / "4.glb", read_clip(tmp_path / "b.glb"), replace(moving, source=None))
    write_clip(tmp_path / "5.glb", played(grid_rig(), rng, head=nod(40)), grid_rig())
    write_rig(tmp_path / "6.gltf", seamed_rig(), played(seamed_rig(), rng))
    assert faults(*(tmp_path / name for name in ("1.glb", "2.gltf", "3.glb", "4.glb", "5.glb", "6.gltf"))) == []


@pytest.mark.real
def test_real_characters_play_a_clip_without_validator_errors(data, tmp_path, rng, faults):
    written = []
    for source in [*data.glob("rigs/variants/*.glb"), data / "rigs" / "toon.glb"]:
        if "draco" in source.stem:
            pytest.importorskip("DracoPy")
        rig = read_rig(source)
        clip = played(rig, rng, head=nod(40))
        for out in (tmp_path / source.name, tmp_path / f"fresh_{source.name}"):
            write_clip(out, clip, replace(rig, source=None) if "fresh" in out.name else rig)
            assert np.array_equal(read_clip(out).values, np.float32(clip.values))
            assert np.abs(read_rig(out).neutral.vertices - rig.neutral.vertices).max() < 1e-7
            written.append(out)
    assert faults(*written) == []
