"""Where the bones of a MakeHuman skeleton are and how their frames are turned.

A bone's frame has its head at the origin, its tail along +Y, and +X along the normal of
the plane the bone turns in, so that a bend is a turn about X.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import FileError, Skeleton
from mien.core.arrays import Floats
from mien.io.files import read_text

MOST_BONES = 4096
"""More bones than this no body has."""


def parsed(path: Path) -> dict[str, Any]:
    """Return the object that a JSON file holds.

    Raises:
        FileError: it holds none.
    """
    try:
        said = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path} is not valid JSON: {str(error).rstrip('.')}.") from None
    if not isinstance(said, dict):
        raise FileError(f"{path} is a {type(said).__name__}, not a MakeHuman file.")
    return said


def skeleton_of(path: Path, said: dict[str, Any], vertices: Floats) -> Skeleton:
    """Return the skeleton of a `.mhskel` file, parents first.

    Args:
        path: the file, for errors.
        said: its content.
        vertices: `(N, 3)` of the base mesh [m], which tell where the joints are.

    Raises:
        FileError: a bone's parent, joint or plane is missing.
    """
    bones = _parents_first(path, said.get("bones"))
    places = _Places(path, said, vertices)
    rest = np.tile(np.eye(4), (len(bones), 1, 1))
    for j, bone in enumerate(bones.values()):
        head, tail = places.joint(bone.get("head")), places.joint(bone.get("tail"))
        rest[j, :3, :3] = _frame(tail - head, places.normal(bone.get("rotation_plane")))
        rest[j, :3, 3] = head
    number = {name: j for j, name in enumerate(bones)}
    parents = np.array(
        [-1 if bone.get("parent") is None else number[bone["parent"]] for bone in bones.values()], dtype=np.int64
    )
    return Skeleton(tuple(bones), parents, rest)


def _parents_first(path: Path, bones: Any) -> dict[str, dict[str, Any]]:
    if not isinstance(bones, dict) or not bones or not all(isinstance(bone, dict) for bone in bones.values()):
        raise FileError(f"{path} describes no bones; it is no MakeHuman skeleton.")
    parents = [bone.get("parent") for bone in bones.values()]
    if len(bones) > MOST_BONES or not all(parent is None or isinstance(parent, str) for parent in parents):
        raise FileError(f"{path} must have at most {MOST_BONES} bones, each with the name of its parent or null.")
    ordered: dict[str, dict[str, Any]] = {}
    waiting = dict(bones)
    while waiting:
        ready = [name for name, bone in waiting.items() if bone.get("parent") is None or bone["parent"] in ordered]
        if not ready:
            first = next(iter(waiting))
            raise FileError(f"{path}: the parent {waiting[first]['parent']!r} of the bone {first!r} is missing.")
        ordered |= {name: waiting.pop(name) for name in ready}
    return ordered


class _Places:
    """Where joints are and how planes lie: both are told by vertices of the base mesh."""

    def __init__(self, path: Path, said: dict[str, Any], vertices: Floats) -> None:
        self._path = path
        self._joints, self._planes = said.get("joints"), said.get("planes")
        self._vertices = vertices

    def joint(self, name: Any) -> Floats:
        """Return the middle of a joint's vertices [m]."""
        ids = self._listed(self._joints, name, "joint")
        if not all(type(i) is int and 0 <= i < len(self._vertices) for i in ids):
            raise FileError(f"{self._path}: the joint {name!r} must list vertices among {len(self._vertices)}.")
        return np.asarray(self._vertices[ids].mean(axis=0))

    def normal(self, name: Any) -> Floats:
        """Return the normal of a plane through three joints, not of unit length."""
        a, b, c = (self.joint(joint) for joint in self._listed(self._planes, name, "plane")[:3])
        return np.cross(c - b, b - a)

    def _listed(self, table: Any, name: Any, what: str) -> list[Any]:
        listed = table.get(name) if isinstance(table, dict) and isinstance(name, str) else None
        if not isinstance(listed, list) or len(listed) < (3 if what == "plane" else 1):
            raise FileError(f"{self._path} does not say where the {what} {name!r} is.")
        return listed


def _frame(along: Floats, normal: Floats) -> Floats:
    """Return the rotation whose +Y is `along` and whose +X is nearest to `normal`."""
    length = np.linalg.norm(along)
    if not length:
        return np.eye(3)
    y = along / length
    x = normal - y * (normal @ y)
    if np.linalg.norm(x) <= 1e-9 * np.linalg.norm(normal) or not normal.any():
        x = np.cross(y, np.eye(3)[np.argmin(np.abs(y))])
    x = x / np.linalg.norm(x)
    return np.stack([x, y, np.cross(x, y)], axis=1)
