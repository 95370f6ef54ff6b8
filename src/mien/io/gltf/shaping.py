"""Which mesh of a face's file gets which shapes."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np

from mien.core import Blendshapes, InputError
from mien.core.arrays import Floats
from mien.io.gltf.container import Document
from mien.io.gltf.instances import Instance
from mien.io.gltf.morphs import Curve, put_shapes, widen
from mien.io.gltf.packing import Packing
from mien.io.gltf.rig import Character
from mien.io.gltf.transforms import invertible

UNCHANGED = 1e-6
"""Displacements that differ by less than this share of the largest one are those that the file has."""


def own_meshes(document: Document, instances: Sequence[Instance]) -> None:
    """Give every shown node a mesh of its own, since a rig may move the same mesh differently at each."""
    taken: set[int] = set()
    for instance in instances:
        index = instance.fields.integer("mesh")
        if index in taken:
            document.root["meshes"].append(copy.deepcopy(document.root["meshes"][index]))
            index = instance.fields.values["mesh"] = len(document.root["meshes"]) - 1
        taken.add(index)


def add_shapes(packing: Packing, found: Character, shapes: Blendshapes, curves: Sequence[Curve]) -> None:
    """Give each mesh the shapes that move it and that it does not have like that.

    A shape that moves nothing goes to the largest mesh, so that its name is kept.

    Args:
        packing: the document.
        found: the character as it was read.
        shapes: of the rig; the file's vertices first.
        curves: all animations of weights.

    Raises:
        InputError: a mesh that shapes move has no extent in the world.
    """
    main = max(found.instances, key=lambda instance: instance.surface.count)
    known = set(found.rig.blendshapes.names)
    still = {name for name in shapes.empty if name not in known}
    for instance in found.instances:
        own = slice(instance.start, instance.stop)
        wanted = [
            k
            for k, name in enumerate(shapes.names)
            if (instance is main and name in still) or not _has(found, instance, name, shapes.deltas[k, own])
        ]
        if not wanted:
            continue
        deltas = _in_own_space(shapes.deltas[wanted, own], found.to_world[own], found.scene.name(instance.node))
        index = instance.fields.integer("mesh")
        mesh = packing.document.at("meshes", index, instance.fields)
        count = put_shapes(packing, mesh, instance, [shapes.names[k] for k in wanted], deltas)
        for node, fields in enumerate(packing.document.top.each("nodes")):
            if fields.values.get("mesh") == index:
                widen(packing, curves, node, len(instance.names), count)


def _has(found: Character, instance: Instance, name: str, deltas: Floats) -> bool:
    """Return whether a mesh moves like that already, or need not be told because nothing moves."""
    if name not in instance.names:
        return not deltas.any()
    stored = found.rig.blendshapes.deltas[found.rig.blendshapes.index(name), instance.start : instance.stop]
    return bool(np.abs(stored - deltas).max() <= UNCHANGED * np.abs(stored).max(initial=0))


def _in_own_space(deltas: Floats, to_world: Floats, name: str) -> Floats:
    """Return displacements `(K, n, 3)` of the world in the space that a mesh's vertices are stored in."""
    linear = to_world[:, :3, :3]
    if not invertible(to_world).all():
        raise InputError(f"{name!r} is flat or has no extent at rest (its node's scale is 0): it cannot take shapes.")
    if (linear == linear[:1]).all():
        return np.asarray(deltas @ np.linalg.inv(linear[0]).T)
    return np.asarray(np.einsum("nab,knb->kna", np.linalg.inv(linear), deltas))
