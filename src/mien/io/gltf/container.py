"""The file as a whole: its JSON, its buffers, and whatever else it carries.

Everything is kept as it came, understood or not, so that writing changes only
what it adds.
"""

from __future__ import annotations

import base64
import binascii
import json
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import unquote

from mien.core import FileError
from mien.io.files import read_bytes, written_whole
from mien.io.gltf.fields import Fields

MAGIC, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")


@dataclass
class Document:
    """A glTF file in memory.

    Attributes:
        path: where it was read from.
        root: its JSON.
        binary: the binary chunk of a .glb.
        further: other chunks of a .glb, headers included, as they were.
    """

    path: Path
    root: dict[str, Any]
    binary: bytes | None = None
    further: bytes = b""
    _buffers: dict[int, bytes] = field(default_factory=dict)
    _views: dict[int, memoryview] = field(default_factory=dict)

    @property
    def top(self) -> Fields:
        """The document's outermost object."""
        return Fields(self.path, "", self.root)

    def at(self, kind: str, index: int, by: Fields) -> Fields:
        """Return element `index` of the top-level list `kind`, which the object `by` refers to.

        Raises:
            FileError: there is no such element.
        """
        elements = self.root.get(kind, [])
        if not isinstance(elements, list) or not 0 <= index < len(elements) or not isinstance(elements[index], dict):
            raise by.error(f"refers to {kind}[{index}], which does not exist")
        return Fields(self.path, f"{kind}[{index}]", elements[index])

    def has_content(self, buffer: Fields) -> bool:
        """Return whether a buffer has bytes of its own, and is no placeholder for decompressed ones."""
        return "uri" in buffer or (self.binary is not None and buffer.where == "buffers[0]")

    def buffer(self, index: int, by: Fields) -> bytes:
        """Return the bytes of a buffer.

        Raises:
            FileError: it does not exist, cannot be read, or is shorter than it says.
        """
        if index not in self._buffers:
            self._buffers[index] = self._read_buffer(self.at("buffers", index, by))
        return self._buffers[index]

    def _read_buffer(self, buffer: Fields) -> bytes:
        if not self.has_content(buffer):
            raise buffer.error("has no data, neither a uri nor a binary chunk")
        content = resource(self.path, buffer, buffer.text("uri")) if "uri" in buffer else self.binary or b""
        length = buffer.integer("byteLength", least=1)
        if length > len(content):
            raise buffer.error(f"should have {length} bytes, but only {len(content)} are there: the data is truncated")
        return content[:length]

    def view(self, index: int, by: Fields) -> memoryview:
        """Return the bytes of a buffer view, decompressed where they are compressed.

        Raises:
            FileError: it does not exist, reaches outside its buffer, or cannot be decompressed.
        """
        if index not in self._views:
            view = self.at("bufferViews", index, by)
            packed = view.extension(*MESHOPT)
            self._views[index] = self._slice(view) if packed is None else self._unpack(packed)
        return self._views[index]

    def _slice(self, view: Fields) -> memoryview:
        content = self.buffer(view.integer("buffer"), view)
        start, length = view.integer("byteOffset", 0), view.integer("byteLength", least=1)
        if start + length > len(content):
            raise view.error(f"needs the bytes {start} … {start + length} of a buffer that has {len(content)}")
        return memoryview(content)[start : start + length]

    def _unpack(self, packed: Fields) -> memoryview:
        from mien.io.gltf.meshopt import decoded  # imports numba, which only compressed files need

        return memoryview(decoded(packed, self._slice(packed)))


def resource(path: Path, by: Fields, uri: str) -> bytes:
    """Return what a URI inside the file at `path` refers to.

    Raises:
        FileError: it is a network address, lies outside the file's folder, or cannot be read.
    """
    if uri.startswith("data:"):
        head, comma, body = uri.partition(",")
        try:
            return base64.b64decode(body, validate=True) if comma and head.endswith(";base64") else b""
        except (binascii.Error, ValueError):
            raise by.error("has a data URI that is not valid base64") from None
    if re.match(r"[A-Za-z][A-Za-z0-9+.\-]*:|//", uri):
        raise FileError(
            f"{path}: {by.where} refers to {uri[:80]!r}, a network or absolute address, which mien does not follow; "
            "save the file with its data embedded or beside it."
        )
    try:
        folder = path.parent.resolve()
        target = (folder / unquote(uri)).resolve()
    except (OSError, RuntimeError, ValueError):
        raise by.error(f"has the uri {uri[:80]!r}, which is no usable file name") from None
    if not target.is_relative_to(folder):
        raise FileError(
            f"{path}: {by.where} refers to {uri[:80]!r}, outside the file's own folder, which mien does not follow; "
            "move that file beside this one."
        )
    return read_bytes(target)


