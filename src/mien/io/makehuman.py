"""MakeHuman's bone rigs: a `.mhskel` skeleton, the `.mhw` weights it names, the base mesh, and face poses.

The base mesh is in decimetres, +Y up.  The cubes that mark its joints and the shells that
clothes are fitted to are left out; eyes, teeth, tongue and lashes are kept as groups.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mien.core import FileError, Mesh, Note, Rig, Skeleton, Skin
from mien.core.arrays import Flags, Floats, Ints
from mien.core.errors import unknown
from mien.core.rig import no_blendshapes
from mien.io import bvh, obj
from mien.io.makehuman_skeleton import parsed, skeleton_of

DECIMETRE = 0.1
BASE = "base.obj"
PARTS = {
    "body": "body",
    "helper-l-eye": "eye_left",
    "helper-r-eye": "eye_right",
    "helper-upper-teeth": "teeth_upper",
    "helper-lower-teeth": "teeth_lower",
    "helper-tongue": "tongue",
    "helper-l-eyelashes-1": "lashes_left_1",
    "helper-l-eyelashes-2": "lashes_left_2",
    "helper-r-eyelashes-1": "lashes_right_1",
    "helper-r-eyelashes-2": "lashes_right_2",
}
"""The groups of the base mesh that are a body, and what they are called here."""

OFF = 0.005
"""Sums of weights further from 1 than this are worth a note."""


def read_rig(path: Path, below: str | None = None) -> Rig:
    """Read a skeleton with the base mesh and weights beside it.

    Args:
        path: a `.mhskel` file, or a folder that holds one.
        below: keep only what hangs for the most part on this joint and those below it, e.g. `head`.

    Raises:
        FileError: a file is missing or damaged, or there is no such joint.
    """
    file = _skeleton_file(path)
    said = parsed(file)
    base = obj.read_mesh(file.parent / BASE, DECIMETRE)
    skeleton = skeleton_of(file, said, base.vertices)
    weights_file = file.parent / Path(str(said.get("weights_file", "default_weights.mhw"))).name
    dense, notes = _weights(weights_file, skeleton.names, len(base.vertices))
    kept = np.zeros(len(base.vertices), bool)
    kept[[i for part in PARTS for i in base.groups.get(part, ())]] = True
    if below is not None:
        kept &= dense[:, _descendants(file, skeleton, below)].sum(axis=1) >= 0.5
    mesh, rows = _only(file, base, kept)
    skin = _skin(dense[rows], np.asarray(np.linalg.inv(skeleton.rest), np.float64))
    shapes = no_blendshapes(len(rows))
    return Rig(mesh, shapes, skeleton, skin, name=file.stem, source=file, notes=tuple(notes))


def read_pose_units(path: Path, skeleton: Skeleton) -> dict[str, Floats]:
    """Read named face poses: a `.json` that names the frames of the `.bvh` beside it.

    Args:
        path: the `.json`, e.g. `face-poseunits.json`.
        skeleton: the joints that are posed, as `read_rig` gives them.

    Returns:
        Per pose `(J, 4, 4)` world matrices of the joints; frames called `Rest` are left out.

    Raises:
        FileError: a file is missing or damaged, or poses joints that the skeleton does not have.
    """
    names = parsed(path).get("framemapping")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise FileError(f"{path} names no poses: it needs a list of texts as 'framemapping'.")
    motion = bvh.read_motion(path.with_suffix(".bvh"))
    strange = next((name for name in motion.names if name not in skeleton.names), None)
    if strange is not None:
        raise FileError(f"{path.with_suffix('.bvh')}: {unknown('joint', strange, skeleton.names)}")
    if len(names) != len(motion.rotations) or len(set(names)) < len(names):
        raise FileError(f"{path} names {len(set(names))} poses, but {len(motion.rotations)} frames are there.")
    return {name: _posed(skeleton, motion, frame) for frame, name in enumerate(names) if name.lower() != "rest"}


def _posed(skeleton: Skeleton, motion: bvh.Motion, frame: int) -> Floats:
    """Return the joints' world matrices; the file's axes are Blender's (+Z up, face towards -Y)."""
    to_world = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    turns = dict(zip(motion.names, to_world @ motion.rotations[frame] @ to_world.T, strict=True))
    moved = np.tile(np.eye(4), (len(skeleton.names), 1, 1))
    for j, (name, parent) in enumerate(zip(skeleton.names, skeleton.parents, strict=True)):  # parents come first
        own, pivot = np.eye(4), skeleton.rest[j, :3, 3]
        own[:3, :3] = turns.get(name, np.eye(3))
        own[:3, 3] = pivot - own[:3, :3] @ pivot
        moved[j] = own if parent < 0 else moved[parent] @ own
    return np.asarray(moved @ skeleton.rest)


