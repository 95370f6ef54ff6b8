"""Characters as Wavefront OBJ: a neutral mesh and one file per shape.

Vertex order is what makes one file a shape of another, so it is always the file's,
vertices without a face included.  The format has no unit: values are kept as they
are unless a `scale` is given; retargeting does not depend on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mien.core import Blendshapes, FileError, InputError, Mesh, Note, Rig
from mien.core.arrays import Floats, Ints
from mien.io.files import read_text, written_whole
from mien.io.obj_faces import parsed_faces, polygon_corners, triangulated

_NEUTRAL_NAMES = ("neutral", "base", "rest", "basis")
_FORBIDDEN_IN_FILE_NAMES = set('/\\:*?"<>|')


def read_mesh(path: Path, scale: float = 1.0) -> Mesh:
    """Read one mesh; polygons are triangulated and kept beside their triangles.

    A corner without texture coordinate, in a file that has some, gets (0, 0).

    Args:
        path: the file.
        scale: metres per unit of the file.

    Raises:
        FileError: the file is missing, damaged, or holds no vertex.
    """
    lines = _lines(path)
    vertices = _vertices(path, lines) * scale
    texture = _rows(path, lines, "vt", 1)
    faces, groups = parsed_faces(path, lines, len(vertices), len(texture))
    triangles, corners = triangulated(faces, vertices)
    uv = None
    if (faces.texture >= 0).any():
        texture = np.hstack([texture, np.zeros((len(texture), 1))])[:, :2]
        uv = _flipped(np.vstack([texture, np.zeros((1, 2))]))[faces.texture][corners]
    polygons = None if (faces.sizes == 3).all() else faces.polygons()
    try:
        return Mesh(vertices, triangles, uv, polygons, groups)
    except InputError as error:
        raise FileError(f"{path}: {error}") from None


def read_rig(path: Path, scale: float = 1.0) -> Rig:
    """Read a neutral and its shapes, each a file of the same folder named after its shape.

    Args:
        path: a folder whose neutral is called neutral, base, rest or basis, or the neutral
            file itself; then files with another number of vertices are left out and noted.
        scale: metres per unit of the files.

    Raises:
        FileError: the folder has no clear neutral, or a shape does not fit it.
    """
    folder = path if path.is_dir() else path.parent
    files = sorted(p for p in folder.glob("*") if p.suffix.lower() == ".obj" and p.is_file())
    neutral_file = _neutral_file(folder, files) if path.is_dir() else path
    neutral = read_mesh(neutral_file, scale)
    names, deltas, notes = [], [], []
    for file in files:
        if file.name == neutral_file.name:
            continue
        vertices = _vertices(file, _lines(file)) * scale
        if len(vertices) == len(neutral.vertices):
            names.append(file.stem)
            deltas.append(vertices - neutral.vertices)
            continue
        message = (
            f"{file.name} has {len(vertices)} vertices, but the neutral {neutral_file.name} {len(neutral.vertices)}"
        )
        if path.is_dir():
            raise FileError(f"{folder}: {message}; a shape must be exported with the neutral's vertices and order.")
        notes.append(Note("not-a-shape", message, str(file)))
    name = path.name if path.is_dir() else path.stem
    stacked = np.stack(deltas) if deltas else np.zeros((0, *neutral.vertices.shape))
    try:
        return Rig(neutral, Blendshapes(tuple(names), stacked), name=name, source=path, notes=tuple(notes))
    except InputError as error:
        raise FileError(f"{folder}: {error}") from None


def write_mesh(path: Path, mesh: Mesh) -> None:
    """Write a mesh exactly: polygons where it has them, texture coordinates and groups.

    A face is put in the groups that hold all of its vertices.

    Raises:
        FileError: the file cannot be written.
    """
    _write(path, mesh.vertices, _surface(mesh))


def write_rig(folder: Path, rig: Rig) -> None:
    """Write `neutral.obj` and one file per shape at full weight into a folder, made if need be.

    Raises:
        InputError: a shape's name cannot be a file's name.
        FileError: a file cannot be written.
    """
    for name in rig.blendshapes.names:
        if not name.strip(". ") or _FORBIDDEN_IN_FILE_NAMES & set(name) or name.lower() in _NEUTRAL_NAMES:
            raise InputError(f"the shape {name!r} cannot be a file of its own beside the neutral; rename it.")
    if not folder.is_dir():
        try:
            folder.mkdir()
        except OSError as error:
            raise FileError(f"cannot make the folder {folder}: {error.strerror}.") from None
    surface = _surface(rig.neutral)
    _write(folder / "neutral.obj", rig.neutral.vertices, surface)
    for name, delta in zip(rig.blendshapes.names, rig.blendshapes.deltas, strict=True):
        _write(folder / f"{name}.obj", rig.neutral.vertices + delta, surface)


def _lines(path: Path) -> list[str]:
    text = read_text(path)
    if "\\\n" in text or "\\\r\n" in text:
        text = text.replace("\\\r\n", " ").replace("\\\n", " ")
    return [line.strip() for line in text.replace("\t", " ").split("\n")]


def _vertices(path: Path, lines: Sequence[str]) -> Floats:
    vertices = _rows(path, lines, "v", 3)
    if not len(vertices):
        raise FileError(f"{path} holds no vertex; it is not an OBJ file, or an empty one.")
    return vertices[:, :3]


def _rows(path: Path, lines: Sequence[str], kind: str, least: int) -> Floats:
    """Return the first three numbers after `v`, or two after `vt`; a colour or weight behind them is not read."""
    bodies = [line.split()[1:] for line in lines if line.startswith(f"{kind} ")]
    widths = {len(body) for body in bodies}
    if not widths:
        return np.zeros((0, least))
    if min(widths) < least:
        bad = next(body for body in bodies if len(body) < least)
        raise FileError(f"{path}: the line '{kind} {' '.join(bad)[:60]}' has {len(bad)} numbers; {least} are needed.")
    width = min(3 if kind == "v" else 2, *widths)
    try:
        flat = [float(cell) for body in bodies for cell in body[:width]]
    except ValueError as error:
        raise FileError(
            f"{path}: a line that begins with {kind!r} holds something else than numbers ({error})."
        ) from None
    return np.array(flat).reshape(-1, width)


def _neutral_file(folder: Path, files: Sequence[Path]) -> Path:
    if not files:
        raise FileError(f"{folder} holds no .obj file.")
    named = [file for file in files if file.stem.lower() in _NEUTRAL_NAMES]
    if len(named) == 1 or len(files) == 1:
        return (named or list(files))[0]
    found = "more than one is" if named else "none is"
    listed = ", ".join(file.name for file in (named or files)[:8])
    raise FileError(
        f"{folder}: which of its {len(files)} .obj files is the neutral? It should be called neutral, base, rest or "
        f"basis, but {found} ({listed} …). Rename it, or give the neutral file itself instead of the folder."
    )


def _write(path: Path, vertices: Floats, surface: str) -> None:
    rows = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist())
    with written_whole(path) as temporary:
        temporary.write_text(rows + surface, encoding="utf-8", newline="")


def _surface(mesh: Mesh) -> str:
    """Return everything of an OBJ file but its vertices."""
    polygons, corners = _polygons(mesh)
    lines: list[str] = []
    ends: list[str] | None = None
    if mesh.uv is not None:
        unique, places = np.unique(_flipped(mesh.uv.reshape(-1, 2)), axis=0, return_inverse=True)
        lines += [f"vt {u!r} {v!r}" for u, v in unique.tolist()]
        ends = [f"/{place + 1}" for place in places.ravel().tolist()]
    current = ""
    for face, at, groups in zip(polygons, corners, _groups_of_faces(mesh, polygons), strict=True):
        if groups != current:
            current = groups
            lines.append(f"g {groups}".rstrip())
        texture = [ends[corner] for corner in at] if ends else [""] * len(face)
        lines.append("f " + " ".join(f"{v + 1}{end}" for v, end in zip(face, texture, strict=True)))
    return "\n".join(lines) + "\n"


def _polygons(mesh: Mesh) -> tuple[Sequence[tuple[int, ...]], list[list[int]]]:
    """Return the mesh's polygons and the triangle corners at theirs; triangles if the polygons are not what was cut."""
    if mesh.faces is not None and (corners := polygon_corners(mesh, mesh.faces)) is not None:
        return mesh.faces, corners
    triangles = [tuple(triangle) for triangle in mesh.triangles.tolist()]
    return triangles, [[i, i + 1, i + 2] for i in range(0, 3 * len(triangles), 3)]


def _groups_of_faces(mesh: Mesh, polygons: Sequence[tuple[int, ...]]) -> list[str]:
    names: list[list[str]] = [[] for _ in polygons]
    if mesh.groups and polygons:
        flat: Ints = np.concatenate([np.asarray(face, dtype=np.int64) for face in polygons])
        starts = np.cumsum([0, *(len(face) for face in polygons)])[:-1]
        for name, ids in mesh.groups.items():
            inside = np.zeros(len(mesh.vertices), dtype=bool)
            inside[ids] = True
            for i in np.flatnonzero(np.logical_and.reduceat(inside[flat], starts)).tolist():
                names[i].append("_".join(name.split()) or "unnamed")
    return [" ".join(groups) for groups in names]


def _flipped(uv: Floats) -> Floats:
    """Turn texture coordinates between OBJ's, which count up from the bottom, and glTF's, from the top."""
    return np.asarray(uv * [1, -1] + [0, 1])
