"""Arrays as text in a page: one block of base64, and a table that says what lies where."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.arrays import Floats, Ints

ALIGNED = 4
"""Every array starts at a multiple of this, as browsers demand [bytes]."""

FINEST = 32767
"""Steps from no movement to a shape's largest one; 40 mm come out to within a micrometre."""


def packed(arrays: Mapping[str, NDArray[Any]]) -> tuple[dict[str, tuple[str, int, int]], str]:
    """Return where each array lies, as its element type, first byte and length, and all of them as base64."""
    table, block = {}, bytearray()
    for name, array in arrays.items():
        flat = np.ascontiguousarray(array).reshape(-1)
        block += bytes(-len(block) % ALIGNED)
        table[name] = (flat.dtype.name, len(block), len(flat))
        block += flat.astype(flat.dtype.newbyteorder("<"), copy=False).tobytes()
    return table, base64.b64encode(block).decode("ascii")


def unpacked(table: Mapping[str, tuple[str, int, int]], block: str) -> dict[str, NDArray[Any]]:
    """Return the arrays that `packed` put into a block."""
    content = base64.b64decode(block)
    return {
        name: np.frombuffer(content, np.dtype(kind).newbyteorder("<"), count, start)
        for name, (kind, start, count) in table.items()
    }


def sparse_shapes(deltas: Floats) -> dict[str, NDArray[Any]]:
    """Return shapes `(K, N, 3)` as the vertices that move and their movements in steps of 1/`FINEST` of the largest.

    Returns:
        `first` `(K + 1,)` where each shape begins, `moved` the vertices, `steps` `(…, 3)`, and `step` `(K,)` [m].
    """
    count = len(deltas)
    largest = np.abs(deltas).max(axis=(1, 2), initial=0.0)
    step = np.where(largest > 0, largest, 1) / FINEST
    whole = np.round(deltas / step[:, None, None]).astype(np.int16)
    shape, vertex = np.nonzero(whole.any(axis=2))
    return {
        "first": np.searchsorted(shape, np.arange(count + 1)).astype(np.uint32),
        "moved": numbers(vertex, deltas.shape[1]),
        "steps": whole[shape, vertex],
        "step": step.astype(np.float32),
    }


def numbers(values: Ints, count: int) -> NDArray[Any]:
    """Return indices below `count` in as few bytes as hold them."""
    return values.astype(np.uint16 if count <= 1 << 16 else np.uint32)