def _skeleton_file(path: Path) -> Path:
    if not path.is_dir():
        return path
    found = sorted(path.glob("*.mhskel"))
    if len(found) != 1:
        raise FileError(f"{path} holds {len(found)} .mhskel files; name the one to read.")
    return found[0]


def _weights(path: Path, names: tuple[str, ...], count: int) -> tuple[Floats, list[Note]]:
    """Return weights `(N, J)` that sum to 1 per vertex, and what was repaired."""
    table = parsed(path).get("weights")
    if not isinstance(table, dict):
        raise FileError(f"{path} holds no weights; it is no MakeHuman weights file.")
    dense = np.zeros((count, len(names)))
    for name, pairs in table.items():
        if name not in names:
            raise FileError(f"{path}: {unknown('bone', name, names)}")
        try:
            rows, shares = np.array(pairs, dtype=np.float64).reshape(-1, 2).T
        except (ValueError, TypeError, OverflowError):
            raise FileError(f"{path}: the weights of {name!r} must be pairs of a vertex and a weight.") from None
        good = (rows >= 0) & (rows < count) & (rows == np.floor(rows)) & (shares >= 0) & (shares < np.inf)
        if not good.all():
            bad = int(np.argmin(good))
            raise FileError(f"{path}: {name!r} has the weight {shares[bad]:g} at vertex {rows[bad]:g} of {count}.")
        np.add.at(dense[:, names.index(name)], rows.astype(np.int64), shares)
    total = dense.sum(axis=1)
    notes = []
    off = (np.abs(total - 1) > OFF) & (total > 0)
    if off.any():
        notes.append(Note("skin-weights", f"{off.sum()} vertices had weights that did not sum to 1: scaled", path.name))
    if (total == 0).any():
        notes.append(Note("unskinned", f"{(total == 0).sum()} vertices without weights follow the root", path.name))
        dense[total == 0, 0] = 1
    return dense / dense.sum(axis=1, keepdims=True), notes


def _descendants(path: Path, skeleton: Skeleton, top: str) -> Flags:
    """Return which joints are `top` or hang below it, `(J,)`."""
    if top not in skeleton.names:
        raise FileError(f"{path}: {unknown('joint', top, skeleton.names)}")
    inside = np.array([name == top for name in skeleton.names])
    for j, parent in enumerate(skeleton.parents):  # parents come first
        inside[j] |= parent >= 0 and inside[parent]
    return inside


def _only(path: Path, base: Mesh, kept: Flags) -> tuple[Mesh, Ints]:
    """Return the triangles that lie wholly among the kept vertices, and which vertices they use."""
    chosen = kept[base.triangles].all(axis=1)
    rows = np.unique(base.triangles[chosen])
    if not len(rows):
        raise FileError(f"{path}: no triangle of {BASE} is part of a body there.")
    place = np.full(len(base.vertices), -1)
    place[rows] = np.arange(len(rows))
    uv = None if base.uv is None else base.uv[chosen]
    groups = {PARTS[name]: place[ids] for name, ids in base.groups.items() if name in PARTS}
    groups = {name: ids[ids >= 0] for name, ids in groups.items() if (ids >= 0).any()}
    return Mesh(base.vertices[rows], place[base.triangles[chosen]], uv, groups=groups), rows


def _skin(dense: Floats, inverse_bind: Floats) -> Skin:
    width = int((dense > 0).sum(axis=1).max())
    joints = np.argsort(-dense, axis=1, kind="stable")[:, :width]
    return Skin(joints, np.take_along_axis(dense, joints, axis=1), inverse_bind)
