"""Characters that are driven by their bones: which are, by what parameters, and where the joints go."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Clip, Correspondence, InputError, Rig, Skeleton
from mien.core.arrays import Floats, Ints
from mien.core.errors import unknown
from mien.geometry.bones import Bones, parents_first
from mien.io.poses import read_poses
from mien.retargeting.bone_solver import on_bones
from mien.retargeting.bones import free_bones, with_bone_shapes
from mien.retargeting.copying import held
from mien.retargeting.shape_retargeter import ShapeRetargeter
from mien.vocabularies.joints import head_of

TARGETS = ("shapes", "bones")
POSED: dict[str, Any] = {"prior": 0.3}
FREE: dict[str, Any] = {"prior": 2.0, "damping": 0.01, "bounds": (-1.0, 1.0)}
"""Parameters of the solve for named poses and for free bones: the more freedom, the more a smooth skin must count."""


@dataclass(frozen=True, eq=False)
class Driven:
    """A character, and what of it is driven.

    Attributes:
        rig: the character.
        bones: the parameters of its bones; None if its blendshapes are driven, or `free` and not yet paired.
        free: whether each facial bone is a parameter of its own, because nobody gave named poses.
    """

    rig: Rig
    bones: Bones | None = None
    free: bool = False

    @cached_property
    def shown(self) -> Rig:
        """The character as a method sees it: a blendshape for each parameter."""
        return self.rig if self.bones is None else with_bone_shapes(self.rig, self.bones)

    def paired(self, pairs: Correspondence) -> Driven:
        """Return the character once its paired points are known, which tell free bones of the face from others."""
        return replace(self, bones=free_bones(self.rig, pairs)) if self.free else self

    def settings(self, given: dict[str, Any], known: Iterable[str]) -> dict[str, Any]:
        """Return the parameters of a method that knows some: what suits bones, unless something else is given."""
        if self.bones is None or "preset" in given:
            return given
        suited = FREE if self.free else POSED
        return {**{name: value for name, value in suited.items() if name in known}, **given}

    def solved(self, retargeter: Any, pairs: Correspondence | None) -> Any:
        """Return a fitted method that solves for what the bones really do, if it solves for points."""
        if self.bones is None or pairs is None or not isinstance(retargeter, ShapeRetargeter):
            return retargeter
        return on_bones(retargeter, self.rig, pairs, self.bones)


def driven(rig: Rig, targets: str | None, poses: Path | None) -> Driven:
    """Return a character with what of it is to be driven.

    It is its bones if that is asked for, if poses are given, or if it has joints and no blendshapes.

    Args:
        rig: the character.
        targets: `shapes`, `bones`, or None to decide so.
        poses: a file of named poses of its bones.

    Raises:
        FileError: the poses cannot be read.
        InputError: an unknown target, poses for shapes or of another skeleton, or a character without bones.
    """
    if targets is not None and targets not in TARGETS:
        raise InputError(unknown("target", targets, TARGETS))
    if targets == "shapes" and poses is not None:
        raise InputError(f"{poses} holds poses of bones, but the targets are shapes; leave out one of the two.")
    wanted = targets == "bones" or poses is not None
    if wanted and rig.skeleton is None:
        raise InputError(f"{rig.name} has no bones (a skin with joints) to drive; export it with its skin.")
    if rig.skeleton is None or targets == "shapes" or (len(rig.blendshapes) and not wanted):
        return Driven(rig)
    if poses is None:
        return Driven(rig, free=True)
    return Driven(rig, read_poses(poses, rig.skeleton))


def packed_bones(bones: Bones) -> tuple[dict[str, Any], dict[str, Floats]]:
    """Return what a saved model keeps of bones: a header of plain values, and arrays."""
    header = {"bones": bones.names, "joints": bones.skeleton.names, "two_sided": bones.two_sided}
    return header, {"bone_turns": bones.turns, "bone_moves": bones.moves}


def unpacked_bones(header: Mapping[str, Any], arrays: Mapping[str, Any], rig: Rig | None) -> Bones | None:
    """Return the bones that a saved model drives, None if it drives none.

    Raises:
        InputError: the character's joints are others.
    """
    if "bones" not in header:
        return None
    if rig is None or rig.skeleton is None or rig.skeleton.names != tuple(header["joints"]):
        name = "the character" if rig is None else rig.name
        raise InputError(f"it drives {len(header['joints'])} joints that are not those of {name}; fit it again.")
    turns, moves = arrays["bone_turns"], arrays["bone_moves"]
    return Bones(tuple(header["bones"]), rig.skeleton, turns, moves, header["two_sided"] is True)


def with_joints(clip: Clip, bones: Bones) -> Clip:
    """Return a clip of parameters with the joints where they put them, and the head where its motion is."""
    joints = bones.world(held(clip.channels(bones.names))[0])
    return replace(clip, joints=with_head(joints, clip.head, bones.skeleton))


def with_head(joints: Floats, head: Floats | None, skeleton: Skeleton) -> Floats:
    """Return joints `(F, J, 4, 4)` with the head's motion on the head joint and all below it; on all if none is named."""
    if head is None:
        return joints
    moved = joints.copy()
    rows = _below(skeleton, head_of(skeleton.names))
    moved[:, rows] = head[:, None] @ joints[:, rows]
    return moved


def _below(skeleton: Skeleton, top: int | None) -> Ints:
    if top is None:
        return np.arange(len(skeleton.names))
    inside = np.zeros(len(skeleton.names), dtype=bool)
    for j in parents_first(skeleton.parents):
        inside[j] = j == top or (skeleton.parents[j] >= 0 and inside[skeleton.parents[j]])
    return np.flatnonzero(inside)
