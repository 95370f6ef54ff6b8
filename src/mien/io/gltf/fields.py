"""Reading JSON that somebody else wrote.

A glTF file may hold anything where a number is expected.  `Fields` is one JSON
object together with its place in the file, so that every look-up either gives the
expected type or fails with the name of the file and of the property.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mien.core import FileError


@dataclass(frozen=True)
class Fields:
    """One JSON object of a file.

    Attributes:
        path: the file.
        where: the object's place in it, e.g. `meshes[2].primitives[0]`.
        values: the object itself.
    """

    path: Path
    where: str
    values: dict[str, Any]

    def error(self, message: str) -> FileError:
        """Return an error about this object, to be raised."""
        return FileError(f"{self.path}: {self.where} {message}. The file is damaged; export it again.")

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def integer(self, key: str, default: int | None = None, least: int = 0) -> int:
        """Return a whole number of at least `least`.

        Raises:
            FileError: it is missing and has no default, or is something else.
        """
        value = self.values.get(key, default)
        if isinstance(value, float) and math.isfinite(value) and value == int(value):
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise self._wrong(key, f"a whole number of at least {least}")
        return value

    def integers(self, key: str) -> list[int]:
        """Return a list of whole numbers from 0 up; empty if absent.

        Raises:
            FileError: it is something else.
        """
        value = self.values.get(key, [])
        if not isinstance(value, list) or not all(type(item) is int and item >= 0 for item in value):
            raise self._wrong(key, "a list of whole numbers")
        return value

    def numbers(self, key: str, count: int | None = None) -> list[float] | None:
        """Return a list of `count` finite numbers, or None if absent.

        Raises:
            FileError: it is something else.
        """
        if key not in self.values:
            return None
        value = self.values[key]
        if not isinstance(value, list) or not all(_finite(item) for item in value):
            raise self._wrong(key, "a list of finite numbers")
        if count is not None and len(value) != count:
            raise self._wrong(key, f"{count} numbers")
        return [float(item) for item in value]

    def text(self, key: str, default: str = "") -> str:
        """Return a text.

        Raises:
            FileError: it is something else.
        """
        value = self.values.get(key, default)
        if not isinstance(value, str):
            raise self._wrong(key, "a text")
        return value

    def texts(self, key: str) -> list[str] | None:
        """Return a list of texts, or None where there is no such list (`extras` may hold anything)."""
        value = self.values.get(key)
        return value if isinstance(value, list) and all(isinstance(item, str) for item in value) else None

    def inner(self, key: str) -> Fields:
        """Return the object under `key`; an empty one if absent.

        Raises:
            FileError: it is not an object.
        """
        value = self.values.get(key, {})
        if not isinstance(value, dict):
            raise self._wrong(key, "an object")
        return Fields(self.path, f"{self.where}.{key}", value)

    def each(self, key: str) -> list[Fields]:
        """Return the objects of the list under `key`; none if absent.

        Raises:
            FileError: it is not a list of objects.
        """
        value = self.values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self._wrong(key, "a list of objects")
        prefix = f"{self.where}.{key}" if self.where else key
        return [Fields(self.path, f"{prefix}[{i}]", item) for i, item in enumerate(value)]

    def extension(self, *names: str) -> Fields | None:
        """Return the first of these extensions that the object has.

        Raises:
            FileError: it is not an object.
        """
        extensions = self.inner("extensions")
        return next((extensions.inner(name) for name in names if name in extensions), None)

    def _wrong(self, key: str, wanted: str) -> FileError:
        got = repr(self.values[key])[:60] if key in self.values else "nothing"
        return self.error(f"needs {wanted} as {key!r}, but has {got}")


def _finite(value: object) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False
