"""Parts that a rig has beyond the vertices of the face's file: eyes and teeth that came with the rig."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from mien.core import Blendshapes, InputError, Mesh, Rig, Skin
from mien.core.arrays import Ints
from mien.io.gltf.bones import add_skin
from mien.io.gltf.fresh import Colours, mesh_of, seams
from mien.io.gltf.packing import Packing
from mien.io.gltf.rebinding import Bound

PARTS_NODE = "mien_parts"
"""The node that shows what a rig brought with it."""


def appended(rig: Rig, count: int) -> tuple[Rig | None, Ints]:
    """Return the rig of what follows the first `count` vertices, None if nothing does.

    The second thing returned is, per vertex that it takes in a file, which of its vertices it is.

    Raises:
        InputError: nothing shows these vertices, or triangles join them to the others.
    """
    neutral = rig.neutral
    if len(neutral.vertices) == count:
        return None, np.empty(0, np.int64)
    beyond = neutral.triangles >= count
    own = beyond.all(axis=1)
    if not own.any() or (beyond.any(axis=1) & ~own).any():
        raise InputError(
            f"the vertices of {rig.name!r} from {count} on, which its file does not have, need triangles of their own "
            "that use none of the others."
        )
    groups = {name: ids[ids >= count] - count for name, ids in neutral.groups.items() if (ids >= count).any()}
    uv = None if neutral.uv is None else neutral.uv[own]
    deltas = rig.blendshapes.deltas[:, count:]
    moving = np.flatnonzero(deltas.any(axis=(1, 2)))
    part = Rig(
        Mesh(neutral.vertices[count:], neutral.triangles[own] - count, uv, groups=groups),
        Blendshapes(tuple(rig.blendshapes.names[k] for k in moving), deltas[moving]),
        rig.skeleton,
        None if rig.skin is None else Skin(rig.skin.joints[count:], rig.skin.weights[count:], rig.skin.inverse_bind),
        name=PARTS_NODE,
    )
    return part, seams(part.neutral)[0]


def add_appended(packing: Packing, part: Rig, bound: Bound | None, colours: Colours) -> None:
    """Add appended parts to the default scene, as a mesh behind all nodes that shares the face's skin.

    Args:
        packing: the document.
        part: the parts.
        bound: what the face is bound to; None if to nothing.
        colours: of vertex groups, whether the parts have them or not.
    """
    present = {name: colour for name, colour in colours.items() if name in part.neutral.groups}
    node: dict[str, Any] = {"name": PARTS_NODE}
    if bound is not None and part.skin is not None:
        part = replace(part, skin=replace(part.skin, inverse_bind=bound.inverse_bind))
        shared = bound.skin is not None
        node["skin"] = bound.skin if shared else add_skin(packing, list(bound.joints), bound.inverse_bind)
    node["mesh"] = packing.add("meshes", mesh_of(packing, part, present))
    number = packing.add("nodes", node)
    root = packing.document.root
    if "scenes" in root:
        root["scenes"][root.get("scene", 0)].setdefault("nodes", []).append(number)
