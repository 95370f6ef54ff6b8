"""Adding arrays to a document without touching those it has."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core import FileError, InputError
from mien.io.gltf.container import MESHOPT, Document, resource, save
from mien.io.gltf.fields import Fields

VERTICES, INDICES = 34962, 34963
CODES = {"|u1": 5121, "<u2": 5123, "<u4": 5125, "<f4": 5126}
IMAGES = {
    ".png": "image/png",
    ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
    ".webp": "image/webp",
    ".ktx2": "image/ktx2",
}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Packing:
    """The one buffer that a document is written with: its old bytes in front, new ones behind.

    Several buffers and images beside the file are packed into one, and only the views
    that have to follow are changed.
    """

    def __init__(self, document: Document) -> None:
        self.document = document
        self._pieces: list[bytes] = []
        self._size = 0
        self._join_buffers()
        for image in document.top.each("images"):
            self._embed(image)

    def view(self, content: bytes, target: int | None = None) -> int:
        """Append bytes as a new buffer view and return its number."""
        view: dict[str, Any] = {"buffer": 0, "byteOffset": self._append(content), "byteLength": len(content)}
        if target is not None:
            view["target"] = target
        return self.add("bufferViews", view)

    def array(self, values: ArrayLike, dtype: str, *, target: int | None = None, bounds: bool = False) -> int:
        """Append `(count, width)` numbers as a new accessor and return its number.

        Args:
            values: the numbers.
            dtype: how they are stored, e.g. `<f4`.
            target: what the graphics card uses them for.
            bounds: whether to state their minimum and maximum.

        Raises:
            InputError: a number is too large for single precision.
        """
        stored = _stored(values, dtype)
        accessor = self._described(stored, bounds)
        accessor["bufferView"] = self.view(stored.tobytes(), target)
        return self.add("accessors", accessor)

    def sparse(self, values: ArrayLike, dtype: str) -> int:
        """Append numbers that are mostly zero, storing the rows that are not, if that is smaller."""
        stored = _stored(values, dtype)
        rows = np.flatnonzero(stored.any(axis=1))
        row_size = stored.itemsize * stored.shape[1]
        if len(rows) * (row_size + 4) > stored.nbytes:
            return self.array(stored, dtype, target=VERTICES, bounds=True)
        accessor = self._described(stored, bounds=True)
        if len(rows):
            accessor["sparse"] = {
                "count": len(rows),
                "indices": {"bufferView": self.view(rows.astype("<u4").tobytes()), "componentType": 5125},
                "values": {"bufferView": self.view(stored[rows].tobytes())},
            }
        return self.add("accessors", accessor)

    def add(self, kind: str, element: dict[str, Any]) -> int:
        """Append an element to a top-level list and return its number."""
        elements: list[Any] = self.document.root.setdefault(kind, [])
        elements.append(element)
        return len(elements) - 1

    def write(self, path: Path) -> None:
        """Write the document with everything added.

        Raises:
            FileError: the file cannot be written.
        """
        self.document.root["buffers"][0]["byteLength"] = self._size
        save(path, self.document, b"".join(self._pieces))

    def _append(self, content: bytes) -> int:
        gap = -self._size % 4
        self._pieces += [b"\0" * gap, content]
        start = self._size + gap
        self._size = start + len(content)
        return start

    def _described(self, stored: NDArray[Any], bounds: bool) -> dict[str, Any]:
        accessor: dict[str, Any] = {
            "componentType": CODES[stored.dtype.str],
            "count": len(stored),
            "type": KINDS[stored.shape[1]],
        }
        if bounds:
            accessor["min"], accessor["max"] = stored.min(axis=0).tolist(), stored.max(axis=0).tolist()
        return accessor

    def _join_buffers(self) -> None:
        """Put all buffers that have bytes behind one another, as buffer 0; placeholders follow it."""
        old = self.document.top.each("buffers")
        full = [buffer for buffer in old if self.document.has_content(buffer)]
        empty = [buffer for buffer in old if not self.document.has_content(buffer)]
        numbers = {buffer.where: i for i, buffer in enumerate(old)}
        moved = {numbers[buffer.where]: (1 + i, 0) for i, buffer in enumerate(empty)}
        for buffer in full:
            number = numbers[buffer.where]
            moved[number] = (0, self._append(self.document.buffer(number, buffer)))
        first = {key: value for key, value in full[0].values.items() if key != "uri"} if full else {}
        self.document.root["buffers"] = [{"byteLength": 0, **first}, *(buffer.values for buffer in empty)]
        for view in self.document.top.each("bufferViews"):
            for reference in [view, *(e for name in MESHOPT if (e := view.extension(name)) is not None)]:
                _redirect(reference, moved)

    def _embed(self, image: Fields) -> None:
        """Take an image that lies beside the file into it; one that cannot be read keeps its address."""
        uri = image.text("uri")
        kind = IMAGES.get(Path(uri).suffix.lower())
        if kind is None or uri.startswith("data:"):
            return
        try:
            content = resource(self.document.path, image, uri)
        except FileError:
            return
        del image.values["uri"]
        image.values.setdefault("mimeType", kind)
        image.values["bufferView"] = self.view(content)


def _stored(values: ArrayLike, dtype: str) -> NDArray[Any]:
    with np.errstate(over="ignore"):
        stored = np.ascontiguousarray(values, dtype=dtype)
    if stored.dtype.kind == "f" and not np.isfinite(stored).all():
        raise InputError("a number is too large to be written to glTF, which stores single precision.")
    return stored


def _redirect(reference: Fields, moved: dict[int, tuple[int, int]]) -> None:
    number = reference.integer("buffer")
    if number not in moved:
        raise reference.error(f"refers to buffers[{number}], which does not exist")
    target, shift = moved[number]
    reference.values["buffer"] = target
    if shift:
        reference.values["byteOffset"] = reference.integer("byteOffset", 0) + shift
