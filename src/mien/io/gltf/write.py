"""Writing: a clip into the character's own file, or a rig into a new one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Clip, InputError, Rig
from mien.core.arrays import Floats
from mien.io.gltf.container import open_document
from mien.io.gltf.fresh import Colours, document_of
from mien.io.gltf.meshes import numbered, shape_names
from mien.io.gltf.motion import Parts, free_of_matrices, head_parts, local_parts
from mien.io.gltf.packing import Packing
from mien.io.gltf.rig import character
from mien.io.gltf.scene import read_scene
from mien.io.gltf.skinning import STILL


def write_clip(path: Path, clip: Clip, rig: Rig | None, name: str = "mien") -> None:
    """Write a character with an animation, as .glb or as .gltf with a .bin beside it.

    A character that came from glTF keeps its whole file (materials, textures, other
    nodes, animations, extensions, compressed data); the new animation is put first.
    The head moves by its joint, or where there is none by a new node above everything.

    Args:
        path: the file to write.
        clip: weights by shape name (absent ones are 0, untracked frames hold the last
            tracked one), and the motion of the head or of all joints.
        rig: the character it plays on.
        name: what to call the animation.

    Raises:
        FileError: the character's file is gone or damaged, or `path` cannot be written.
        InputError: there is no character, or nothing of the clip moves it.
    """
    if rig is None:
        raise InputError(f"{path} needs the character that the animation plays on; give its rig.")
    if rig.source is None or rig.source.suffix.lower() not in {".glb", ".gltf"}:
        write_rig(path, rig, clip, name)
        return
    document = open_document(rig.source)
    nodes: Sequence[int] = character(document).joint_nodes if moved_joints(clip, rig) is not None else ()
    packing = Packing(document)
    animate(packing, clip, nodes, name)
    packing.write(path)


def write_rig(
    path: Path, rig: Rig, clip: Clip | None = None, name: str = "mien", colours: Colours | None = None
) -> None:
    """Write a rig as a new glTF file: one mesh, its shapes, its skin, and a clip if there is one.

    Vertices keep their order.  Where texture coordinates need a vertex several times,
    the copies follow behind all others.

    Args:
        path: the file to write.
        rig: the character.
        clip: what it plays.
        name: what to call the animation.
        colours: linear red, green and blue of vertex groups, later ones over earlier; each becomes a material.
            The rig's own if None.

    Raises:
        FileError: `path` cannot be written.
        InputError: the rig has no triangles, or nothing of the clip moves it.
    """
    if not len(rig.neutral.triangles):
        raise InputError(f"{rig.name!r} has no triangles; a glTF file needs a surface.")
    packing = document_of(path, rig, colours)
    if clip is not None:
        joints = moved_joints(clip, rig)
        animate(packing, clip, () if joints is None else range(joints.shape[1]), name)
    packing.write(path)


def moved_joints(clip: Clip, rig: Rig) -> Floats | None:
    """Return the clip's joint matrices if they are about a skeleton the rig has."""
    if clip.joints is None or rig.skeleton is None:
        return None
    if clip.joints.shape[1] != len(rig.skeleton.names):
        raise InputError(
            f"the clip moves {clip.joints.shape[1]} joints, but {rig.name!r} has {len(rig.skeleton.names)}; "
            "give the clip of this character, or one without joints."
        )
    return clip.joints


def animate(packing: Packing, clip: Clip, joint_nodes: Sequence[int], name: str) -> None:
    """Add an animation to a document and put it before the others."""
    if not len(clip):
        raise InputError("the clip has no frames; nothing can be written.")
    document = packing.document
    names = [animation.text("name") for animation in document.top.each("animations")]
    animation: dict[str, Any] = {"name": numbered([*names, name])[-1], "channels": [], "samplers": []}
    times = packing.array(np.arange(len(clip))[:, None] / clip.fps, "<f4", bounds=True)
    _add_weights(packing, clip, animation, times)
    for node, parts in _motion(packing, clip, joint_nodes).items():
        for path, values in parts.items():
            sampler = _sampler(animation, times, packing.array(values, "<f4"))
            animation["channels"].append({"sampler": sampler, "target": {"node": node, "path": path}})
    if not animation["channels"]:
        raise InputError(f"{document.path} has no blendshapes, and the clip moves no head: nothing can be written.")
    document.root.setdefault("animations", []).insert(0, animation)


def _add_weights(packing: Packing, clip: Clip, animation: dict[str, Any], times: int) -> None:
    document = packing.document
    values = held(clip.values)
    samplers: dict[tuple[str, ...], int] = {}
    for i, node in enumerate(document.top.each("nodes")):
        if "mesh" not in node:
            continue
        names = tuple(shape_names(document.at("meshes", node.integer("mesh"), node))[0])
        if names and names not in samplers:
            curves = Clip(clip.names, values, clip.fps).channels(names)
            samplers[names] = _sampler(animation, times, packing.array(curves.reshape(-1, 1), "<f4"))
        if names:
            animation["channels"].append({"sampler": samplers[names], "target": {"node": i, "path": "weights"}})


def _motion(packing: Packing, clip: Clip, joint_nodes: Sequence[int]) -> dict[int, Parts]:
    document = packing.document
    if clip.joints is not None and len(joint_nodes):
        world = {node: clip.joints[:, j] for j, node in enumerate(joint_nodes) if node != STILL}
        parts = local_parts(read_scene(document), world)
        if parts is None:
            raise InputError(f"the joints of the clip shear {document.path.name}, which glTF nodes cannot do.")
    elif clip.head is not None:
        parts = head_parts(document, clip.head)
    else:
        return {}
    nodes = document.top.each("nodes")
    free_of_matrices(nodes[node] for node, moved in parts.items() if moved)
    return parts


def _sampler(animation: dict[str, Any], times: int, output: int) -> int:
    animation["samplers"].append({"input": times, "output": output, "interpolation": "LINEAR"})
    return len(animation["samplers"]) - 1


def held(values: Floats) -> Floats:
    """Return values `(F, K)` with NaN replaced by the last number before, the first after, or 0."""
    seen = ~np.isnan(values)
    if seen.all():
        return values
    frames = np.arange(len(values))[:, None]
    last = np.maximum.accumulate(np.where(seen, frames, -1), axis=0)
    source = np.where(last >= 0, last, np.argmax(seen, axis=0))
    return np.nan_to_num(np.take_along_axis(values, source, axis=0))
