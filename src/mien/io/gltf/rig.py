"""From a glTF document to a rig: everything of the default scene, in world space at rest."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mien.core import Blendshapes, FileError, InputError, Mesh, Rig
from mien.core.arrays import Floats, Ints
from mien.io.gltf.accessors import floats_at
from mien.io.gltf.anatomy_read import described
from mien.io.gltf.binding import bind
from mien.io.gltf.container import MESHOPT, Document, open_document
from mien.io.gltf.instances import Instance, read_instances, vertex_groups
from mien.io.gltf.scene import Scene, read_scene

UNDERSTOOD = {
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "KHR_animation_pointer",
    "KHR_node_visibility",
    "KHR_xmp_json_ld",
    "KHR_lights_punctual",
    *MESHOPT,
}
LOOKS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "VRM")
"""Extensions of surfaces and characters that change no vertex."""

MOST_VALUES = 1 << 28
"""The most displacement values a file may unfold to (2 GiB); sparse and absent ones take no room in it."""


@dataclass(frozen=True, eq=False)
class Character:
    """A rig and where its pieces are in the document.

    Attributes:
        document: the document.
        rig: the rig.
        scene: the document's nodes.
        joint_nodes: the node of each of the skeleton's joints.
        instances: the mesh nodes with their places among the rig's vertices.
        to_world: `(N, 4, 4)` from each vertex's own space to the world at rest.
    """

    document: Document
    rig: Rig
    scene: Scene
    joint_nodes: tuple[int, ...]
    instances: tuple[Instance, ...]
    to_world: Floats


def read_rig(path: Path) -> Rig:
    """Read the character of a .glb or .gltf file.

    Raises:
        FileError: the file is missing, damaged, needs an unknown extension, or holds no triangles.
        MissingPackage: it is compressed with Draco, and DracoPy is not installed.
    """
    return character(open_document(path)).rig


def character(document: Document) -> Character:
    """Return the character of a document.

    Raises:
        FileError: as `read_rig`.
    """
    with np.errstate(all="ignore"):  # what overflows is found by the checks for finite numbers
        try:
            return _character(document)
        except InputError as error:
            raise FileError(f"{document.path}: {error}") from None


def _character(document: Document) -> Character:
    _check_extensions(document)
    scene = read_scene(document)
    instances, notes = read_instances(document, scene)
    binding = bind(document, scene, instances, notes)
    anatomy, landmarks, unread = described(document, instances[-1].stop)
    groups, colours = vertex_groups(instances)
    rig = Rig(
        _neutral(document, scene, instances, binding.to_world, groups),
        _blendshapes(document, instances, binding.to_world[:, :3, :3]),
        None if binding.skin is None else binding.joints.skeleton(scene),
        binding.skin,
        anatomy,
        landmarks,
        name=document.path.stem,
        source=document.path,
        notes=(*notes, *unread),
        colours=colours,
    )
    return Character(document, rig, scene, tuple(binding.joints.nodes), tuple(instances), binding.to_world)


def _check_extensions(document: Document) -> None:
    required = document.top.texts("extensionsRequired") or []
    unknown = [name for name in required if name not in UNDERSTOOD and not name.startswith(LOOKS)]
    if unknown:
        raise FileError(
            f"{document.path} requires the glTF extension {', '.join(map(repr, unknown))}, which mien does not know; "
            "export the file without it."
        )


def _neutral(
    document: Document, scene: Scene, instances: list[Instance], to_world: Floats, groups: dict[str, Ints]
) -> Mesh:
    stored = np.concatenate([part.positions for i in instances for part in i.surface.parts])
    vertices = np.einsum("nab,nb->na", to_world[:, :3, :3], stored) + to_world[:, :3, 3]
    if not np.isfinite(vertices).all():
        raise FileError(f"{document.path} is damaged: its vertices overflow in world space. Export it again.")
    sides = [slice(None, None, -1 if _mirrored(i, scene) else 1) for i in instances]
    triangles = [i.surface.triangles[:, side] + i.start for i, side in zip(instances, sides, strict=True)]
    uv = None
    if any(i.surface.uv is not None for i in instances):
        uv = np.concatenate([_uv(i)[:, side] for i, side in zip(instances, sides, strict=True)])
    return Mesh(vertices, np.concatenate(triangles), uv, groups=groups)


def _mirrored(instance: Instance, scene: Scene) -> bool:
    """Return whether the node turns the mesh inside out, so that its triangles must be turned back."""
    return "skin" not in instance.fields and bool(np.linalg.det(scene.world[instance.node][:3, :3]) < 0)


def _uv(instance: Instance) -> Floats:
    uv = instance.surface.uv
    return np.zeros((len(instance.surface.triangles), 3, 2)) if uv is None else uv


def _blendshapes(document: Document, instances: list[Instance], linear: Floats) -> Blendshapes:
    """Return the shapes of all meshes, those of the same name as one; `linear` `(N, 3, 3)` takes them to the world."""
    names = dict.fromkeys(name for instance in instances for name in instance.names)
    rows = {name: k for k, name in enumerate(names)}
    if len(rows) * linear.shape[0] * 3 > MOST_VALUES:
        raise FileError(f"{document.path}: {len(rows)} shapes of {len(linear)} vertices are more than mien can hold.")
    deltas = np.zeros((len(rows), len(linear), 3))
    for instance in instances:
        for own, part in instance.parts():
            turn = linear[own]
            alike = bool((turn == turn[:1]).all())
            for name, target in zip(instance.names, part.targets, strict=False):
                if target is not None:
                    stored = floats_at(document, target, part.by, "VEC3")
                    deltas[rows[name], own] = stored @ turn[0].T if alike else np.einsum("nab,nb->na", turn, stored)
    return Blendshapes(tuple(rows), deltas)
