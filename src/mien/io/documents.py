"""The small JSON and CSV files that say which point is which: landmarks, pairs, examples."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Correspondence, Examples, FileError, InputError, Markers, Mesh, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.core.errors import unknown
from mien.geometry.surface import closest_points
from mien.io.files import read_text, written_whole

Spot = Mapping[str, Any]
"""A place in a file's own words: a vertex, a triangle with barycentric weights, a position or a marker."""


def read_landmarks(path: Path) -> dict[str, Spot]:
    """Read a `mien-landmarks` file: names and where each is.

    Raises:
        FileError: not such a file, or an entry that says nothing usable.
    """
    document = _document(path, "mien-landmarks")
    landmarks = document.get("landmarks")
    if not isinstance(landmarks, dict) or not landmarks:
        raise FileError(f'{path} names no landmarks; give {{"landmarks": {{"chin_tip": {{"vertex": 123}}, …}}}}.')
    for name, spot in landmarks.items():
        if not isinstance(spot, dict) or not {"vertex", "triangle", "position", "marker"} & set(spot):
            raise FileError(f"{path}: landmark {name!r} needs a vertex, a triangle, a position or a marker, but is {spot!r}.")
    return landmarks


def landmarks_on_mesh(spots: Mapping[str, Spot], mesh: Mesh, path: Path) -> dict[str, SurfacePoints]:
    """Find landmarks on a mesh.

    Raises:
        FileError: an entry names a vertex or triangle that the mesh does not have, or a marker.
    """
    return {name: _on_mesh(spot, mesh, f"{path}: landmark {name!r}") for name, spot in spots.items()}


def landmarks_on_markers(spots: Mapping[str, Spot], markers: Markers, neutral: Floats, path: Path) -> dict[str, Floats]:
    """Find landmarks among captured markers.

    Args:
        spots: entries with a `marker` name, or a `position` in the space of the capture [m].
        markers: the capture.
        neutral: `(M, 3)` its markers at rest.
        path: the file, for errors.

    Returns:
        Positions `(3,)` at rest.

    Raises:
        FileError: an unknown marker, or an entry that is about a mesh.
    """
    found: dict[str, Floats] = {}
    for name, spot in spots.items():
        if "marker" in spot:
            if spot["marker"] not in markers.names:
                raise FileError(f"{path}: landmark {name!r} is at an {unknown('marker', str(spot['marker']), markers.names)}")
            found[name] = neutral[markers.names.index(spot["marker"])]
        elif "position" in spot:
            found[name] = _numbers(spot["position"], 3, f"{path}: the position of landmark {name!r}")
        else:
            raise FileError(
                f"{path}: landmark {name!r} is a spot on a mesh, but the performance is markers; "
                'name the marker there: {"marker": "…"}.'
            )
    return found


def read_pairs(path: Path, target: Mesh, markers: Sequence[str] | None = None, source: Mesh | None = None) -> Correspondence:
    """Read a `mien-pairs` file.

    Args:
        path: the file.
        target: the character's neutral.
        markers: names of the performance's markers, or
        source: the actor's mesh, when the performance is a mesh.

    Raises:
        FileError: not such a file, an unknown marker or vertex, or something paired twice.
    """
    document = _document(path, "mien-pairs")
    rows = document.get("pairs")
    if not isinstance(rows, list) or not rows:
        raise FileError(f'{path} holds no pairs; give {{"pairs": [{{"source": "Chin", "target": 5069}}, …]}}.')
    names, target_spots, source_spots, confidence = [], [], [], []
    for number, row in enumerate(rows):
        where = f"{path}: pair {number}"
        if not isinstance(row, dict) or "source" not in row or "target" not in row:
            raise FileError(f"{where} needs a source and a target, but is {row!r}.")
        spot = row["source"]
        if source is None:
            if spot not in (markers or ()):
                raise FileError(f"{where} has an {unknown('marker', str(spot), markers or ())}")
        else:
            source_spots.append(_on_mesh(_spot(spot), source, f"{where}, source"))
        names.append(str(spot) if isinstance(spot, str | int) else f"point_{number}")
        target_spots.append(_on_mesh(_spot(row["target"], document.get("target_mesh")), target, f"{where}, target"))
        confidence.append(row.get("confidence", 1.0))
    repeated = sorted({n for n in names if names.count(n) > 1})
    if repeated:
        raise FileError(f"{path} pairs {', '.join(map(repr, repeated[:5]))} more than once; keep one pair of each.")
    return Correspondence(
        tuple(names),
        join(target_spots),
        join(source_spots) if source_spots else None,
        _numbers(confidence, len(names), f"{path}: the confidences"),
    )


def write_pairs(path: Path, pairs: Correspondence, target: Mesh, source: Mesh | None = None) -> None:
    """Write a `mien-pairs` file."""
    rows = []
    for i, name in enumerate(pairs.names):
        spot: Any = name
        if pairs.source is not None and source is not None:
            spot = _say(pairs.source.take(np.array([i])), source)
        row = {"source": spot, "target": _say(pairs.target.take(np.array([i])), target)}
        if pairs.confidence is not None and pairs.confidence[i] < 1:
            row["confidence"] = round(float(pairs.confidence[i]), 4)
        rows.append(row)
    lines = ",\n  ".join(json.dumps(row) for row in rows)
    with written_whole(path) as temporary:
        temporary.write_text(f'{{"format": "mien-pairs", "version": 1,\n "pairs": [\n  {lines}\n ]}}\n', encoding="utf-8")


