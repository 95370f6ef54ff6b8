"""MakeHuman skeletons: a small made-up one read back number by number, and the real one posed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mien.core import FileError
from mien.io import formats
from mien.io.bvh import read_motion
from mien.io.makehuman import read_pose_units, read_rig
from tests.io.hostile import survives

BASE = """v 0 0 0
v 1 0 0
v 0 2 0
v 1 2 0
v 0 4 0
v 9 9 9
v 8 9 9
v 9 8 9
g body
f 1 2 4 3
f 3 4 5
g joint-cube
f 6 7 8
"""
BONES = {
    "tip": {"head": "b", "tail": "c", "parent": "low", "rotation_plane": "p"},
    "low": {"head": "a", "tail": "b", "parent": None, "rotation_plane": "p"},
}
SKELETON = {
    "bones": BONES,
    "joints": {"a": [0, 1], "b": [2, 3], "c": [4], "d": [5]},
    "planes": {"p": ["a", "c", "d"]},
    "weights_file": "w.mhw",
}
WEIGHTS = {"weights": {"low": [[0, 1], [1, 1], [2, 0.5], [5, 1]], "tip": [[2, 0.5], [3, 1.5], [4, 1]]}}
MOTION = """HIERARCHY
ROOT low
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Xrotation Yrotation Zrotation
  JOINT tip
  {
    OFFSET 0 0 2
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 0 1
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.04
0 0 0 0 0 0 0 0 0
0 0 0 90 0 0 0 0 0
0 0 0 0 0 30 90 90 0
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "base.obj").write_text(BASE)
    (tmp_path / "small.mhskel").write_text(json.dumps(SKELETON))
    (tmp_path / "w.mhw").write_text(json.dumps(WEIGHTS))
    (tmp_path / "units.json").write_text(json.dumps({"framemapping": ["Rest", "nod", "both"]}))
    (tmp_path / "units.bvh").write_text(MOTION)
    return tmp_path


def test_bones_run_along_y_and_bend_about_the_normal_of_their_plane(folder: Path) -> None:
    rig = read_rig(folder)
    assert rig.skeleton.names == ("low", "tip")
    assert rig.skeleton.parents.tolist() == [-1, 0]
    places = {
        name: np.mean(np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [1, 2, 0], [0, 4, 0], [9, 9, 9]])[ids], axis=0)
        for name, ids in SKELETON["joints"].items()
    }
    normal = np.cross(places["c"] - places["a"], places["d"] - places["c"])
    for rest, (head, tail) in zip(rig.skeleton.rest, [("a", "b"), ("b", "c")], strict=True):
        assert np.allclose(rest[:3, 3], 0.1 * places[head])
        assert np.allclose(rest[:3, :3].T @ rest[:3, :3], np.eye(3))
        assert np.linalg.det(rest) == pytest.approx(1)
        along = places[tail] - places[head]
        assert np.allclose(rest[:3, 1], along / np.linalg.norm(along))
        assert abs(rest[:3, 2] @ normal) < 1e-9 * np.linalg.norm(normal)


def test_what_is_no_part_of_a_body_is_left_out_and_weights_are_made_to_sum_to_one(folder: Path) -> None:
    rig = read_rig(folder / "small.mhskel")
    assert rig.neutral.vertices.tolist() == [[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0.1, 0.2, 0], [0, 0.4, 0]]
    assert {name: ids.tolist() for name, ids in rig.neutral.groups.items()} == {"body": [0, 1, 2, 3, 4]}
    assert np.allclose(rig.skin.weights.sum(axis=1), 1)
    assert [note.code for note in rig.notes] == ["skin-weights", "unskinned"]
    assert np.allclose(rig.pose(np.zeros(0), rig.skeleton.rest), rig.neutral.vertices)


def test_only_what_hangs_below_a_joint_can_be_read(folder: Path) -> None:
    rig = read_rig(folder, below="tip")
    assert np.array_equal(rig.neutral.vertices, [[0, 0.2, 0], [0.1, 0.2, 0], [0, 0.4, 0]])
    assert rig.skeleton.names == ("low", "tip")
    with pytest.raises(FileError, match="unknown joint 'tap'"):
        read_rig(folder, below="tap")


