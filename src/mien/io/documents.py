"""The small JSON files that say which point is which: landmarks and pairs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Correspondence, FileError, Markers, Mesh, SurfacePoints
from mien.core.arrays import Floats
from mien.core.errors import unknown
from mien.io.files import written_whole
from mien.io.spots import Spot, as_spot, on_mesh, say
from mien.io.values import numbers, read_document, short


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
                f"{path}: landmark {name!r} needs a vertex, a triangle, a position or a marker, but is {short(spot)}."
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
        spot = say(point, mesh)
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
    return {name: on_mesh(spot, mesh, f"{path}: landmark {name!r}") for name, spot in spots.items()}


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
            found[name] = numbers(spot["position"], 3, f"{path}: the position of landmark {name!r}")
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
            raise FileError(f"{where} needs a source and a target, but is {short(row)}.")
        spot = row["source"]
        if source is None:
            if spot not in (markers or ()):
                raise FileError(f"{where} has an {unknown('marker', str(spot), markers or ())}")
        else:
            source_spots.append(on_mesh(as_spot(spot), source, f"{where}, source"))
        names.append(str(spot) if isinstance(spot, str | int) else f"point_{number}")
        target_spots.append(on_mesh(as_spot(row["target"], document.get("target_mesh")), target, f"{where}, target"))
        confidence.append(row.get("confidence", 1.0))
    repeated = sorted({n for n in names if names.count(n) > 1})
    if repeated:
        raise FileError(f"{path} pairs {', '.join(map(repr, repeated[:5]))} more than once; keep one pair of each.")
    certain = numbers(confidence, len(names), f"{path}: the confidences")
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
            spot = say(pairs.source.take(np.array([i])), source)
        row = {"source": spot, "target": say(pairs.target.take(np.array([i])), target)}
        if pairs.confidence is not None and pairs.confidence[i] < 1:
            row["confidence"] = round(float(pairs.confidence[i]), 4)
        rows.append(row)
    lines = ",\n  ".join(json.dumps(row) for row in rows)
    with written_whole(Path(path)) as temporary:
        temporary.write_text(
            f'{{"format": "mien-pairs", "version": 1,\n "pairs": [\n  {lines}\n ]}}\n', encoding="utf-8"
        )


def join(points: Sequence[SurfacePoints]) -> SurfacePoints:
    """Put surface points one after another."""
    return SurfacePoints(np.vstack([p.corners for p in points]), np.vstack([p.weights for p in points]))
