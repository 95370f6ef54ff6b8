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

LAST_FRAME = 2**53
"""Beyond it a whole number in a text file is not exact."""

Spot = Mapping[str, Any]
"""A place in a file's own words: a vertex, a triangle with barycentric weights, a position or a marker."""


def read_landmarks(path: Path | str) -> dict[str, Spot]:
    """Read a `mien-landmarks` file: names and where each is.

    Raises:
        FileError: not such a file, or an entry that says nothing usable.
    """
    path = Path(path)
    document = read_document(path, "mien-landmarks")
    landmarks = document.get("landmarks")
    if not isinstance(landmarks, dict) or not landmarks:
        raise FileError(f'{path} names no landmarks; give {{"landmarks": {{"chin_tip": {{"vertex": 123}}, …}}}}.')
    for name, spot in landmarks.items():
        if not isinstance(spot, dict) or not {"vertex", "triangle", "position", "marker"} & set(spot):
            raise FileError(
                f"{path}: landmark {name!r} needs a vertex, a triangle, a position or a marker, but is {_short(spot)}."
            )
    return landmarks


def write_landmarks(path: Path | str, landmarks: Mapping[str, SurfacePoints], mesh: Mesh) -> None:
    """Write a `mien-landmarks` file: each landmark as a vertex, or as a triangle with barycentric weights.

    Raises:
        InputError: a landmark is not on a triangle of the mesh.
        FileError: the file cannot be written.
    """
    spots = {}
    for name, point in landmarks.items():
        spot = _say(point, mesh)
        spots[name] = spot if isinstance(spot, dict) else {"vertex": spot}
    lines = ",\n  ".join(f"{json.dumps(name)}: {json.dumps(spot)}" for name, spot in spots.items())
    with written_whole(Path(path)) as temporary:
        temporary.write_text(
            f'{{"format": "mien-landmarks", "version": 1,\n "landmarks": {{\n  {lines}\n }}}}\n', encoding="utf-8"
        )


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
                raise FileError(
                    f"{path}: landmark {name!r} is at an {unknown('marker', str(spot['marker']), markers.names)}"
                )
            found[name] = neutral[markers.names.index(spot["marker"])]
        elif "position" in spot:
            found[name] = _numbers(spot["position"], 3, f"{path}: the position of landmark {name!r}")
        else:
            raise FileError(
                f"{path}: landmark {name!r} is a spot on a mesh, but the performance is markers; "
                'name the marker there, {"marker": "…"}, or exchange the two landmark files if they are in the wrong order.'
            )
    return found


def read_pairs(
    path: Path | str, target: Mesh, markers: Sequence[str] | None = None, source: Mesh | None = None
) -> Correspondence:
    """Read a `mien-pairs` file.

    Args:
        path: the file.
        target: the character's neutral.
        markers: names of the performance's markers, or
        source: the actor's mesh, when the performance is a mesh.

    Raises:
        FileError: not such a file, an unknown marker or vertex, or something paired twice.
    """
    path = Path(path)
    document = read_document(path, "mien-pairs")
    rows = document.get("pairs")
    if not isinstance(rows, list) or not rows:
        raise FileError(f'{path} holds no pairs; give {{"pairs": [{{"source": "Chin", "target": 5069}}, …]}}.')
    names, target_spots, source_spots, confidence = [], [], [], []
    for number, row in enumerate(rows):
        where = f"{path}: pair {number}"
        if not isinstance(row, dict) or "source" not in row or "target" not in row:
            raise FileError(f"{where} needs a source and a target, but is {_short(row)}.")
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
    certain = _numbers(confidence, len(names), f"{path}: the confidences")
    if (certain < 0).any() or (certain > 1).any():
        wrong = int(np.argmax((certain < 0) | (certain > 1)))
        raise FileError(f"{path}: pair {wrong} has the confidence {certain[wrong]:g}; it must be between 0 and 1.")
    return Correspondence(tuple(names), join(target_spots), join(source_spots) if source_spots else None, certain)


def write_pairs(path: Path | str, pairs: Correspondence, target: Mesh, source: Mesh | None = None) -> None:
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
    with written_whole(Path(path)) as temporary:
        temporary.write_text(
            f'{{"format": "mien-pairs", "version": 1,\n "pairs": [\n  {lines}\n ]}}\n', encoding="utf-8"
        )


