"""Named poses of a skeleton, as parameters of a character with joints of the same names."""

from __future__ import annotations

from pathlib import Path

from mien.core import FileError, Skeleton
from mien.geometry.bones import Bones
from mien.io import gltf, makehuman


def read_poses(path: Path, skeleton: Skeleton) -> Bones:
    """Read poses: the animations of a .glb or .gltf, or a .json that names the frames of the .bvh beside it.

    Args:
        path: the file.
        skeleton: the character's joints, known by their names.

    Raises:
        FileError: the file is missing, damaged, of another kind, or its poses move nothing.
        InputError: the character lacks a joint that is posed.
    """
    suffix = path.suffix.lower()
    if suffix == ".json":
        bones = Bones.of_poses(skeleton, makehuman.read_pose_units(path, skeleton))
    elif suffix in {".glb", ".gltf"}:
        bones = Bones.of_poses(*gltf.read_poses(path)).on(skeleton)
    else:
        raise FileError(
            f"{path}: poses are read from a .glb or .gltf, one animation each, or from a .json that names the frames of "
            "the .bvh beside it."
        )
    if not len(bones.moved):
        raise FileError(f"none of the {len(bones.names)} poses of {path} moves a joint.")
    return bones
