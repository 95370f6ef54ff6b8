"""Rows of numbers in text files, read quickly and with errors that name the cell.

Three formats are tables of text.  The common case, every cell a number, is one pass
over all cells; only when that fails is each row looked at, to allow blanks and to
say which cell is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from mien.core import FileError
from mien.core.arrays import Floats

_MISSING = {"", "nan", "null", "none", "n/a", "na", "-"}
_RATES = np.array([15, 24, 25, 30, 48, 50, 60, 90, 100, 120, 240], dtype=np.float64)


def numbers(path: Path, lines: Sequence[str], first: int, separator: str, names: Sequence[str]) -> Floats:
    """Return `(len(lines), len(names))` numbers; a blank or `nan` cell is NaN.

    Args:
        path: the file, for errors.
        lines: one row of text each.
        first: the number in the file of the first line, counted from 1.
        separator: what stands between cells.
        names: what the columns are called, for errors.

    Raises:
        FileError: a row has another number of cells, or a cell is not a finite number.
    """
    width = len(names)
    for offset, line in enumerate(lines):
        cells = line.count(separator) + 1
        if cells != width:
            raise FileError(
                f"{path}, line {first + offset}: {cells} cells where the header has {width} columns. "
                "The file is damaged there; export it again or delete the line."
            )
    try:
        flat = [float(cell) for cell in separator.join(lines).split(separator)] if lines else []
    except ValueError:
        flat = [
            _number(path, first + offset, names[column], cell)
            for offset, line in enumerate(lines)
            for column, cell in enumerate(line.split(separator))
        ]
    values = np.array(flat, dtype=np.float64).reshape(len(lines), width)
    if np.isinf(values).any():
        row, column = np.argwhere(np.isinf(values))[0]
        raise FileError(f"{path}, line {first + row}, column {names[column]!r}: infinity is not a usable value.")
    return values


def is_number(cell: str) -> bool:
    """Return whether a cell is a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def separator_of(header: str) -> str:
    """Return the comma, semicolon or tab that occurs most in a header line."""
    return max(",;\t", key=header.count)


def rate_of(path: Path, time: Floats) -> float:
    """Return the frame rate of rising times [s], snapped to a usual one within 0.01 %.

    Raises:
        FileError: the times do not rise.
    """
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    if not step > 0:
        raise FileError(
            f"{path}: the times of its frames do not rise, so there is no frame rate; check the time column."
        )
    steady = float(time[-1] - time[0]) / (len(time) - 1)
    return snapped(1 / (steady if abs(steady - step) < 0.01 * step else step), 1e-4)


def snapped(rate: float, tolerance: float) -> float:
    """Return the usual frame rate within a relative tolerance of `rate`, or `rate` itself."""
    nearest = float(_RATES[np.argmin(np.abs(_RATES - rate))])
    return nearest if abs(nearest - rate) <= tolerance * rate else rate


def ranges(rows: Sequence[int]) -> str:
    """Return rising frame numbers as text, e.g. `3, 7–9`; at most eight ranges."""
    if not len(rows):
        return ""
    breaks = [0, *(i + 1 for i, (a, b) in enumerate(pairwise(rows)) if b != a + 1), len(rows)]
    spans = [(int(rows[a]), int(rows[b - 1])) for a, b in pairwise(breaks)]
    listed = ", ".join(f"{a}" if a == b else f"{a}–{b}" for a, b in spans[:8])
    return listed + (f" … ({len(spans)} ranges)" if len(spans) > 8 else "")


def _number(path: Path, line: int, name: str, cell: str) -> float:
    text = cell.strip().strip('"').strip()
    if text.lower() in _MISSING:
        return float("nan")
    try:
        return float(text)
    except ValueError:
        raise FileError(f"{path}, line {line}, column {name!r}: {text[:40]!r} is not a number.") from None
