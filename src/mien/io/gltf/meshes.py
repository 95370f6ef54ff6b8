"""Meshes: their vertices, triangles and morph targets as the file has them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import Note
from mien.core.arrays import Floats, Ints
from mien.core.rig import Colour
from mien.io.gltf import draco
from mien.io.gltf.accessors import count_of, floats_at, integers_at, real_numbers
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields
from mien.io.gltf.materials import material_colour, material_name

TRIANGLES, STRIP, FAN = 4, 5, 6

MOST_SETS = 8
"""The most sets of four influences per vertex that are believed."""

MOST_VERTICES, MOST_TRIANGLES = 1 << 22, 1 << 23
"""The most a scene may unfold to; a small file can show the same vertices any number of times."""


@dataclass(frozen=True, eq=False)
class Part:
    """Vertices stored together: those of one POSITION accessor.

    Attributes:
        positions: `(n, 3)` in the mesh's own space.
        targets: per morph target the accessor of its displacements, or None where nothing moves.
        influences: per set of four, joint indices and weights, both `(n, 4)`.
        by: the primitive, for errors.
    """

    positions: Floats
    targets: tuple[int | None, ...]
    influences: tuple[tuple[Ints, Floats], ...]
    by: Fields


@dataclass(frozen=True, eq=False)
class Painted:
    """Vertices of one material.

    Attributes:
        material: its name.
        vertices: the vertices its triangles use.
        colour: linear red, green and blue, None where it does not say.
    """

    material: str
    vertices: Ints
    colour: Colour | None


@dataclass(frozen=True, eq=False)
class Surface:
    """What one mesh contributes.

    Attributes:
        parts: its distinct vertices.
        triangles: `(T, 3)` indices into the concatenated vertices of the parts.
        uv: `(T, 3, 2)`, or None if no primitive has texture coordinates.
        painted: per primitive of triangles its material and the vertices it uses.
        owners: per primitive of the file the number of its part; -1 for points and lines.
        notes: what was left out.
    """

    parts: tuple[Part, ...]
    triangles: Ints
    uv: Floats | None
    painted: tuple[Painted, ...]
    owners: tuple[int, ...]
    notes: tuple[Note, ...]

    @property
    def count(self) -> int:
        """The number of vertices."""
        return sum(len(part.positions) for part in self.parts)


def read_surface(document: Document, mesh: Fields) -> Surface:
    """Return the vertices and triangles of a mesh.

    Primitives over the same accessors share their vertices, as they do in the file.

    Raises:
        FileError: something it needs is missing, out of range or not finite.
    """
    parts: dict[tuple[object, ...], tuple[int, int, Part]] = {}
    corners: list[Ints] = []
    uvs: list[Floats | None] = []
    painted: list[Painted] = []
    owners: list[int] = []
    notes: list[Note] = []
    total = 0
    for primitive in mesh.each("primitives"):
        mode = primitive.integer("mode", TRIANGLES)
        if mode not in {TRIANGLES, STRIP, FAN}:
            notes.append(Note("not-triangles", "points or lines are left out", primitive.where))
            owners.append(-1)
            continue
        packed = primitive.extension("KHR_draco_mesh_compression")
        unpacked = {} if packed is None else draco.decoded(document, packed)
        key = _identity(primitive, packed)
        if key not in parts:
            parts[key] = (len(parts), total, _part(document, primitive, unpacked))
            total += len(parts[key][2].positions)
            check_size(mesh, total, 0)
        owner, start, part = parts[key]
        owners.append(owner)
        triangles = unpacked[""] if unpacked else _triangles(document, primitive, mode, len(part.positions))
        if triangles.size and triangles.max() >= len(part.positions):
            raise primitive.error(f"uses vertex {triangles.max()}, but has only {len(part.positions)}")
        uv = _attribute(document, primitive, unpacked, "TEXCOORD_0", "VEC2", len(part.positions))
        corners.append(triangles + start)
        check_size(mesh, total, sum(map(len, corners)))
        uvs.append(None if uv is None else uv[triangles])
        used = np.unique(triangles) + start
        painted.append(Painted(material_name(document, primitive), used, material_colour(document, primitive)))
    has_uv = any(uv is not None for uv in uvs)
    return Surface(
        tuple(part for *_, part in parts.values()),
        np.concatenate([np.empty((0, 3), np.int64), *corners]),
        np.concatenate([np.zeros((len(c), 3, 2)) if u is None else u for c, u in zip(corners, uvs, strict=True)])
        if has_uv
        else None,
        tuple(painted),
        tuple(owners),
        tuple(notes),
    )


def _identity(primitive: Fields, packed: Fields | None) -> tuple[object, ...]:
    """Return what two primitives must have in common to share their vertices."""
    attributes = primitive.inner("attributes")
    names = sorted(name for name in attributes.values if name.startswith(("POSITION", "JOINTS_", "WEIGHTS_")))
    own = [(name, repr(attributes.values[name])) for name in names]
    moved = [repr(target.values.get("POSITION")) for target in primitive.each("targets")]
    return (*own, *moved, None if packed is None else packed.integer("bufferView"))


def _part(document: Document, primitive: Fields, unpacked: dict[str, Any]) -> Part:
    attributes = primitive.inner("attributes")
    if "POSITION" not in attributes:
        raise primitive.error("has no POSITION attribute")
    positions = _attribute(document, primitive, unpacked, "POSITION", "VEC3", None)
    assert positions is not None
    count = len(positions)
    targets = tuple(
        target.integer("POSITION") if "POSITION" in target else None for target in primitive.each("targets")
    )
    for index in targets:
        if index is not None and count_of(document, index, primitive) != count:
            raise primitive.error(f"has {count} vertices, but its target accessors[{index}] another number")
    influences: list[tuple[Ints, Floats]] = []
    while f"JOINTS_{len(influences)}" in attributes:
        n = len(influences)
        if n == MOST_SETS:
            raise primitive.error(f"binds its vertices to more than {4 * MOST_SETS} joints each")
        joints = _attribute(document, primitive, unpacked, f"JOINTS_{n}", "VEC4", count)
        weights = _attribute(document, primitive, unpacked, f"WEIGHTS_{n}", "VEC4", count)
        if joints is None or weights is None:
            raise primitive.error(f"has JOINTS_{n} without WEIGHTS_{n}")
        influences.append((joints.astype(np.int64), weights))
    return Part(positions, targets, tuple(influences), primitive)


def _attribute(
    document: Document, primitive: Fields, unpacked: dict[str, Any], name: str, kind: str, count: int | None
) -> Floats | None:
    """Return a vertex attribute as real numbers, or None if the primitive has none of that name."""
    attributes = primitive.inner("attributes")
    if name not in attributes:
        return None
    index = attributes.integer(name)
    if name in unpacked:
        stored: NDArray[Any] = unpacked[name]
        values = real_numbers(stored, document.at("accessors", index, primitive))
        if values.shape[1] != int(kind[-1]) or not np.isfinite(values).all():
            raise primitive.error(f"has a compressed {name} that is not {kind} of finite numbers")
    else:
        values = floats_at(document, index, primitive, kind)
    if count is not None and len(values) != count:
        raise primitive.error(f"has {count} vertices, but {len(values)} values of {name}")
    return values


def _triangles(document: Document, primitive: Fields, mode: int, count: int) -> Ints:
    if "indices" in primitive:
        order = integers_at(document, primitive.integer("indices"), primitive, "SCALAR")[:, 0]
    else:
        order = np.arange(count)
    if order.size and order.min() < 0:
        raise primitive.error("has negative vertex indices")
    if mode == TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    if mode == FAN:
        triangles = np.stack([order[1:-1], order[2:], np.full(max(len(order) - 2, 0), order[0])], axis=1)
    else:
        triangles = np.stack([order[:-2], order[1:-1], order[2:]], axis=1)
        triangles[1::2] = triangles[1::2, [1, 0, 2]]
    a, b, c = triangles.T
    return np.asarray(triangles[(a != b) & (b != c) & (c != a)])


def shape_names(mesh: Fields) -> tuple[list[str], list[Note]]:
    """Return one distinct name per morph target of a mesh, and what was renamed."""
    primitives = mesh.each("primitives")
    count = max((len(primitive.each("targets")) for primitive in primitives), default=0)
    listed = next((names for holder in [mesh, *primitives] if (names := _listed(holder)) is not None), [])
    wanted = [*listed[:count], *(f"shape_{i:02d}" for i in range(len(listed), count))]
    names = numbered(wanted)
    notes = [
        Note("shape-renamed", f"a second shape named {old!r} is called {new!r}", mesh.where)
        for old, new in zip(wanted, names, strict=True)
        if old != new
    ]
    return names, notes


def _listed(holder: Fields) -> list[str] | None:
    extras = holder.values.get("extras")
    return Fields(holder.path, holder.where, extras).texts("targetNames") if isinstance(extras, dict) else None


def numbered(names: Iterable[str]) -> list[str]:
    """Return the names with the first free number behind each that came before."""
    found: dict[str, None] = {}
    following: dict[str, int] = {}
    for name in names:
        n, free = following.get(name, 2), name
        while free in found:
            free, n = f"{name}_{n}", n + 1
        found[free], following[name] = None, n
    return list(found)


def check_size(by: Fields, vertices: int, triangles: int) -> None:
    """Refuse what no face needs.

    Raises:
        FileError: there are too many vertices or triangles.
    """
    if vertices > MOST_VERTICES or triangles > MOST_TRIANGLES:
        raise by.error(f"unfolds to more than {MOST_VERTICES} vertices or {MOST_TRIANGLES} triangles")
