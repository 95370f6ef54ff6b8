"""Which frames of a take show what: labelled frames, and frames picked as extremes."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Examples, FileError, InputError
from mien.io.files import read_text, written_whole
from mien.io.values import numbers, read_document, short

LAST_FRAME = 2**53
"""Beyond it a whole number in a text file is not exact."""


def read_examples(path: Path | str) -> Examples:
    """Read labelled frames: a CSV with a `frame` column, or JSON rows with a `frame` entry.

    Raises:
        FileError: no frame column, or a cell that is not a number.
    """
    path = Path(path)
    names, cells = _json_examples(path) if path.suffix.lower() == ".json" else _csv_examples(path)
    if not cells or not names:
        raise FileError(
            f"{path} labels no {'frame' if names else 'parameter'}; give each labelled frame a row: its number, and the "
            "parameters there."
        )
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


def _number(cell: Any, where: str) -> float:
    if cell is None or (isinstance(cell, str) and not cell.strip()):
        return float("nan")
    if isinstance(cell, str):
        try:
            return float(cell)
        except ValueError:
            raise FileError(f"{where}: {short(cell)} is not a number.") from None
    return float(numbers([cell], 1, where)[0])
