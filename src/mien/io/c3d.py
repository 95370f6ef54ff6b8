"""Optical markers in C3D, the format of motion-capture systems.

Axes stay as they are in the file; retargeting finds the face's own.  Reading needs
no package; writing uses ezc3d.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mien.core import FileError, InputError, Markers, MissingPackage, Note
from mien.io.c3d_sections import read_sections
from mien.io.files import read_bytes, written_whole
from mien.io.labels import metres_per, named_markers, without_zeros


def read_markers(path: Path) -> Markers:
    """Read markers; NaN, exact zeros and negative residuals are gaps.

    Raises:
        FileError: the file is missing, damaged, or holds no labelled marker.
    """
    sections = read_sections(path, read_bytes(path))
    notes: list[Note] = []
    where = str(path)
    frames, count = sections.points.shape[:2]
    if frames < sections.declared:
        message = f"the file was cut off: {frames} of {sections.declared} frames are there"
        notes.append(Note("truncated-file", message, where))
    labels = (_text(sections.parameters, "POINT:LABELS") + [""] * count)[:count]
    names, kept = named_markers(labels, notes, where)
    if not names:
        raise FileError(f"{path}: none of its {count} markers has a label; label them before export.")
    points = without_zeros(sections.points[:, kept], notes, where, sections.unseen[:, kept])
    unit = next(iter(_text(sections.parameters, "POINT:UNITS", numbered=False)), "")
    try:
        return Markers(names, points * metres_per(unit, notes, where), sections.fps, notes=tuple(notes))
    except InputError as error:
        raise FileError(f"{path}: {error}") from None


def write_markers(path: Path, markers: Markers) -> None:
    """Write markers in millimetres as 32-bit floats; gaps have a residual of -1.

    Raises:
        InputError: there is no frame or no marker.
        MissingPackage: ezc3d is not installed.
        FileError: the file cannot be written.
    """
    if not markers.points.size:
        raise InputError(f"{len(markers)} frames of {len(markers.names)} markers: C3D needs at least one of each.")
    try:
        import ezc3d
    except ImportError:
        raise MissingPackage("writing C3D", "ezc3d", "c3d") from None
    file = ezc3d.c3d()
    point = file["parameters"]["POINT"]
    point["RATE"]["value"] = [markers.fps]
    point["UNITS"]["value"] = ["mm"]
    point["LABELS"]["value"] = tuple(markers.names)
    samples = np.ones((4, len(markers.names), len(markers)))
    samples[:3] = markers.points.transpose(2, 1, 0) * 1000
    file["data"]["points"] = samples
    file["data"]["meta_points"]["residuals"] = np.where(markers.seen, 0.0, -1.0).T[None]
    with written_whole(path) as temporary:
        file.write(str(temporary))


def _text(parameters: dict[str, Any], name: str, *, numbered: bool = True) -> list[str]:
    """Return a list of text, continued in `name2`, `name3` … where one parameter was not enough."""
    value = parameters.get(name)
    texts = list(value) if isinstance(value, list) else []
    number = 2
    while numbered and isinstance(more := parameters.get(f"{name}{number}"), list):
        texts += more
        number += 1
    return texts
