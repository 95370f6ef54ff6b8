"""Adding morph targets to meshes that may have some already.

A mesh that grows drags along everything that counts its targets: the weights of the
mesh and of its nodes, and every animation of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mien.core.arrays import Floats
from mien.io.gltf.accessors import count_of, floats_at
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields
from mien.io.gltf.instances import Instance
from mien.io.gltf.packing import Packing


@dataclass(frozen=True, eq=False)
class Curve:
    """An animation channel of morph weights.

    Attributes:
        animation, channel: where it is.
        node: the node that it animates.
        values: all its numbers, of every key one weight per target.
    """

    animation: Fields
    channel: Fields
    node: int
    values: Floats


def weight_curves(document: Document) -> list[Curve]:
    """Return all animation channels of morph weights.

    Raises:
        FileError: a channel refers to what does not exist.
    """
    found = []
    for animation in document.top.each("animations"):
        samplers = animation.each("samplers")
        for channel in animation.each("channels"):
            target, index = channel.inner("target"), channel.integer("sampler")
            if target.text("path") == "weights" and "node" in target:
                if index >= len(samplers):
                    raise channel.error(f"refers to sampler {index}, which does not exist")
                values = floats_at(document, samplers[index].integer("output"), samplers[index], "SCALAR")[:, 0]
                found.append(Curve(animation, channel, target.integer("node"), values))
    return found


def put_shapes(packing: Packing, mesh: Fields, place: Instance, names: Sequence[str], deltas: Floats) -> int:
    """Add shapes to a mesh behind those it has, or in place of those of the same name.

    Args:
        packing: the document.
        mesh: the mesh.
        place: a node that shows it, as it was read.
        names: the shapes.
        deltas: `(K, n, 3)` displacements in the mesh's own space.

    Returns:
        How many targets the mesh has now.
    """
    known = {name: i for i, name in enumerate([*place.names, *(n for n in names if n not in place.names)])}
    parts = [slice(own.start - place.start, own.stop - place.start) for own, _ in place.parts()]
    stored = [[packing.sparse(delta[own], "<f4") for delta in deltas] for own in parts]
    for primitive, owner in zip(mesh.each("primitives"), place.surface.owners, strict=True):
        targets: list[dict[str, Any]] = primitive.values.setdefault("targets", [])
        further = sorted({name for target in targets for name in target} - {"POSITION"})
        still = -1
        if owner < 0 or further or len(targets) < len(place.names):
            positions = primitive.inner("attributes").integer("POSITION")
            still = packing.sparse(np.zeros((count_of(packing.document, positions, primitive), 3)), "<f4")
        rest = dict.fromkeys(further, still)
        targets += [{"POSITION": still, **rest} for _ in range(len(known) - len(targets))]
        for k, name in enumerate(names):
            targets[known[name]] = {"POSITION": still if owner < 0 else stored[owner][k], **rest}
    extras = mesh.values.get("extras")
    mesh.values["extras"] = {**(extras if isinstance(extras, dict) else {}), "targetNames": list(known)}
    _lengthen(mesh, len(known))
    return len(known)


def widen(packing: Packing, curves: Sequence[Curve], node: int, before: int, after: int) -> None:
    """Give a node's weights and their animations a 0 for each target its mesh has got more.

    Args:
        packing: the document.
        curves: its animations of weights.
        node: the node.
        before, after: how many targets its mesh had and has.
    """
    fields = packing.document.top.each("nodes")[node]
    _lengthen(fields, after)
    for curve in curves:
        if curve.node == node and before and curve.values.size % before == 0:
            keys = np.pad(curve.values.reshape(-1, before), ((0, 0), (0, after - before)))
            samplers = curve.animation.values["samplers"]
            old = samplers[curve.channel.integer("sampler")]
            samplers.append({**old, "output": packing.array(keys.reshape(-1, 1), "<f4")})
            curve.channel.values["sampler"] = len(samplers) - 1


def _lengthen(holder: Fields, count: int) -> None:
    weights = holder.numbers("weights")
    if weights is not None:
        holder.values["weights"] = [*weights, *[0.0] * (count - len(weights))]