def open_document(path: Path) -> Document:
    """Read a .glb or .gltf file; which of the two it is, its content says.

    Raises:
        FileError: it is neither, or damaged.
    """
    content = read_bytes(path)
    if content[:4] == b"glTF":
        document = _from_chunks(path, content)
    elif content.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] == b"{":
        document = Document(path, _parsed(path, content))
    else:
        raise FileError(
            f"{path} is not a glTF file: it starts with {content[:4]!r} instead of b'glTF' or '{{'; export it as .glb."
        )
    version = document.top.inner("asset").text("version")
    if not version.startswith("2."):
        raise FileError(f"{path} is glTF version {version or '(none)'}; 2.0 is needed. Export it again as glTF 2.0.")
    return document


def _from_chunks(path: Path, content: bytes) -> Document:
    chunks = list(_chunks(path, content))
    if not chunks or chunks[0][0] != JSON_CHUNK:
        raise FileError(f"{path}: the first chunk is not JSON. The file is damaged; export it again.")
    rest = chunks[1:]
    binary = rest.pop(0)[1] if rest and rest[0][0] == BIN_CHUNK else None
    further = b"".join(struct.pack("<II", len(body), kind) + body for kind, body in rest)
    return Document(path, _parsed(path, chunks[0][1]), binary, further)


def _chunks(path: Path, content: bytes) -> Iterator[tuple[int, bytes]]:
    if len(content) < 12:
        raise FileError(f"{path} is truncated: {len(content)} bytes, less than the header of a .glb.")
    _, version, length = struct.unpack_from("<III", content)
    if version != 2:
        raise FileError(f"{path} is a .glb of version {version}; version 2 is needed. Export it again as glTF 2.0.")
    if length > len(content):
        raise FileError(f"{path} is truncated: it should have {length} bytes, but has {len(content)}; copy it again.")
    at = 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", content, at)
        at += 8
        if at + size > length:
            raise FileError(f"{path} is damaged: {size} bytes are announced at byte {at}, but it ends at {length}.")
        yield kind, content[at : at + size]
        at += size + -size % 4


def _parsed(path: Path, text: bytes) -> dict[str, Any]:
    try:
        root = json.loads(text.decode("utf-8-sig"), parse_constant=_no_number)
    except RecursionError:
        raise FileError(f"{path}: its JSON is nested too deeply to be a glTF document.") from None
    except ValueError as error:
        raise FileError(f"{path}: its JSON is damaged: {error}. Export the file again.") from None
    if not isinstance(root, dict):
        raise FileError(f"{path}: its JSON is a {type(root).__name__}, not a glTF document.")
    return root


def _no_number(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number in JSON")


def save(path: Path, document: Document, binary: bytes) -> None:
    """Write a document whose one buffer with data holds `binary`: as .glb, or as .gltf with a .bin beside it.

    Raises:
        FileError: the file cannot be written, or is too large for a .glb.
    """
    if path.suffix.lower() == ".gltf":
        beside = path.with_suffix(".bin")
        document.root["buffers"][0]["uri"] = beside.name
        with written_whole(path) as text, written_whole(beside) as data:
            data.write_bytes(binary)
            text.write_bytes(json.dumps(document.root, indent=1, allow_nan=False).encode())
        return
    described = json.dumps(document.root, separators=(",", ":"), allow_nan=False).encode()
    described += b" " * (-len(described) % 4)
    padding = b"\0" * (-len(binary) % 4)
    length = 28 + len(described) + len(binary) + len(padding) + len(document.further)
    if length >= 1 << 32:
        raise FileError(
            f"cannot write {path}: a .glb holds at most 4 GiB, this would be {length} bytes; write a .gltf."
        )
    with written_whole(path) as temporary, temporary.open("wb") as out:
        out.write(struct.pack("<III", MAGIC, 2, length))
        out.write(struct.pack("<II", len(described), JSON_CHUNK) + described)
        out.write(struct.pack("<II", len(binary) + len(padding), BIN_CHUNK))
        out.write(binary)
        out.write(padding + document.further)