def read_examples(path: Path | str) -> Examples:
    """Read labelled frames: a CSV with a `frame` column, or JSON rows with a `frame` entry.

    Raises:
        FileError: no frame column, or a cell that is not a number.
    """
    path = Path(path)
    names, cells = _json_examples(path) if path.suffix.lower() == ".json" else _csv_examples(path)
    if not cells or not names:
        raise FileError(f"{path} labels no {'frame' if names else 'parameter'}.")
    values = np.array([[_number(c, f"{path}, example {i}") for c in row] for i, row in enumerate(cells)])
    frames = values[:, 0]
    if not ((frames >= 0) & (frames <= LAST_FRAME) & (np.floor(frames) == frames)).all():
        raise FileError(f"{path}: frames must be whole numbers from 0.")
    unique, count = np.unique(frames, return_counts=True)
    if (count > 1).any():
        twice = ", ".join(f"{f:g}" for f in unique[count > 1][:6])
        raise FileError(f"{path} labels a frame more than once (frame {twice}); keep the right row of each.")
    try:
        return Examples(frames.astype(np.int64), tuple(names), values[:, 1:])
    except InputError as error:
        raise FileError(f"{path}: {error}") from None


def write_examples(path: Path | str, examples: Examples) -> None:
    """Write labelled frames as a CSV to fill in; what is not labelled is left blank.

    Raises:
        FileError: the file cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["frame", *examples.names])
    for frame, row in zip(examples.frames, examples.values, strict=True):
        table.writerow([int(frame), *("" if np.isnan(v) else f"{v:.6g}" for v in row)])
    with written_whole(Path(path)) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8", newline="")


def read_extremes(path: Path | str) -> Examples:
    """Read which frame of a take shows which extreme of which layer: a CSV with `layer,extreme,frame`.

    Returns:
        One labelled frame per row; the parameters are named `layer.extreme`.

    Raises:
        FileError: a column is missing, a frame is not a whole number, or an extreme stands there twice.
    """
    path = Path(path)
    try:
        rows = list(csv.DictReader(io.StringIO(read_text(path))))
    except csv.Error as error:
        raise FileError(f"{path} is not comma-separated text: {error}.") from None
    wanted = ("layer", "extreme", "frame")
    if not rows or not set(wanted) <= set(rows[0]):
        found = ", ".join(str(name) for name in rows[0]) if rows else "no rows"
        raise FileError(f"{path} must have the columns {', '.join(wanted)} and a row per extreme, but has {found}.")
    names, frames = [], []
    for line, row in enumerate(rows, start=2):
        layer, extreme, frame = (str(row[key] or "").strip() for key in wanted)
        if not layer or not extreme or not frame.isdecimal() or int(frame) > LAST_FRAME:
            raise FileError(
                f"{path}, line {line}: a layer, an extreme and a frame number are needed, as in emotion,joy,120."
            )
        names.append(f"{layer}.{extreme}")
        frames.append(int(frame))
    labels = np.where(np.eye(len(names)) > 0, 1.0, np.nan)
    try:
        return Examples(np.array(frames, dtype=np.int64), tuple(names), labels)
    except InputError as error:
        raise FileError(f"{path}: {error}") from None


def join(points: Sequence[SurfacePoints]) -> SurfacePoints:
    """Put surface points one after another."""
    return SurfacePoints(np.vstack([p.corners for p in points]), np.vstack([p.weights for p in points]))


def _json_examples(path: Path) -> tuple[list[str], list[list[Any]]]:
    """Return the parameters' names, and per example its frame and parameters as the file has them."""
    rows = read_document(path, "mien-examples").get("examples", [])
    if not isinstance(rows, list) or not all(isinstance(r, dict) and "frame" in r for r in rows):
        raise FileError(f'{path}: each example needs a frame, as in {{"frame": 120, "jawOpen": 1}}.')
    names = list(dict.fromkeys(key for row in rows for key in row if key != "frame"))
    return names, [[row["frame"], *(row.get(name) for name in names)] for row in rows]


