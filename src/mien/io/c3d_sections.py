"""The sections of a C3D file: header, parameters and frames, read with every size checked.

A C3D file says of itself where things are and how many.  The common C++ reader
believes it, and a damaged file makes it crash the process or run on; it also returns
a cut-off file without a word.  So mien reads the sections itself.  All three
processors' number formats are understood (https://www.c3d.org/docs/C3D_User_Guide.pdf).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import FileError
from mien.core.arrays import Floats

BLOCK = 512
_MOST_IN_HEADER = 65535
_INTEL, _DEC, _MIPS = 84, 85, 86
_ITEM_SIZES = {-1: 1, 1: 1, 2: 2, 4: 4}


@dataclass(frozen=True)
class Sections:
    """What a file holds, before its labels and units are looked at.

    Attributes:
        parameters: values by `GROUP:NAME`, upper case: a list of text, or an array of numbers.
        points: `(F, M, 3)` in the file's unit.
        unseen: `(F, M)` where the residual is negative.
        fps: frames per second.
        declared: how many frames the file says it has.
    """

    parameters: dict[str, Any]
    points: Floats
    unseen: NDArray[np.bool_]
    fps: float
    declared: int


@dataclass(frozen=True)
class _Numbers:
    """How the processor that wrote the file stores numbers."""

    processor: int

    @property
    def order(self) -> str:
        return ">" if self.processor == _MIPS else "<"

    def integers(self, content: bytes, *, signed: bool = True) -> NDArray[np.int64]:
        return np.frombuffer(content, dtype=f"{self.order}{'i' if signed else 'u'}2").astype(np.int64)

    def floats(self, content: bytes) -> Floats:
        if self.processor == _DEC:  # VAX F_floating: the halves are swapped and the exponent is two larger
            halves = np.frombuffer(content, dtype="<u2").reshape(-1, 2)[:, ::-1]
            return np.ascontiguousarray(halves).view("<f4").ravel().astype(np.float64) / 4
        return np.frombuffer(content, dtype=f"{self.order}f4").astype(np.float64)


def read_sections(path: Path, content: bytes) -> Sections:
    """Read the three sections of a C3D file.

    Raises:
        FileError: it is not a C3D file, its sections contradict its length, or no whole frame is there.
    """
    if len(content) < 2 * BLOCK or content[1] != 0x50:
        raise FileError(f"{path} is not a C3D file: its second byte is not 0x50 or it is shorter than two blocks.")
    place = (max(content[0], 1) - 1) * BLOCK
    if place + 4 > len(content) or content[place + 3] not in (_INTEL, _DEC, _MIPS):
        raise FileError(f"{path}: the parameter section that the C3D header points to (byte {place}) is not there.")
    read = _Numbers(content[place + 3])
    parameters = _parameters(path, content, place + 4, read)
    words = read.integers(content[:24], signed=False)
    count, analog, first, last = (int(words[i]) for i in (1, 2, 3, 4))
    scale, rate = (float(read.floats(content[at : at + 4])[0]) for at in (12, 20))
    start = (_number(parameters, "POINT:DATA_START") or int(words[8])) * BLOCK - BLOCK
    size = 4 if scale < 0 else 2
    frame_bytes = (4 * count + analog) * size
    declared = _declared_frames(parameters, last - first + 1)
    whole = max(len(content) - start, 0) // frame_bytes if frame_bytes else 0
    if declared == _MOST_IN_HEADER and whole > declared:
        declared = _frames_before_padding(content[start:], frame_bytes)
    frames = min(declared, whole)
    if not count or start < BLOCK or frames < 1:
        raise FileError(
            f"{path} holds no marker frame: its header tells of {count} markers in {declared} frames from byte "
            f"{start}, and the file has {len(content)} bytes. It was cut off or damaged; export it again."
        )
    raw = content[start : start + frames * frame_bytes]
    table = (read.floats(raw) if size == 4 else read.integers(raw).astype(np.float64)).reshape(frames, -1)
    samples = table[:, : 4 * count].reshape(frames, count, 4)
    points = samples[..., :3] * (1.0 if size == 4 else scale)
    fps = _number(parameters, "POINT:RATE", whole=False) or rate
    return Sections(parameters, points, samples[..., 3] < 0, fps, declared)


def _parameters(path: Path, content: bytes, at: int, read: _Numbers) -> dict[str, Any]:
    """Walk the linked list of groups and parameters; each entry must lie after the one before."""
    groups: dict[int, str] = {}
    found: list[tuple[int, str, Any]] = []
    while at + 2 < len(content):
        length, number = (int(n) for n in np.frombuffer(content[at : at + 2], dtype=np.int8))
        length = abs(length)  # negative for a locked one
        body = at + 2 + length + 2
        if not length or not number or body > len(content):
            break
        name = content[at + 2 : at + 2 + length].decode("latin-1").upper()
        if number < 0:
            groups[-number] = name
        else:
            found.append((number, name, _value(path, name, content, body, read)))
        step = int(read.integers(content[body - 2 : body], signed=False)[0])
        if not step:
            break
        at = body - 2 + step
    return {f"{groups.get(number, number)}:{name}": value for number, name, value in found}


def _value(path: Path, name: str, content: bytes, at: int, read: _Numbers) -> Any:
    kind = int.from_bytes(content[at : at + 1], "little", signed=True)
    rank = int.from_bytes(content[at + 1 : at + 2], "little")
    shape = tuple(content[at + 2 : at + 2 + rank])
    start = at + 2 + rank
    size = prod(shape) * _ITEM_SIZES.get(kind, 1)
    if kind not in _ITEM_SIZES or rank > 7 or len(shape) < rank or start + size > len(content):
        raise FileError(f"{path}: its parameter {name[:40]!r} is damaged (type {kind}, size {shape}); export it again.")
    raw = content[start : start + size]
    if kind == -1:
        width = shape[0] if shape else 1
        return [_decoded(raw[i : i + width]) for i in range(0, len(raw), width)] if width else []
    if kind == 1:
        return np.frombuffer(raw, dtype=np.int8).astype(np.float64)
    return read.floats(raw) if kind == 4 else read.integers(raw, signed=False).astype(np.float64)


def _decoded(text: bytes) -> str:
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")


def _number(parameters: dict[str, Any], name: str, *, whole: bool = True) -> Any:
    """Return the first number of a parameter, 0 if it is absent or unusable."""
    value = parameters.get(name)
    if not isinstance(value, np.ndarray) or not value.size or not np.isfinite(value[0]) or value[0] < 0:
        return 0
    return int(value[0]) if whole else float(value[0])


def _declared_frames(parameters: dict[str, Any], header: int) -> int:
    """Return the number of frames, from the parameters where the header's 16 bits may not hold it."""
    ends = [parameters.get(f"TRIAL:ACTUAL_{which}_FIELD") for which in ("START", "END")]
    if all(isinstance(end, np.ndarray) and end.size >= 2 for end in ends):
        first, last = (int(end[0]) + 65536 * int(end[1]) for end in ends if end is not None)
        if last >= first:
            return last - first + 1
    longer = max(_number(parameters, "POINT:LONG_FRAMES"), _number(parameters, "POINT:FRAMES"))
    return max(longer, header) if header >= _MOST_IN_HEADER or header < 1 else header


def _frames_before_padding(content: bytes, frame_bytes: int) -> int:
    """Return how many frames there are when nothing says so: up to the zeros that fill the last block."""
    tail = content[1 - BLOCK :].rstrip(b"\0")
    used = max(len(content) - BLOCK + 1, 0) + len(tail)
    return min(-(-used // frame_bytes), len(content) // frame_bytes)