def test_rotations_apply_in_the_order_of_their_channels(folder: Path) -> None:
    motion = read_motion(folder / "units.bvh")
    assert motion.fps == pytest.approx(25)
    assert (motion.names, motion.parents) == (("low", "tip"), (-1, 0))
    turned = motion.rotations[2, 1] @ [0, 1, 0]  # about Z after X: up by X to +Z, which Z leaves
    assert np.allclose(turned, [0, 0, 1])
    assert np.allclose(motion.rotations[2, 1] @ [1, 0, 0], [0, 1, 0])


def test_a_pose_turns_everything_below_a_joint_about_its_head(folder: Path) -> None:
    rig = read_rig(folder)
    poses = read_pose_units(folder / "units.json", rig.skeleton)
    assert list(poses) == ["nod", "both"]
    posed = rig.pose(np.zeros(0), poses["nod"])  # about +X, which Blender and we share: +Y goes to +Z
    centre = np.array([0.05, 0, 0])
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    assert np.allclose(posed, (rig.neutral.vertices - centre) @ turn.T + centre)
    low, tip = poses["both"]
    assert np.allclose(np.linalg.solve(low, tip)[:3, 3], np.linalg.solve(*rig.skeleton.rest)[:3, 3])


@pytest.mark.parametrize("name", ["small.mhskel", "w.mhw", "base.obj"])
def test_damaged_files_only_ever_give_an_error_of_ours(folder: Path, name: str, rng) -> None:
    def read(_: Path) -> object:
        return read_rig(folder)

    survives(read, folder / name, rng)


@pytest.mark.parametrize("name", ["units.json", "units.bvh"])
def test_damaged_poses_only_ever_give_an_error_of_ours(folder: Path, name: str, rng) -> None:
    skeleton = read_rig(folder).skeleton
    survives(lambda _: read_pose_units(folder / "units.json", skeleton), folder / name, rng)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"bones": {}}, "no bones"),
        ({"bones": {"a": {**BONES["low"], "parent": "b"}}}, "parent 'b' of the bone 'a' is missing"),
        ({"bones": {"a": {**BONES["low"], "parent": ["b"]}}}, "name of its parent"),
        ({"joints": {}}, "joint 'a'"),
        ({"joints": {**SKELETON["joints"], "a": [99]}}, "vertices among 8"),
        ({"planes": {"p": ["a", "b"]}}, "plane 'p'"),
        ({"weights_file": "../../gone.mhw"}, "gone.mhw does not exist"),
    ],
)
def test_what_is_missing_is_named(folder: Path, change: dict, said: str) -> None:
    (folder / "small.mhskel").write_text(json.dumps({**SKELETON, **change}))
    with pytest.raises(FileError, match=said):
        read_rig(folder)


@pytest.mark.real
def test_the_real_face_closes_its_eyes_and_drops_its_jaw(data: Path) -> None:
    rig = formats.read_rig(data / "bones" / "default.mhskel")
    assert len(rig.skeleton.names) == 163
    assert 1.6 < np.ptp(rig.neutral.vertices[:, 1]) < 1.8
    poses = read_pose_units(data / "bones" / "face-poseunits.json", rig.skeleton)
    assert len(poses) == 59
    still = rig.neutral.vertices
    for name, side in (("LeftUpperLidClosed", 1), ("RightUpperLidClosed", -1)):
        moves = rig.pose(np.zeros(0), poses[name]) - still
        far = np.linalg.norm(moves, axis=1) > 0.003
        assert (side * still[far, 0] > 0).all()
        assert moves[far, 1].mean() < -0.003
    dropped = rig.pose(np.zeros(0), poses["JawDrop"]) - still
    lowest = dropped[:, 1].argmin()
    assert -0.05 < dropped[lowest, 1] < -0.02
    assert abs(still[lowest, 0]) < 0.03
    assert np.abs(dropped[still[:, 1] < still[lowest, 1] - 0.2]).max() < 1e-4