def read_examples(path: Path) -> Examples:
    """Read labelled frames: a CSV with a `frame` column, or JSON rows with a `frame` entry.

    Raises:
        FileError: no frame column, or a cell that is not a number.
    """
    text = read_text(path)
    if path.suffix.lower() == ".json":
        document = _document(path, "mien-examples")
        rows = document.get("examples", [])
        if not isinstance(rows, list) or not all(isinstance(r, dict) and "frame" in r for r in rows):
            raise FileError(f'{path}: each example needs a frame, as in {{"frame": 120, "jawOpen": 1}}.')
        names = list(dict.fromkeys(key for row in rows for key in row if key != "frame"))
        cells = [[row["frame"], *(row.get(name) for name in names)] for row in rows]
    else:
        table = list(csv.reader(io.StringIO(text)))
        if not table or "frame" not in table[0]:
            raise FileError(f"{path} has no column named 'frame'; its first line is {','.join(table[0])[:120] if table else ''!r}.")
        at = table[0].index("frame")
        names = [n for i, n in enumerate(table[0]) if i not in (at, _index_of(table[0], "time"))]
        keep = [at, *(table[0].index(n) for n in names)]
        cells = [[row[i] if i < len(row) else "" for i in keep] for row in table[1:] if row]
    if not cells:
        raise FileError(f"{path} labels no frame.")
    values = np.array([[_number(c, f"{path}, example {i}") for c in row] for i, row in enumerate(cells)])
    if np.isnan(values[:, 0]).any() or (values[:, 0] % 1 != 0).any() or (values[:, 0] < 0).any():
        raise FileError(f"{path}: frames must be whole numbers from 0.")
    return Examples(values[:, 0].astype(np.int64), tuple(names), values[:, 1:])


def join(points: Sequence[SurfacePoints]) -> SurfacePoints:
    """Put surface points one after another."""
    return SurfacePoints(np.vstack([p.corners for p in points]), np.vstack([p.weights for p in points]))


def _document(path: Path, format_name: str) -> dict[str, Any]:
    try:
        document = json.loads(read_text(path))
    except (json.JSONDecodeError, RecursionError) as error:
        raise FileError(f"{path} is not valid JSON: {error}.") from None
    if not isinstance(document, dict) or document.get("format", format_name) != format_name:
        found = document.get("format") if isinstance(document, dict) else type(document).__name__
        raise FileError(f"{path} is {found!r}; a {format_name!r} file is needed here.")
    if document.get("version", 1) != 1:
        raise FileError(f"{path} is version {document['version']} of {format_name}; this mien reads version 1.")
    return document


def _spot(value: Any, mesh_name: str | None = None) -> Spot:
    spot = {"vertex": value} if isinstance(value, int) else value
    return {**spot, "mesh": mesh_name} if mesh_name and isinstance(spot, dict) else spot


def _on_mesh(spot: Spot, mesh: Mesh, where: str) -> SurfacePoints:
    if not isinstance(spot, Mapping):
        raise FileError(f"{where} must be a vertex number or a triangle with barycentric weights, but is {spot!r}.")
    if "vertex" in spot:
        members = _part(mesh, spot.get("mesh"), where)
        vertex = _whole(spot["vertex"], len(members), f"{where}: vertex")
        return SurfacePoints.at_vertices(members[[vertex]])
    if "triangle" in spot:
        row = _whole(spot["triangle"], len(mesh.triangles), f"{where}: triangle")
        weights = _numbers(spot.get("barycentric", [1 / 3] * 3), 3, f"{where}: barycentric weights")
        try:
            return SurfacePoints(mesh.triangles[[row]], weights[None])
        except InputError as error:
            raise FileError(f"{where}: {error}") from None
    if "position" in spot:
        position = _numbers(spot["position"], 3, f"{where}: position")
        return closest_points(mesh.vertices, mesh.triangles, position[None])[0]
    raise FileError(f"{where} names a marker, but this is a mesh; give a vertex, a triangle or a position.")


def _part(mesh: Mesh, name: str | None, where: str) -> Ints:
    if name is None:
        return np.arange(len(mesh.vertices))
    if name not in mesh.groups:
        raise FileError(f"{where}: {unknown('mesh', name, mesh.groups)}")
    return mesh.groups[name]


def _say(point: SurfacePoints, mesh: Mesh) -> Any:
    weights, corners = point.weights[0], point.corners[0]
    if weights.max() == 1:
        return int(corners[np.argmax(weights)])
    row = np.flatnonzero((mesh.triangles == corners).all(axis=1))
    return {"triangle": int(row[0]), "barycentric": [round(float(w), 9) for w in weights]}


def _whole(value: Any, count: int, what: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < count:
        raise FileError(f"{what} {value!r} does not exist: the mesh has 0 … {count - 1}.")
    return value


def _numbers(values: Any, count: int, what: str) -> Floats:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full(0, np.nan)
    if array.shape != (count,) or not np.isfinite(array).all():
        raise FileError(f"{what} must be {count} finite numbers, but are {values!r}.")
    return array


def _number(cell: Any, where: str) -> float:
    if cell is None or (isinstance(cell, str) and not cell.strip()):
        return float("nan")
    try:
        return float(cell)
    except (TypeError, ValueError):
        raise FileError(f"{where}: {cell!r} is not a number.") from None


def _index_of(names: Sequence[str], name: str) -> int:
    return names.index(name) if name in names else -1
