"""What carries every vertex: its node, or the joints of its node's skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import Note, Skin
from mien.core.arrays import Floats, Ints
from mien.io.gltf.container import Document
from mien.io.gltf.instances import Instance
from mien.io.gltf.meshes import Part
from mien.io.gltf.scene import Scene
from mien.io.gltf.skinning import STILL, Joints, influences
from mien.io.gltf.transforms import invertible


@dataclass(frozen=True, eq=False)
class Binding:
    """How the vertices are bound.

    Attributes:
        to_world: `(N, 4, 4)` from each vertex's own space to the world at rest.
        joints: the joints, none if nothing can move.
        skin: the influences, or None if nothing can move.
    """

    to_world: Floats
    joints: Joints
    skin: Skin | None = None


def bind(document: Document, scene: Scene, instances: list[Instance], notes: list[Note]) -> Binding:
    """Return what carries the vertices; as soon as one is carried by a joint, all are.

    Args:
        document: the file.
        scene: its nodes.
        instances: its meshes.
        notes: where repairs are recorded.

    Raises:
        FileError: a skin is damaged.
    """
    joints = Joints()
    skins = _skins(document, scene, instances, joints)
    if not skins and not _moving(document, scene, instances):
        worlds = [np.broadcast_to(scene.world[i.node], (i.surface.count, 4, 4)) for i in instances]
        return Binding(np.concatenate(worlds), joints)
    parts = [(own, part, instance) for instance in instances for own, part in instance.parts()]
    width = max(4 * len(part.influences) for _, part, _ in parts) or 1
    places, weights = np.zeros((instances[-1].stop, width), np.int64), np.zeros((instances[-1].stop, width))
    for own, part, instance in parts:
        rows = skins.get(instance.node)
        if rows is None or not part.influences:
            places[own, 0], weights[own, 0] = joints.row(instance.node), 1
        else:
            loose = joints.row(instance.node) if _unheld(part) else 0
            some = slice(0, 4 * len(part.influences))
            places[own, some], weights[own, some] = influences(part, rows, loose, notes)
    return _with_still(scene, joints, places, weights, notes)


def _skins(document: Document, scene: Scene, instances: list[Instance], joints: Joints) -> dict[int, Ints]:
    """Return the joint rows of every node that shows a mesh with a skin."""
    found: dict[int, Ints] = {}
    read: dict[int, Ints] = {}
    for instance in instances:
        if "skin" in instance.fields and any(part.influences for part in instance.surface.parts):
            index = instance.fields.integer("skin")
            if index not in read:
                read[index] = joints.of_skin(document, document.at("skins", index, instance.fields), scene)
            found[instance.node] = read[index]
    return found


def _moving(document: Document, scene: Scene, instances: list[Instance]) -> bool:
    """Return whether any animation moves a node that carries a mesh."""
    return not animated_nodes(document).isdisjoint(scene.lineage(instance.node for instance in instances))


def animated_nodes(document: Document) -> set[int]:
    """Return the nodes that any animation translates, rotates or scales."""
    targets = [
        channel.inner("target")
        for animation in document.top.each("animations")
        for channel in animation.each("channels")
    ]
    paths = {"translation", "rotation", "scale"}
    return {target.integer("node") for target in targets if target.text("path") in paths and "node" in target}


def _unheld(part: Part) -> bool:
    """Return whether a vertex of a skinned part has no weight at all."""
    weights = np.concatenate([weights for _, weights in part.influences], axis=1)
    return not (weights > 0).any(axis=1).all()


def _with_still(scene: Scene, joints: Joints, places: Ints, weights: Floats, notes: list[Note]) -> Binding:
    """Tie what is scaled to nothing at rest to the world, because no pose could be told from it."""
    skin = Skin(places, weights, np.array(joints.inverse_bind))
    to_world = skin.blend(joints.rest(scene))
    flat = ~invertible(to_world)
    if not flat.any():
        return Binding(to_world, joints, skin)
    notes.append(Note("collapsed", f"{flat.sum()} vertices have no extent at rest (scale 0) and stay where they are"))
    places[flat], weights[flat] = 0, 0
    places[flat, 0], weights[flat, 0] = joints.row(STILL), 1
    return Binding(to_world, joints, Skin(places, weights, np.array(joints.inverse_bind)))
