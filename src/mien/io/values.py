"""JSON files of mien's own, and the numbers in them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import FileError
from mien.core.arrays import Floats
from mien.io.files import read_text


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


def whole(value: Any, count: int, what: str) -> int:
    """Return a JSON number that says which of `count` things is meant.

    Raises:
        FileError: there is no such thing.
    """
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < count:
        raise FileError(
            f"{what} {short(value)} does not exist: the mesh has {f'0 … {count - 1}' if count else 'none'}."
        )
    return value


def numbers(values: Any, count: int, what: str) -> Floats:
    """Return `count` finite numbers of a JSON list.

    Raises:
        FileError: they are something else.
    """
    good = isinstance(values, list) and len(values) == count and all(is_number(v) for v in values)
    array = np.array(values if good else [], dtype=np.float64)
    if not good or not np.isfinite(array).all():
        raise FileError(f"{what} must be {count} finite numbers, but are {short(values)}.")
    return array


def is_number(value: Any) -> bool:
    """Whether a JSON value is a number that a float can hold (JSON's true and 1e5000-digit integers are not)."""
    return isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**63)


def short(value: Any) -> str:
    """Return a value as an error quotes it."""
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + "…"
