"""Decompression of buffer views: the extension EXT_meshopt_compression and its KHR successor.

The bit streams are those of the extensions' specifications: attributes (versions 0
and 1), triangles and index sequences.  The kernels check every read against the end
of the stream and return False for a damaged one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mien.core.arrays import Ints
from mien.io.gltf.fields import Fields
from mien.io.gltf.meshopt_filters import FILTERS

Bytes = NDArray[np.uint8]

MOST_BYTES = 1 << 30
"""The most one view may unpack to; zeros take almost no room, so a small file could claim any amount."""

UNMOVED, LITERAL, PLAIN = 2, 3, 4
WIDTHS = np.array([[0, 1, 2, 4], [1, 2, 4, 8], [0] * 4, [0] * 4, [0, 2, 4, 8]])
"""Bits of a difference, by control mode (the last row is version 0, which has none) and header."""


def decoded(packed: Fields, content: memoryview) -> bytes:
    """Return the bytes of a compressed buffer view.

    Args:
        packed: the extension's object: mode, filter, count, byteStride.
        content: the compressed bytes.

    Raises:
        FileError: the stream does not follow the specification.
    """
    mode, count, stride = packed.text("mode"), packed.integer("count", least=1), packed.integer("byteStride", least=1)
    stream = np.frombuffer(content, np.uint8)
    if mode == "ATTRIBUTES":
        return _attributes(packed, stream, count, stride)
    if mode not in {"TRIANGLES", "INDICES"} or stride not in {2, 4}:
        raise packed.error(f"has mode {mode!r} with byteStride {stride}, which mien does not know")
    least_bytes = 1 / 3 if mode == "TRIANGLES" else 1
    if count * least_bytes > len(stream) or (mode == "TRIANGLES" and count % 3):
        raise packed.error(f"claims {count} indices in {len(stream)} compressed bytes")
    out = np.zeros(count, np.int64)
    if not (_triangles if mode == "TRIANGLES" else _indices)(stream.astype(np.int64), out):
        raise packed.error("holds compressed indices that cannot be decoded")
    return out.astype(np.uint16 if stride == 2 else np.uint32).tobytes()


def _attributes(packed: Fields, stream: Bytes, count: int, stride: int) -> bytes:
    if stride % 4 or stride > 256:
        raise packed.error(f"has a byteStride of {stride}; a multiple of 4 up to 256 is needed")
    version = int(stream[0]) - 0xA0
    if version not in {0, 1}:
        raise packed.error(f"holds compressed attributes of an unknown version ({stream[0]:#x})")
    tail = stride + (stride // 4) * version
    padded = max(tail, 24 if version else 32)
    # sixteen equal bytes take two bits, or in version 1 four times 256 of them one byte
    most = min(MOST_BYTES, (len(stream) - padded) * (1024 if version else 64))
    if count * stride > most:
        raise packed.error(f"claims {count} elements of {stride} bytes in {len(stream)} compressed bytes")
    deltas = np.zeros((count, stride), np.uint8)
    if not _deltas(stream[1 : len(stream) - padded].astype(np.int64), version, deltas):
        raise packed.error("holds compressed attributes that cannot be decoded")
    ending = stream[len(stream) - tail :]
    channels = ending[stride:] if version else np.zeros(stride // 4, np.uint8)
    values = np.empty((count, stride), np.uint8)
    for i, channel in enumerate(channels):
        four = slice(4 * i, 4 * i + 4)
        values[:, four] = _accumulated(packed, deltas[:, four], ending[four], int(channel))
    name = packed.text("filter", "NONE")
    if name not in FILTERS:
        raise packed.error(f"has the unknown filter {name!r}")
    return FILTERS[name](packed, values).tobytes()


def _accumulated(packed: Fields, deltas: Bytes, first: Bytes, channel: int) -> Bytes:
    """Undo the differences between consecutive elements of one four-byte channel."""
    mode, turn = channel & 15, channel >> 4
    if mode > 2 or (mode < 2 and turn):
        raise packed.error(f"uses the unknown channel mode {channel:#x}")
    dtype = np.dtype((np.uint8, "<u2", "<u4")[mode])
    steps: NDArray[Any] = np.ascontiguousarray(deltas).view(dtype)
    start: NDArray[Any] = np.ascontiguousarray(first).view(dtype)
    if mode == 2:
        steps = (steps << turn) | (steps >> ((32 - turn) & 31))
        return np.asarray(np.bitwise_xor.accumulate(np.concatenate([start[None], steps]))[1:].view(np.uint8))
    signed = (steps >> 1) ^ (0 - (steps & 1)).astype(dtype)
    return np.asarray((np.cumsum(signed, axis=0, dtype=dtype) + start).astype(dtype).view(np.uint8))


@njit(cache=True)
def _deltas(data: Ints, version: int, out: Bytes) -> bool:
    """Unpack the byte differences of every element; the whole of `data` must be used."""
    count, stride = out.shape
    block = min((8192 // stride) & ~15, 256)
    at = 0
    for start in range(0, count, block):
        size = min(block, count - start)
        groups = (size + 15) // 16
        control = at
        if version:
            at += stride // 4
        if at > len(data):
            return False
        for k in range(stride):
            mode = (data[control + k // 4] >> (2 * (k % 4))) & 3 if version else PLAIN
            if mode == UNMOVED:
                continue
            if mode == LITERAL:
                if at + size > len(data):
                    return False
                out[start : start + size, k] = data[at : at + size]
                at += size
                continue
            header = at
            at += (groups + 3) // 4
            if at > len(data):
                return False
            for g in range(groups):
                width = WIDTHS[mode, (data[header + g // 4] >> (2 * (g % 4))) & 3]
                if at + 2 * width > len(data):
                    return False
                at = _group(data, at, width, out, start + 16 * g, k)
                if at < 0:
                    return False
    return bool(at == len(data))


@njit(cache=True)
def _group(data: Ints, at: int, width: int, out: Bytes, row: int, k: int) -> int:
    """Unpack 16 differences of `width` bits, whose largest value announces a full byte; return where they end."""
    if width == 0:
        return at
    escape = (1 << width) - 1
    further = at + 2 * width
    for i in range(16):
        bit = i * width
        low = bit % 8 if width == 1 else 8 - width - bit % 8
        value = (data[at + bit // 8] >> low) & escape
        if value == escape and width < 8:
            if further >= len(data):
                return -1
            value = data[further]
            further += 1
        if row + i < len(out):
            out[row + i, k] = value
    return further


@njit(cache=True)
def _varint(data: Ints, at: int, end: int) -> tuple[int, int]:
    """Read an unsigned LEB128 number of at most five bytes; return it and where it ends, -1 if it does not."""
    value = 0
    for i in range(5):
        if at + i >= end:
            return 0, -1
        value |= (data[at + i] & 127) << (7 * i)
        if data[at + i] < 128:
            return value & 0xFFFFFFFF, at + i + 1
    return 0, -1


@njit(cache=True)
def _zigzag(value: int) -> int:
    return -(value >> 1) - 1 if value & 1 else value >> 1


@njit(cache=True)
def _indices(data: Ints, out: Ints) -> bool:
    """Decode an index sequence: differences from one of two running baselines."""
    end = len(data) - 4
    if end < 1 or data[0] != 0xD1:
        return False
    last = np.zeros(2, np.int64)
    at = 1
    for i in range(len(out)):
        value, at = _varint(data, at, end)
        if at < 0:
            return False
        which = value & 1
        last[which] = (last[which] + _zigzag(value >> 1)) & 0xFFFFFFFF
        out[i] = last[which]
    return bool(at == end)


@njit(cache=True)
def _triangles(data: Ints, out: Ints) -> bool:
    """Decode a triangle list: one code byte each, naming recent edges and vertices."""
    n = len(out) // 3
    end = len(data) - 16
    at = 1 + n
    if end < at or data[0] != 0xE1:
        return False
    edges, recent = np.zeros((16, 2), np.int64), np.zeros(16, np.int64)
    edge_count = vertex_count = fresh = last = 0
    corners, sources = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for t in range(n):
        high, low = data[1 + t] >> 4, data[1 + t] & 15
        if high < 15:  # a recent edge and one more vertex
            if high >= edge_count:
                return False
            corners[:2] = edges[(edge_count - 1 - high) & 15]
            if low == 0:
                corners[2] = fresh
                fresh += 1
            elif low < 13:
                if low >= vertex_count:
                    return False
                corners[2] = recent[(vertex_count - 1 - low) & 15]
            else:
                step = 1 if low == 14 else -1
                if low == 15:
                    step, at = _varint(data, at, end)
                    if at < 0:
                        return False
                    step = _zigzag(step)
                last = (last + step) & 0xFFFFFFFF
                corners[2] = last
            if low == 0 or low >= 13:
                recent[vertex_count & 15] = corners[2]
                vertex_count += 1
        else:  # three vertices: fresh (0), recent (1 … 14) or explicit (15) each
            pair = data[end + low]
            if low >= 14:
                if at >= end:
                    return False
                pair = data[at]
                at += 1
                if pair == 0:
                    fresh = 0
            sources[0], sources[1], sources[2] = (15 if low == 15 else 0), pair >> 4, pair & 15
            for i in range(3):
                if sources[i] == 0:
                    corners[i] = fresh
                    fresh += 1
                elif sources[i] < 15:
                    if sources[i] > vertex_count:
                        return False
                    corners[i] = recent[(vertex_count - sources[i]) & 15]
                else:
                    step, at = _varint(data, at, end)
                    if at < 0:
                        return False
                    last = (last + _zigzag(step)) & 0xFFFFFFFF
                    corners[i] = last
            for i in range(3):
                if sources[i] == 0 or sources[i] == 15:
                    recent[vertex_count & 15] = corners[i]
                    vertex_count += 1
            edges[edge_count & 15] = corners[1::-1]
            edge_count += 1
        edges[edge_count & 15] = corners[:0:-1]
        edges[(edge_count + 1) & 15] = corners[::2]
        edge_count += 2
        out[3 * t : 3 * t + 3] = corners
    return bool(at == end)
