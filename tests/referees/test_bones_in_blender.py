"""Blender plays the bones of a retargeted face as mien poses them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Clip
from mien.geometry.bones import Bones
from mien.io import makehuman
from mien.io.gltf import read_rig, write_clip, write_rig
from tests.referees.test_blender import blender, same  # noqa: F401
from tests.retargeting.bone_face import bone_face, bones


def played_in_blender(blender, path, rig, known) -> None:  # noqa: F811
    """Write a face, then a clip of its bones into the face's own file; Blender must pose it as the rig does."""
    write_rig(path, rig)
    own = read_rig(path)
    values = np.random.default_rng(3).uniform(0, 0.7, (3, len(known.names)))
    joints = known.world(values)
    out = path.with_name("played.glb")
    write_clip(out, Clip(known.names, values, 30.0, joints=joints), own)
    _, arrays = blender(out, frames=[0, 2])
    for at in (0, 2):
        same(arrays, f"frame {at}", own, own.pose(np.zeros(0), joints[at]))


def test_a_small_face_of_bones_moves_the_same(blender, tmp_path):  # noqa: F811
    played_in_blender(blender, tmp_path / "face.glb", bone_face(), bones())


@pytest.mark.real
def test_makehumans_face_moves_the_same(blender, data, tmp_path):  # noqa: F811
    rig = makehuman.read_rig(data / "bones", below="neck01")
    poses = makehuman.read_pose_units(data / "bones" / "face-poseunits.json", rig.skeleton)
    played_in_blender(blender, tmp_path / "face.glb", replace(rig, name="face"), Bones.of_poses(rig.skeleton, poses))
