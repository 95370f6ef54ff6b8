"""From where things are in the world to what their nodes must do."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mien.core.arrays import Floats
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields
from mien.io.gltf.scene import Scene, read_scene, scene_roots
from mien.io.gltf.transforms import composed, continuous, decomposed, invertible
from mien.vocabularies.joints import head_of

HEAD_NODE = "mien_head"
"""The node above everything that carries the head's motion where no joint can."""

SHEAR = 1e-4
"""How much of a local transform, relative to its size, may be lost as translation, rotation and scale."""

Parts = dict[str, Floats]


def head_joint(document: Document, scene: Scene) -> int | None:
    """Return the joint of a skin that is named like a head, the plainest name first; None if there is none."""
    skins = document.top.each("skins")
    joints = sorted({joint for skin in skins for joint in skin.integers("joints") if joint < len(scene.nodes)})
    head = head_of([scene.nodes[joint].text("name") for joint in joints])
    return None if head is None else joints[head]


def local_parts(scene: Scene, world: dict[int, Floats]) -> dict[int, Parts] | None:
    """Return what the nodes' translation, rotation and scale must be to put them where they are wanted.

    Args:
        scene: the nodes.
        world: `(F, 4, 4)` wanted world matrices of some nodes; the others keep their local transforms.

    Returns:
        Per node the properties that change or differ from rest, or None if some motion would need shear.
    """
    found: dict[int, Parts] = {}
    for node, wanted in world.items():
        above = _world(scene, scene.parents[node], world)
        if not invertible(above).all():
            return None
        local: Floats = np.asarray(np.linalg.solve(np.broadcast_to(above, wanted.shape), wanted), dtype=np.float64)
        translation, rotation, scale = decomposed(local)
        lost = np.abs(composed(translation, rotation, scale) - local)[..., :3, :3].max()
        if lost > SHEAR * np.abs(local[..., :3, :3]).max():
            return None
        parts = {"translation": translation, "rotation": continuous(rotation), "scale": scale}
        found[node] = {path: part for path, part in parts.items() if _differs(part, _rest(scene, node)[path])}
    return found


def _world(scene: Scene, node: int, wanted: dict[int, Floats]) -> Floats:
    """Return a node's world matrix, taken as wanted where it is."""
    local: Floats = np.eye(4)
    for ancestor in scene.line(node):
        if ancestor in wanted:
            return np.asarray(wanted[ancestor] @ local)
        local = scene.local[ancestor] @ local
    return local


def _rest(scene: Scene, node: int) -> Parts:
    return dict(zip(("translation", "rotation", "scale"), decomposed(scene.local[node]), strict=True))


def _differs(moved: Floats, rest: Floats) -> bool:
    size = max(float(np.abs(rest).max()), float(np.abs(moved).max()), 1e-9)
    if rest.size == 4:  # a quaternion and its opposite are the same rotation
        rest = np.where((moved * rest).sum(axis=1, keepdims=True) < 0, -rest, rest)
    return bool((np.abs(moved - rest) > 1e-7 * size).any())


def head_node(document: Document, scene: Scene) -> int:
    """Return the node above the whole scene that may carry the head's motion, making it where there is none."""
    roots = scene_roots(document, scene.parents)
    if len(roots) == 1 and scene.nodes[roots[0]].text("name") == HEAD_NODE:
        return roots[0]
    nodes = document.root["nodes"]
    nodes.append({"name": HEAD_NODE, "children": roots})
    if not document.top.each("scenes"):
        document.root["scenes"], document.root["scene"] = [{"nodes": roots}], 0
    for scene_fields in document.top.each("scenes"):
        kept = [root for root in scene_fields.integers("nodes") if root not in roots]
        if len(kept) < len(scene_fields.integers("nodes")):
            scene_fields.values["nodes"] = [*kept, len(nodes) - 1]
    return len(nodes) - 1


def head_parts(document: Document, motion: Floats) -> dict[int, Parts]:
    """Return how the head's rigid motion `(F, 4, 4)` is played: by its joint, else by a node above everything."""
    scene = read_scene(document)
    joint = head_joint(document, scene)
    parts = None if joint is None else local_parts(scene, {joint: motion @ scene.world[joint]})
    if parts is not None:
        return parts
    node = head_node(document, scene)
    scene = read_scene(document)
    return local_parts(scene, {node: motion @ scene.world[node]}) or {}


def free_of_matrices(nodes: Iterable[Fields]) -> None:
    """Replace the matrices of nodes by translation, rotation and scale, as animated nodes must have them."""
    for node in nodes:
        matrix = node.numbers("matrix", 16)
        if matrix is not None:
            del node.values["matrix"]
            parts = decomposed(np.array(matrix).reshape(4, 4).T)
            for path, part in zip(("translation", "rotation", "scale"), parts, strict=True):
                node.values[path] = part.tolist()
