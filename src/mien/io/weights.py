"""Plain weights over time as comma-separated text: the format people's scripts read.

Written: a header `frame,time,<channel>,…` and one row a frame; time in seconds, dot
decimals, six of them (a weight is rounded to 5e-7), a frame that was not tracked as
blank cells.  Head and eyes are not part of it; use Live Link Face, npz or glTF.

Read: the same, and what other programs make of it: no frame or time column,
semicolons or tabs, decimal commas between semicolons, quoted names, blank cells, a
last row cut short.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

import numpy as np

from mien.core import Clip, FileError, InputError, Note, Rig
from mien.core.arrays import Floats
from mien.io.files import read_text, written_whole
from mien.io.table import is_number, numbers, ranges, rate_of, separator_of

DECIMALS = 6
ASSUMED_FPS = 30.0


def read_clip(path: Path, fps: float | None = None) -> Clip:
    """Read channels over time.

    Args:
        path: the file.
        fps: the frame rate; if None it is told from the times, or 30 and noted where there are none.

    Raises:
        FileError: the file is missing, has no header, or a cell is not a number.
    """
    lines = read_text(path).splitlines()
    header = next((i for i, line in enumerate(lines) if line.strip()), len(lines))
    if header == len(lines):
        raise FileError(f"{path} has no rows; a header and one row a frame are needed.")
    separator = separator_of(lines[header])
    names = _names(path, lines[header], separator)
    rows, notes = _rows(lines[header + 1 :], separator, len(names), str(path))
    values = numbers(path, rows, header + 2, separator, names)
    time = _column(names, values, "time")
    channels = [i for i, name in enumerate(names) if name.lower() not in {"frame", "time"}]
    if not channels:
        raise FileError(f"{path} has the columns {', '.join(names)} but no channel.")
    rate, start = _timing(path, time, fps, notes)
    picked = values[:, channels]
    _note_gaps(picked, notes, str(path))
    return Clip(tuple(names[i] for i in channels), picked, rate, start=start, notes=tuple(notes))


def write_clip(path: Path, clip: Clip, rig: Rig | None = None) -> None:
    """Write the channels of a clip, without head and eyes.

    Args:
        path: where to.
        clip: what is written.
        rig: not used; the signature is that of every clip writer.

    Raises:
        InputError: a channel's name would be no column, or that of the frame or the time.
        FileError: the file cannot be written.
    """
    del rig
    wrong = [name for name in clip.names if name.strip().lower() in {"", "frame", "time"} or len(name.splitlines()) > 1]
    if wrong:
        raise InputError(
            f"cannot write {path}: a column cannot be named {wrong[0]!r}; rename the shape, or write .npz."
        )
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerow(["frame", "time", *clip.names])
    values = np.round(np.column_stack([clip.start + np.arange(len(clip)) / clip.fps, clip.values]), DECIMALS) + 0.0
    row_format = "%d," + ",".join([f"%.{DECIMALS}f"] * values.shape[1]) + "\n"
    for frame, row in enumerate(values.tolist()):
        text.write((row_format % (frame, *row)).replace("." + "0" * DECIMALS, "").replace("nan", ""))
    with written_whole(path) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8", newline="")


def _names(path: Path, header: str, separator: str) -> list[str]:
    names = [name.strip() for name in next(csv.reader([header], delimiter=separator))]
    while names and not names[-1]:
        names.pop()
    if not names or all(is_number(name) for name in names):
        raise FileError(f"{path} begins with numbers; a first line that names the columns is needed.")
    blank = [i + 1 for i, name in enumerate(names) if not name]
    if blank:
        raise FileError(f"{path}: column {blank[0]} has no name in the header.")
    repeated = [name for name, n in Counter(names).items() if n > 1]
    if repeated:
        raise FileError(f"{path} has more than one column named {repeated[0]!r}; rename or remove one.")
    return names


def _rows(lines: Sequence[str], separator: str, width: int, where: str) -> tuple[list[str], list[Note]]:
    """Return the rows that hold cells, without what programs append to them, and what was changed."""
    notes = []
    rows = list(lines)
    while rows and not rows[-1].strip():
        rows.pop()
    if separator == ";" and any("," in row for row in rows):
        rows = [row.replace(",", ".") for row in rows]
        notes.append(Note("decimal-comma", "commas between semicolons are read as decimal points", where))
    rows = [row[:-1] if row.count(separator) == width and row.endswith(separator) else row for row in rows]
    if rows and rows[-1].count(separator) + 1 < width:
        cells = rows.pop().count(separator) + 1
        notes.append(Note("truncated-row", f"the last row has {cells} of {width} cells and is left out", where))
    return rows, notes


def _column(names: Sequence[str], values: Floats, wanted: str) -> Floats | None:
    place = next((i for i, name in enumerate(names) if name.lower() == wanted), None)
    return None if place is None else values[:, place]


def _timing(path: Path, time: Floats | None, fps: float | None, notes: list[Note]) -> tuple[float, float]:
    """Return the frame rate, the given one first, and the time of the first frame [s]."""
    if time is not None and np.isnan(time).any():
        raise FileError(f"{path}: {int(np.isnan(time).sum())} cells of the time column are blank; fill or remove it.")
    start = float(time[0]) if time is not None and len(time) else 0.0
    if fps is not None:
        return fps, start
    if time is None or len(time) < 2:
        message = f"there are no times to tell the frame rate; {ASSUMED_FPS:g} is assumed"
        notes.append(Note("fps-assumed", message, str(path)))
        return ASSUMED_FPS, start
    rate = rate_of(path, time)
    uneven = np.abs(np.diff(time) * rate - 1) > 0.5
    if uneven.any():
        first = int(np.argmax(uneven)) + 1
        message = f"{int(uneven.sum())} steps in time are not one frame; frames are taken as equally spaced"
        notes.append(Note("uneven-times", message, f"{path}, frame {first}"))
    return rate, start


def _note_gaps(values: Floats, notes: list[Note], where: str) -> None:
    lost = np.isnan(values).any(axis=1)
    if lost.any():
        message = f"{int(lost.sum())} frames have blank cells: {ranges(np.flatnonzero(lost).tolist())}"
        notes.append(Note("gaps", message, where))
