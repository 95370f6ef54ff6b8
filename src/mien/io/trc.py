"""Markers as tab-separated text (TRC), as optical systems and OpenSim exchange them.

Three header lines give rate, unit and names, then one row a frame: number, time and
three coordinates a marker.  Axes stay as they are in the file; retargeting finds the
face's own.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from mien.core import FileError, InputError, Markers, Note
from mien.io.files import read_text, written_whole
from mien.io.labels import metres_per, named_markers, without_zeros
from mien.io.table import is_number, numbers


def read_markers(path: Path) -> Markers:
    """Read markers; blanks, `NaN` and exact zeros are gaps.

    Raises:
        FileError: the file is missing, damaged, or not a TRC file.
    """
    text = read_text(path)
    lines = text.splitlines()
    header = _header(path, lines)
    labels_line = next((i for i, line in enumerate(lines) if line.lower().startswith("frame#")), None)
    if labels_line is None:
        raise FileError(f"{path} has no line that begins with Frame#, which names the markers; it is not a TRC file.")
    separator = "\t" if "\t" in lines[labels_line] else r"[ ,;]+"
    labels = [label for label in re.split(separator, lines[labels_line])[2:] if label.strip()]
    if not labels:
        raise FileError(f"{path}, line {labels_line + 1} names no markers.")
    first = next((i for i in range(labels_line + 1, len(lines)) if _is_row(lines[i], separator)), len(lines))
    notes: list[Note] = []
    rows = _rows(
        lines[first:], separator, 2 + 3 * len(labels), cut=not text.endswith("\n"), notes=notes, where=str(path)
    )
    if not rows:
        raise FileError(f"{path} names {len(labels)} markers but has no frame.")
    columns = ["Frame#", "Time", *(f"{label} {axis}" for label in labels for axis in "XYZ")]
    values = numbers(path, rows, first + 1, "\t", columns)
    _check_counts(header, len(labels), len(rows), notes, str(path))
    names, kept = named_markers(labels, notes, str(path))
    if not names:
        raise FileError(f"{path}: none of its {len(labels)} markers has a label; label them before export.")
    points = values[:, 2:].reshape(len(rows), -1, 3)[:, kept]
    points = without_zeros(points, notes, str(path)) * metres_per(header.get("units", ""), notes, str(path))
    try:
        return Markers(names, points, _rate(path, header), notes=tuple(notes))
    except InputError as error:
        raise FileError(f"{path}: {error}") from None


def write_markers(path: Path, markers: Markers) -> None:
    """Write markers in millimetres with five decimals; gaps are blank.

    Raises:
        FileError: the file cannot be written.
    """
    count, rate = len(markers.names), f"{markers.fps:.10g}"
    axes = "\t".join(f"X{i}\tY{i}\tZ{i}" for i in range(1, count + 1))
    labels = "\t\t\t".join(re.sub(r"\s+", "_", name) for name in markers.names)
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{rate}\t{rate}\t{len(markers)}\t{count}\tmm\t{rate}\t1\t{len(markers)}",
        f"Frame#\tTime\t{labels}",
        f"\t\t{axes}",
        "",
    ]
    row_format = "%d\t%.6f" + "\t%.5f" * (3 * count)
    for frame, row in enumerate((markers.points * 1000).reshape(len(markers), -1).tolist()):
        lines.append((row_format % (frame + 1, frame / markers.fps, *row)).replace("nan", ""))
    with written_whole(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="")


def _header(path: Path, lines: Sequence[str]) -> dict[str, str]:
    """Return the values under the line that begins with DataRate, by lower-case name."""
    for names, values in pairwise(lines):
        if names.lower().startswith("datarate"):
            return dict(zip(names.lower().split(), values.split(), strict=False))
    raise FileError(f"{path} has no line that begins with DataRate; it is not a TRC file.")


def _rate(path: Path, header: dict[str, str]) -> float:
    text = header.get("datarate", "")
    if not is_number(text):
        raise FileError(f"{path}: the DataRate {text[:20]!r} is not a number.")
    return float(text)


def _is_row(line: str, separator: str) -> bool:
    return is_number(re.split(separator, line.lstrip(" "), maxsplit=1)[0])


def _rows(lines: Sequence[str], separator: str, width: int, *, cut: bool, notes: list[Note], where: str) -> list[str]:
    """Return rows of `width` cells separated by tabs.

    Programs leave out trailing blanks, so a short row means markers not seen; but a
    short last row that no line end follows is one that was cut off in writing.
    """
    rows = [line if separator == "\t" else re.sub(separator, "\t", line.strip()) for line in lines if line.strip()]
    rows = [row.rstrip("\t") if row.count("\t") >= width else row for row in rows]
    if rows and cut and rows[-1].count("\t") + 1 < width:
        cells = rows.pop().count("\t") + 1
        notes.append(Note("truncated-row", f"the last row has {cells} of {width} cells and is left out", where))
    return [row + "\t" * (width - 1 - row.count("\t")) for row in rows]


def _check_counts(header: dict[str, str], markers: int, frames: int, notes: list[Note], where: str) -> None:
    for name, found in (("nummarkers", markers), ("numframes", frames)):
        told = header.get(name, "")
        if is_number(told) and float(told) != found:
            message = f"the header says {name} {told[:20]}, but there are {found}"
            notes.append(Note("count-differs", message, where))
