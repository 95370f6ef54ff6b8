"""A new glTF document for a rig that came from elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Mesh, Rig
from mien.core.arrays import Flags, Floats, Ints
from mien.core.rig import Colour
from mien.io.gltf.anatomy import describe
from mien.io.gltf.bones import add_influences, add_joints, add_skin
from mien.io.gltf.container import Document
from mien.io.gltf.materials import SKIN
from mien.io.gltf.packing import INDICES, VERTICES, Packing

Colours = Mapping[str, Colour]
"""Linear red, green and blue of vertex groups."""


def document_of(path: Path, rig: Rig, colours: Colours | None) -> Packing:
    """Return a document that holds the rig, in its own colours if None; its nodes are the joints, then the mesh."""
    root: dict[str, Any] = {"asset": {"version": "2.0", "generator": "mien"}}
    packing = Packing(Document(path, root))
    node: dict[str, Any] = {"name": rig.name, "mesh": 0}
    roots: list[int] = []
    if rig.skeleton is not None and rig.skin is not None:
        joints = add_joints(packing, rig.skeleton)
        roots = [joints[i] for i in np.flatnonzero(rig.skeleton.parents < 0)]
        node["skin"] = add_skin(packing, joints, rig.skin.inverse_bind)
    packing.add("meshes", mesh_of(packing, rig, rig.colours if colours is None else colours))
    roots.append(packing.add("nodes", node))
    root["scene"] = packing.add("scenes", {"nodes": roots})
    describe(packing, rig, seams(rig.neutral)[0])
    return packing


def mesh_of(packing: Packing, rig: Rig, colours: Colours) -> dict[str, Any]:
    """Return one mesh whose primitives share all vertices, so that their order is the rig's."""
    neutral = rig.neutral
    origin, texture, triangles = seams(neutral)
    to_own = _to_own_space(rig)
    positions = np.einsum("nab,nb->na", to_own[:, :3, :3], neutral.vertices) + to_own[:, :3, 3]
    attributes = {
        "POSITION": packing.array(positions[origin], "<f4", target=VERTICES, bounds=True),
        "NORMAL": packing.array(normals(positions, neutral.triangles)[origin], "<f4", target=VERTICES),
    }
    if texture is not None:
        attributes["TEXCOORD_0"] = packing.array(texture, "<f4", target=VERTICES)
    if rig.skin is not None:
        attributes |= add_influences(packing, rig.skin, origin)
    shared: dict[str, Any] = {"attributes": attributes}
    mesh: dict[str, Any] = {"name": rig.name, "primitives": []}
    if len(rig.blendshapes):
        shared["targets"] = [
            {"POSITION": packing.sparse(np.einsum("nab,nb->na", to_own[:, :3, :3], delta)[origin], "<f4")}
            for delta in rig.blendshapes.deltas
        ]
        mesh["extras"] = {"targetNames": list(rig.blendshapes.names)}
    for name, colour, chosen in _painted(neutral, colours):
        material = packing.add("materials", _material(name, colour))
        indices = packing.array(triangles[chosen].reshape(-1, 1), "<u4", target=INDICES)
        mesh["primitives"].append({**shared, "indices": indices, "material": material})
    return mesh


def _painted(mesh: Mesh, colours: Colours) -> list[tuple[str, Colour, Flags]]:
    """Return names, colours and triangles `(T,)` of the parts: what lies wholly in a group, later ones over earlier."""
    part = np.zeros(len(mesh.triangles), np.int64)
    looks = [("skin", SKIN), *colours.items()]
    for number, name in enumerate(colours, start=1):
        inside = np.isin(mesh.triangles, mesh.groups[name]).all(axis=1)
        part[inside] = number
    return [(*looks[number], part == number) for number in np.unique(part)]


def _material(name: str, colour: Colour) -> dict[str, Any]:
    look = {"baseColorFactor": [*colour, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6}
    return {"name": name, "doubleSided": True, "pbrMetallicRoughness": look}


def _to_own_space(rig: Rig) -> Floats:
    """Return per vertex the transform from the world at rest to the mesh's own space, `(N, 4, 4)`."""
    if rig.skin is None or rig.skeleton is None:
        return np.broadcast_to(np.eye(4), (len(rig.neutral.vertices), 4, 4))
    return np.asarray(np.linalg.inv(rig.skin.blend(rig.skeleton.rest)))


def seams(mesh: Mesh) -> tuple[Ints, Floats | None, Ints]:
    """Return what the vertices of a file with one texture coordinate each must be.

    Returns:
        For each of them the mesh's vertex, `(M,)`, the first N being 0 … N - 1; its
        texture coordinate, `(M, 2)`; and the triangles, `(T, 3)`.
    """
    count = len(mesh.vertices)
    if mesh.uv is None:
        return np.arange(count), None, mesh.triangles
    corner = mesh.triangles.ravel()
    pairs = np.column_stack([corner, mesh.uv.reshape(-1, 2)])
    distinct, place = np.unique(pairs, axis=0, return_inverse=True)
    owner = distinct[:, 0].astype(np.int64)
    further = np.append(False, owner[1:] == owner[:-1])
    number = np.where(further, count - 1 + np.cumsum(further), owner)
    texture = np.zeros((count + int(further.sum()), 2))
    texture[number] = distinct[:, 1:]
    origin = np.concatenate([np.arange(count), owner[further]])
    return origin, texture, number[place.reshape(-1)].reshape(-1, 3)


def normals(vertices: Floats, triangles: Ints) -> Floats:
    """Return smooth unit normals `(N, 3)`, weighted by area; +Z where no triangle tells."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    face = np.cross(b - a, c - a)
    total = np.zeros_like(vertices)
    for i in range(3):
        np.add.at(total, triangles[:, i], face)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    flat = length[:, 0] < np.finfo(float).tiny
    total[flat], length[flat] = (0, 0, 1), 1
    return np.asarray(total / length)
