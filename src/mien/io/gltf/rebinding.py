"""Binding the meshes of a face's file to a skeleton that it did not have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mien.core import InputError, Note, Rig, Skeleton, Skin
from mien.core.arrays import Floats
from mien.io.gltf.accessors import count_of
from mien.io.gltf.binding import animated_nodes
from mien.io.gltf.bones import add_influences, add_joints, add_skin
from mien.io.gltf.container import Document
from mien.io.gltf.instances import Instance
from mien.io.gltf.packing import VERTICES, Packing
from mien.io.gltf.rig import Character
from mien.io.gltf.skinning import STILL
from mien.io.gltf.transforms import invertible

ONE_PLACE = 1e-5
"""Vertices that two transforms put less than this share of the face's size apart are in one place."""

EXACT = 1e-12
"""What the inverse of a matrix times the matrix may be off."""


@dataclass(frozen=True, eq=False)
class Bound:
    """A skin in a document.

    Attributes:
        joints: the joints' nodes.
        skin: its number; None if the joints have no skin that all of them are in.
        inverse_bind: `(J, 4, 4)` its inverse bind matrices.
    """

    joints: tuple[int, ...]
    skin: int | None
    inverse_bind: Floats


def keeps_its_skin(rig: Rig, found: Character) -> bool:
    """Return whether a rig's skeleton and skin are those that its file has."""
    mine, theirs = rig.skin, found.rig.skin
    if mine is None or theirs is None or rig.skeleton is None or found.rig.skeleton is None:
        return False
    count = len(theirs.weights)
    pairs = [
        (rig.skeleton.parents, found.rig.skeleton.parents),
        (rig.skeleton.rest, found.rig.skeleton.rest),
        (mine.inverse_bind, theirs.inverse_bind),
        (mine.joints[:count], theirs.joints),
        (mine.weights[:count], theirs.weights),
    ]
    alike = all(a.shape == b.shape and np.allclose(a, b, rtol=1e-6, atol=1e-9) for a, b in pairs)
    return alike and rig.skeleton.names == found.rig.skeleton.names and STILL not in found.joint_nodes


def bind_meshes(packing: Packing, found: Character, skeleton: Skeleton, skin: Skin) -> tuple[Bound, list[Note]]:
    """Add a skeleton and bind every shown mesh to it, in place of any skin it has.

    Args:
        packing: the document.
        found: the character as it was read.
        skeleton: the joints.
        skin: the influences; those of the file's vertices first.

    Returns:
        The joints and the largest mesh's skin, and what was left out.

    Raises:
        InputError: a mesh is posed at rest by its own skin, so that no new skin can leave its vertices as they are.
    """
    carrier, notes = _carrier(packing.document, found)
    joints = add_joints(packing, skeleton, None if carrier is None else found.scene.world[carrier])
    roots = [joints[i] for i in np.flatnonzero(skeleton.parents < 0)]
    if carrier is None:
        _show(packing.document, found, roots)
    else:
        found.scene.nodes[carrier].values.setdefault("children", []).extend(roots)
    skins: dict[bytes, int] = {}
    bound: list[Bound] = []
    for instance in found.instances:
        inverse_bind, more = _inverse_bind(found, instance, skeleton, skin)
        notes += more
        key = inverse_bind.tobytes()
        if key not in skins:
            skins[key] = add_skin(packing, joints, inverse_bind)
        instance.fields.values["skin"] = skins[key]
        bound.append(Bound(tuple(joints), skins[key], inverse_bind))
        _put_influences(packing, instance, skin)
    main = max(range(len(bound)), key=lambda i: found.instances[i].surface.count)
    return bound[main], list(dict.fromkeys(notes))


def _carrier(document: Document, found: Character) -> tuple[int | None, list[Note]]:
    """Return the node that the new roots hang under: what moved most of the face before, if anything."""
    skin = found.rig.skin
    if skin is None:
        return None, []
    held = np.bincount(skin.joints.ravel(), skin.weights.ravel(), minlength=len(found.joint_nodes))
    by_node: dict[int, float] = {}
    for node, weight in zip(found.joint_nodes, held, strict=True):
        by_node[node] = by_node.get(node, 0.0) + float(weight)
    best = max(by_node, key=lambda node: by_node[node])
    moving = animated_nodes(document)
    moving |= {joint for fields in document.top.each("skins") for joint in fields.integers("joints")}
    carrier = next((node for node in found.scene.line(best) if node in moving), None)
    lost = 1 - by_node[best] / held.sum()
    said = f"the file's own joints and animated nodes no longer move the face, except for {found.scene.name(best)!r}"
    notes = [Note("carriers-replaced", f"{said}: {100 * lost:.1f} % of its weights were replaced")]
    return carrier, notes if lost > 1e-6 else []


