"""The faces of an OBJ file: their corners as vertex and texture indices, groups, and triangles."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mien.core import FileError, Mesh
from mien.core.arrays import Floats, Ints

_NO_DIGITS = {ord(digit): None for digit in "0123456789"}


class Faces(NamedTuple):
    """The polygons of a file, their corners one after the other.

    Attributes:
        sizes: `(P,)` corners of each polygon.
        vertices: `(C,)` vertex index of each corner.
        texture: `(C,)` texture coordinate of each corner, -1 where it has none.
    """

    sizes: Ints
    vertices: Ints
    texture: Ints

    def polygons(self) -> tuple[tuple[int, ...], ...]:
        """Return the vertices of each polygon."""
        flat, ends = self.vertices.tolist(), np.cumsum(self.sizes).tolist()
        return tuple(tuple(flat[start:end]) for start, end in pairwise([0, *ends]))


class _Line(NamedTuple):
    """One face as written, with what was defined before it, which negative indices count back from."""

    number: int
    text: str
    vertices: int
    texture: int


def parsed_faces(
    path: Path, lines: Sequence[str], vertex_count: int, texture_count: int
) -> tuple[Faces, dict[str, Ints]]:
    """Return the polygons and the vertices of each group, in the order of the file.

    Raises:
        FileError: a face has fewer than three corners or refers to what is not there.
    """
    found: list[_Line] = []
    owners: list[tuple[str, ...]] = []
    group: tuple[str, ...] = ()
    part: tuple[str, ...] = ()
    vertices = texture = 0
    for number, line in enumerate(lines, 1):
        start = line[:2]
        if start == "v ":
            vertices += 1
        elif start == "f ":
            found.append(_Line(number, line[2:], vertices, texture))
            owners.append(group + part)
        elif start == "vt":
            texture += 1
        elif start in ("g ", "g"):
            group = tuple(line[2:].split())
        elif start in ("o ", "o"):
            part = tuple(line[2:].split(None, 0))
    faces = _uniform(found, vertex_count, texture_count)
    if faces is None:
        faces = _one_by_one(path, found, vertex_count, texture_count)
    return faces, _members(faces, owners)


def triangulated(faces: Faces, vertices: Floats) -> tuple[Ints, Ints]:
    """Cut polygons into triangles: quads along the shorter diagonal, others into a fan.

    Args:
        faces: polygons.
        vertices: `(N, 3)` positions.

    Returns:
        `(T, 3)` vertex indices, and `(T, 3)` places of the same corners in the list of
        all corners of all faces; in the order of the faces.
    """
    sizes, flat, _ = faces
    if not len(sizes):
        return np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3), dtype=np.int64)
    starts = np.cumsum(sizes) - sizes
    pieces, owners = [], []
    for size in np.unique(sizes).tolist():
        here = np.flatnonzero(sizes == size)
        first = starts[here]
        if size == 4:
            a, b, c, d = (vertices[flat[first + i]] for i in range(4))
            turn = ((a - c) ** 2).sum(axis=1) > ((b - d) ** 2).sum(axis=1)
            turned = np.where(turn[:, None], [[1, 2, 3, 1, 3, 0]], [[0, 1, 2, 0, 2, 3]])
            local = turned.reshape(-1, 2, 3)
        else:
            fan = np.array([[0, i, i + 1] for i in range(1, size - 1)])
            local = np.broadcast_to(fan, (len(here), size - 2, 3))
        pieces.append((local + first[:, None, None]).reshape(-1, 3))
        owners.append(np.repeat(here, size - 2))
    order = np.argsort(np.concatenate(owners), kind="stable")
    corners = np.concatenate(pieces)[order]
    return flat[corners], corners


def polygon_corners(mesh: Mesh, polygons: Sequence[tuple[int, ...]]) -> list[list[int]] | None:
    """Return, for each corner of each polygon, a corner of the triangles at the same place.

    Args:
        mesh: the mesh whose triangles are the polygons cut up in order.
        polygons: its polygons.

    Returns:
        Places in the flat list of the triangles' corners, or None if the polygons are
        not what the triangles were cut from.
    """
    if sum(len(face) - 2 for face in polygons) != len(mesh.triangles):
        return None
    flat = mesh.triangles.ravel().tolist()
    found = []
    at = 0
    for face in polygons:
        end = at + 3 * (len(face) - 2)
        place = {flat[corner]: corner for corner in range(at, end)}
        if any(vertex not in place for vertex in face):
            return None
        found.append([place[vertex] for vertex in face])
        at = end
    return found


def _uniform(lines: Sequence[_Line], vertex_count: int, texture_count: int) -> Faces | None:
    """Read faces whose corners are all written alike and counted from 1; None if any is not, or is wrong."""
    sizes = np.array([len(line.text.split()) for line in lines], dtype=np.int64)
    text = " ".join([line.text for line in lines])
    corners = text.translate(_NO_DIGITS).split()
    form = corners[0] if corners else ""
    plain = text.isascii() and (len(corners) == 0 or corners.count(form) == len(corners) == sizes.sum())
    if not plain or form not in ("", "/", "//") or (sizes < 3).any():
        return None
    texture_given = form != "" and "//" not in text
    columns = 1 + len(form) - (form == "//" and not texture_given)
    cells = text.replace("/", " ").split()
    if len(cells) != columns * sizes.sum() or max(map(len, cells), default=0) > 18:
        return None
    table = np.array(list(map(int, cells)), dtype=np.int64).reshape(-1, columns)
    vertices = table[:, 0] - 1
    texture = table[:, 1] - 1 if texture_given else np.full(len(table), -1)
    inside = (vertices >= 0) & (vertices < vertex_count) & (texture < texture_count) & (texture >= -1 + texture_given)
    return Faces(sizes, vertices, texture) if inside.all() else None


def _one_by_one(path: Path, lines: Sequence[_Line], vertex_count: int, texture_count: int) -> Faces:
    read = [_face(path, line, vertex_count, texture_count) for line in lines]
    return Faces(
        np.array([len(vertices) for vertices, _ in read], dtype=np.int64),
        np.array([v - 1 for vertices, _ in read for v in vertices], dtype=np.int64),
        np.array([t - 1 for _, texture in read for t in texture], dtype=np.int64),
    )


def _face(path: Path, line: _Line, vertex_count: int, texture_count: int) -> tuple[list[int], list[int]]:
    """Return vertex and texture indices counted from 1, 0 where a corner has no texture coordinate."""
    text = line.text.partition("#")[0].strip()
    where = f"{path}, line {line.number}: the face '{text[:60]}'"
    try:
        corners = [token.split("/") for token in text.split()]
        vertices = [_absolute(int(c[0]), line.vertices) for c in corners]
        texture = [_absolute(int(c[1]), line.texture) if len(c) > 1 and c[1] else 0 for c in corners]
    except ValueError:
        raise FileError(f"{where} holds something else than indices.") from None
    if len(vertices) < 3:
        raise FileError(f"{where} has {len(vertices)} corners; three or more are needed.")
    for what, found, least, count in (("vertex", vertices, 1, vertex_count), ("texture", texture, 0, texture_count)):
        if min(found) < least or max(found) > count:
            raise FileError(
                f"{where} refers to a {what} that is not there; the file has {count}. "
                "It was cut off or edited; export it again."
            )
    return vertices, texture


def _absolute(index: int, seen: int) -> int:
    """Return an index counted from 1; a negative one counts back from the last seen, -1 if there are not as many."""
    return index if index >= 0 else max(seen + index + 1, 0) or -1


def _members(faces: Faces, owners: Sequence[tuple[str, ...]]) -> dict[str, Ints]:
    rows: dict[str, list[int]] = {}
    for i, names in enumerate(owners):
        for name in names:
            rows.setdefault(name, []).append(i)
    starts = np.cumsum(faces.sizes) - faces.sizes
    members = {}
    for name, ids in rows.items():
        corners = np.concatenate([np.arange(starts[i], starts[i] + faces.sizes[i]) for i in sorted(set(ids))])
        members[name] = np.unique(faces.vertices[corners])
    return members