def _csv_examples(path: Path) -> tuple[list[str], list[list[Any]]]:
    try:
        header, *rows = list(csv.reader(io.StringIO(read_text(path)))) or [[]]
    except csv.Error as error:
        raise FileError(f"{path} is not comma-separated text: {error}.") from None
    columns = [name.strip() for name in header]
    if "frame" not in columns:
        raise FileError(f"{path} has no column named 'frame'; its first line is {','.join(header)[:120]!r}.")
    at = columns.index("frame")
    keep = [i for i, name in enumerate(columns) if i != at and name not in ("", "time")]
    return [columns[i] for i in keep], [[row[i] if i < len(row) else "" for i in (at, *keep)] for row in rows if row]


def read_document(path: Path, format_name: str) -> dict[str, Any]:
    """Read a JSON file of a format of mien's own.

    Raises:
        FileError: not JSON, another format, or a later version.
    """
    try:
        document = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:  # ValueError: also numbers of thousands of digits
        raise FileError(f"{path} is not valid JSON: {str(error).rstrip('.')}.") from None
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
        raise FileError(
            f"{where} must be a vertex number or a triangle with barycentric weights, but is {_short(spot)}."
        )
    if "vertex" in spot:
        members = _part(mesh, spot.get("mesh"), where)
        vertex = _whole(spot["vertex"], len(members), f"{where}: vertex")
        return SurfacePoints.at_vertices(members[[vertex]])
    if "triangle" in spot:
        members = _part(mesh, spot.get("mesh"), where)
        triangles = mesh.triangles[np.isin(mesh.triangles, members).all(axis=1)]
        row = _whole(spot["triangle"], len(triangles), f"{where}: triangle")
        weights = _numbers(spot.get("barycentric", [1 / 3] * 3), 3, f"{where}: barycentric weights")
        if (weights < 0).any():
            raise FileError(f"{where}: barycentric weights must not be negative, but are {weights.tolist()}.")
        try:
            return SurfacePoints(triangles[[row]], weights[None])
        except InputError as error:
            raise FileError(f"{where}: {error}") from None
    if "position" in spot:
        position = _numbers(spot["position"], 3, f"{where}: position")
        return closest_points(mesh.vertices, mesh.triangles, position[None])[0]
    raise FileError(
        f"{where} names a marker, but is to be found on a mesh: give a vertex, a triangle or a position, "
        "or exchange the two landmark files if they are in the wrong order."
    )


def _part(mesh: Mesh, name: Any, where: str) -> Ints:
    if name is None:
        return np.arange(len(mesh.vertices))
    if not isinstance(name, str) or name not in mesh.groups:
        raise FileError(f"{where}: {unknown('mesh', str(name), mesh.groups)}")
    return mesh.groups[name]


def _say(point: SurfacePoints, mesh: Mesh) -> Any:
    weights, corners = point.weights[0], point.corners[0]
    if weights.max() == 1:
        return int(corners[np.argmax(weights)])
    a, b, c = mesh.triangles.T
    inside = (a != b) & (b != c) & (c != a)
    for corner in corners[weights > 0]:
        inside &= (mesh.triangles == corner).any(axis=1)
    row = np.flatnonzero(inside)
    if not len(row) or (weights < 0).any():
        raise InputError(
            f"a point lies on the vertices {corners.tolist()} with the weights {weights.tolist()}, which is inside no "
            "triangle of the mesh; it cannot be written."
        )
    own = [float(weights[corners == corner].sum()) for corner in mesh.triangles[row[0]]]
    return {"triangle": int(row[0]), "barycentric": own}


def _whole(value: Any, count: int, what: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < count:
        raise FileError(
            f"{what} {_short(value)} does not exist: the mesh has {f'0 … {count - 1}' if count else 'none'}."
        )
    return value


def _numbers(values: Any, count: int, what: str) -> Floats:
    good = isinstance(values, list) and len(values) == count and all(is_number(v) for v in values)
    array = np.array(values if good else [], dtype=np.float64)
    if not good or not np.isfinite(array).all():
        raise FileError(f"{what} must be {count} finite numbers, but are {_short(values)}.")
    return array


def is_number(value: Any) -> bool:
    """Whether a JSON value is a number that a float can hold (JSON's true and 1e5000-digit integers are not)."""
    return isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**63)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + "…"


def _number(cell: Any, where: str) -> float:
    if cell is None or (isinstance(cell, str) and not cell.strip()):
        return float("nan")
    if isinstance(cell, str):
        try:
            return float(cell)
        except ValueError:
            raise FileError(f"{where}: {_short(cell)} is not a number.") from None
    return float(_numbers([cell], 1, where)[0])