def _show(document: Document, found: Character, roots: list[int]) -> None:
    """Put root joints into every scene that shows one of the face's meshes."""
    tops = {list(found.scene.line(instance.node))[-1] for instance in found.instances}
    for scene in document.top.each("scenes"):
        if not tops.isdisjoint(scene.integers("nodes")):
            scene.values["nodes"] = [*scene.integers("nodes"), *roots]


def _inverse_bind(found: Character, instance: Instance, skeleton: Skeleton, skin: Skin) -> tuple[Floats, list[Note]]:
    """Return the inverse bind matrices `(J, 4, 4)` that take a mesh's stored vertices to the joints."""
    own = slice(instance.start, instance.stop)
    stored = np.concatenate([part.positions for part in instance.surface.parts])
    size = float(np.ptp(found.rig.neutral.vertices, axis=0).max())
    to_world = found.to_world[own]
    bound = Skin(skin.joints[own], skin.weights[own], skin.inverse_bind)
    at_rest = bound.blend(skeleton.rest)
    common = None
    if invertible(at_rest).all():
        common = _common(np.asarray(np.linalg.solve(at_rest, to_world), np.float64), stored, size)
    if common is not None and np.allclose(common, np.eye(4), rtol=0, atol=EXACT):
        return skin.inverse_bind, []  # to the bit, so that meshes in one space share a skin
    if common is not None:
        return np.asarray(skin.inverse_bind @ common), []
    common = _common(to_world, stored, size)
    name = found.scene.name(instance.node)
    if common is None:
        raise InputError(
            f"{name!r} in {found.document.path.name} is posed at rest by the skin it has, and another skin would move "
            "its vertices; apply the rest pose in the program that made the file, and export it again."
        )
    note = Note("bound-at-rest", "the rig was bound in another pose than its rest: it is bound at rest instead", name)
    return np.asarray(np.linalg.inv(skeleton.rest) @ common), [note]


def _common(transforms: Floats, points: Floats, size: float) -> Floats | None:
    """Return the transform that all of `(n, 4, 4)` are as far as points `(n, 3)` tell; None if there is none."""
    mean = transforms.mean(axis=0)
    apart = np.einsum("nab,nb->na", (transforms - mean)[:, :3, :3], points) + (transforms - mean)[:, :3, 3]
    return mean if bool((np.abs(apart) <= ONE_PLACE * size).all()) else None


def _put_influences(packing: Packing, instance: Instance, skin: Skin) -> None:
    """Store joints and weights of a mesh; points and lines, which the rig does not know, follow the first joint."""
    mesh = packing.document.at("meshes", instance.fields.integer("mesh"), instance.fields)
    stored = [add_influences(packing, skin, np.arange(own.start, own.stop)) for own, _ in instance.parts()]
    for primitive, owner in zip(mesh.each("primitives"), instance.surface.owners, strict=True):
        attributes = primitive.inner("attributes")
        packed = primitive.extension("KHR_draco_mesh_compression")
        for holder in [attributes, *([] if packed is None else [packed.inner("attributes")])]:
            _drop_influences(holder.values)
        if owner < 0:
            positions = attributes.integer("POSITION")
            attributes.values.update(_first_joint(packing, count_of(packing.document, positions, primitive)))
        else:
            attributes.values.update(stored[owner])


def _drop_influences(attributes: dict[str, Any]) -> None:
    for name in [name for name in attributes if name.startswith(("JOINTS_", "WEIGHTS_"))]:
        del attributes[name]


def _first_joint(packing: Packing, count: int) -> dict[str, int]:
    weights = np.zeros((count, 4))
    weights[:, 0] = 1
    joints = packing.array(np.zeros((count, 4)), "|u1", target=VERTICES)
    return {"JOINTS_0": joints, "WEIGHTS_0": packing.array(weights, "<f4", target=VERTICES)}
