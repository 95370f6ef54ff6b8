"""Joints, skins and influences as a glTF document holds them."""

from __future__ import annotations

from typing import Any

import numpy as np

from mien.core import Note, Skeleton, Skin
from mien.core.arrays import Floats, Ints
from mien.io.gltf.packing import VERTICES, Packing
from mien.io.gltf.transforms import composed, decomposed


def add_joints(packing: Packing, skeleton: Skeleton, carrier: Floats | None = None) -> list[int]:
    """Add the joints as nodes, each below its parent, and return their numbers.

    Args:
        packing: the document.
        skeleton: the joints.
        carrier: `(4, 4)` world matrix of the node that the roots are going to hang under; the world if None.
    """
    first = len(packing.document.root.get("nodes", []))
    nodes: list[dict[str, Any]] = []
    for name, parent, rest in zip(skeleton.names, skeleton.parents, skeleton.rest, strict=True):
        above = skeleton.rest[parent] if parent >= 0 else carrier
        local = rest if above is None else np.linalg.solve(above, rest)
        nodes.append({"name": name, **_transform(local)})
    for child, parent in enumerate(skeleton.parents):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(first + child)
    return [packing.add("nodes", node) for node in nodes]


def add_skin(packing: Packing, joints: list[int], inverse_bind: Floats) -> int:
    """Add a skin over joint nodes with their inverse bind matrices `(J, 4, 4)` and return its number."""
    matrices = inverse_bind.copy()
    matrices[:, 3] = 0, 0, 0, 1
    stored = packing.array(matrices.swapaxes(1, 2).reshape(len(joints), 16), "<f4")
    return packing.add("skins", {"joints": joints, "inverseBindMatrices": stored})


def add_influences(packing: Packing, skin: Skin, rows: Ints | slice) -> dict[str, int]:
    """Store joints and weights of some vertices in sets of four, each joint once per vertex and unused ones as 0."""
    spare = -skin.weights.shape[1] % 4
    joints = np.pad(skin.joints, ((0, 0), (0, spare)))[rows]
    weights = _once(joints, np.pad(skin.weights, ((0, 0), (0, spare)))[rows]).astype("<f4")
    weights /= weights.sum(axis=1, keepdims=True)
    joints = np.where(weights > 0, joints, 0)
    small = "|u1" if len(skin.inverse_bind) <= 256 else "<u2"
    stored = {}
    for n in range(joints.shape[1] // 4):
        four = slice(4 * n, 4 * n + 4)
        stored[f"JOINTS_{n}"] = packing.array(joints[:, four], small, target=VERTICES)
        stored[f"WEIGHTS_{n}"] = packing.array(weights[:, four], "<f4", target=VERTICES)
    return stored


def limited(skin: Skin, most: int) -> tuple[Skin, list[Note]]:
    """Return the skin with the `most` strongest influences of each vertex, scaled to sum to 1, and what was lost."""
    weights = _once(skin.joints, skin.weights)
    order = np.argsort(-weights, axis=1, kind="stable")[:, :most]
    kept, joints = np.take_along_axis(weights, order, axis=1), np.take_along_axis(skin.joints, order, axis=1)
    total = kept.sum(axis=1, keepdims=True)
    lost = weights.sum(axis=1) - total[:, 0]
    notes = []
    if (lost > 1e-6).any():
        said = (
            f"{(lost > 1e-6).sum()} vertices had more than {most} influences: the weakest were left out, "
            f"at most {lost.max():.3f} of a vertex's weight"
        )
        notes.append(Note("influences-dropped", said))
    return Skin(joints, kept / total, skin.inverse_bind), notes


def _once(joints: Ints, weights: Floats) -> Floats:
    """Return the weights with those of a joint that a vertex names twice gathered at its first mention."""
    gathered = weights.copy()
    for i in range(joints.shape[1]):
        for j in range(i):
            same = (joints[:, i] == joints[:, j]) & (gathered[:, i] != 0)
            gathered[same, j] += gathered[same, i]
            gathered[same, i] = 0
    return gathered


def _transform(local: Floats) -> dict[str, list[float]]:
    parts = decomposed(local)
    if np.allclose(composed(*parts), local, rtol=1e-6, atol=1e-9):
        return {path: p.tolist() for path, p in zip(("translation", "rotation", "scale"), parts, strict=True)}
    affine = local.copy()
    affine[3] = 0, 0, 0, 1
    return {"matrix": affine.T.ravel().tolist()}
