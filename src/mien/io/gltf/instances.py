"""Where the scene shows which mesh, and where its vertices stand among the rig's."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mien.core import FileError, Note
from mien.core.arrays import Ints
from mien.core.rig import Colour
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields
from mien.io.gltf.meshes import Part, Surface, check_size, numbered, read_surface, shape_names
from mien.io.gltf.scene import Scene


@dataclass(frozen=True, eq=False)
class Instance:
    """A node that shows a mesh.

    Attributes:
        node: its number.
        fields: the node itself.
        mesh: the mesh.
        surface: the mesh's content.
        names: the mesh's shapes.
        start: its first vertex among the rig's.
    """

    node: int
    fields: Fields
    mesh: Fields
    surface: Surface
    names: list[str]
    start: int

    @property
    def stop(self) -> int:
        """The vertex after its last."""
        return self.start + self.surface.count

    def parts(self) -> Iterator[tuple[slice, Part]]:
        """Yield the parts with their places among the rig's vertices."""
        at = self.start
        for part in self.surface.parts:
            yield slice(at, at + len(part.positions)), part
            at += len(part.positions)


def read_instances(document: Document, scene: Scene) -> tuple[list[Instance], list[Note]]:
    """Return the meshes that the default scene shows, in the order of the nodes, and what was repaired.

    Raises:
        FileError: a mesh is damaged, or there is no triangle.
    """
    surfaces: dict[int, Surface] = {}
    named: dict[int, list[str]] = {}
    found: list[Instance] = []
    notes: list[Note] = []
    start = triangles = 0
    for node in scene.mesh_nodes:
        fields = scene.nodes[node]
        index = fields.integer("mesh")
        mesh = document.at("meshes", index, fields)
        if index not in surfaces:
            surfaces[index] = read_surface(document, mesh)
            named[index], renamed = shape_names(mesh)
            notes += [*surfaces[index].notes, *renamed, *_default_weights(mesh)]
        if surfaces[index].count:
            found.append(Instance(node, fields, mesh, surfaces[index], named[index], start))
            start, triangles = found[-1].stop, triangles + len(surfaces[index].triangles)
            check_size(fields, start, triangles)
    if not triangles:
        raise FileError(
            f"{document.path} shows no triangles in its default scene; export the character's mesh with it."
        )
    return found, notes


def _default_weights(mesh: Fields) -> Iterator[Note]:
    if any(mesh.numbers("weights") or []):
        yield Note("default-weights", "weights other than 0 by default: the neutral is without them", mesh.where)


def vertex_groups(instances: list[Instance]) -> tuple[dict[str, Ints], dict[str, Colour]]:
    """Return the vertices of each mesh node, and of each material where a mesh has several primitives.

    The second thing returned are the colours of those groups whose material says one.
    """
    names: list[str] = []
    groups: list[Ints] = []
    colours: list[Colour | None] = []
    for instance in instances:
        own = instance.fields.text("name") or instance.mesh.text("name") or f"node_{instance.node:02d}"
        painted = instance.surface.painted
        names.append(own)
        groups.append(np.arange(instance.start, instance.stop))
        colours.append(painted[0].colour if len(painted) == 1 else None)
        if len(painted) > 1:
            names += [f"{own}/{paint.material}" for paint in painted]
            groups += [paint.vertices + instance.start for paint in painted]
            colours += [paint.colour for paint in painted]
    found = numbered(names)
    said = {name: colour for name, colour in zip(found, colours, strict=True) if colour is not None}
    return dict(zip(found, groups, strict=True)), said
