"""Accessors: the typed arrays of a glTF file.

Every count is compared with the bytes that are there before anything is
allocated, so a file cannot ask for more memory than it is worth.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core.arrays import Floats, Ints
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
MOST_UNSTORED = 1 << 24
"""The most elements believed of an accessor that stores none: no face needs more."""


def floats_at(document: Document, index: int, by: Fields, kind: str) -> Floats:
    """Return an accessor as `(count, width)` real numbers, with normalized integers scaled to 0 … 1 or -1 … 1.

    Args:
        document: the file.
        index: the accessor.
        by: the object that refers to it.
        kind: the wanted type, e.g. `VEC3`.

    Raises:
        FileError: it does not exist, has another type, reaches outside the data, or holds NaN.
    """
    accessor = document.at("accessors", index, by)
    values = _elements(document, accessor, kind)
    real = real_numbers(values, accessor)
    if values.dtype.kind == "f" and not np.isfinite(real).all():
        row = int(np.argwhere(~np.isfinite(real))[0, 0])
        raise accessor.error(f"(used by {by.where}) holds NaN or infinity, first in element {row}")
    return real


def integers_at(document: Document, index: int, by: Fields, kind: str) -> Ints:
    """Return an accessor of whole numbers as `(count, width)`.

    Raises:
        FileError: as `floats_at`, or the numbers are not whole.
    """
    accessor = document.at("accessors", index, by)
    values = _elements(document, accessor, kind)
    if values.dtype.kind == "f":
        raise accessor.error(f"(used by {by.where}) must hold whole numbers, but holds floats")
    return values.astype(np.int64)


def real_numbers(values: NDArray[Any], accessor: Fields) -> Floats:
    """Return stored numbers as float64, scaled if the accessor says they are normalized."""
    real = values.astype(np.float64)
    if accessor.values.get("normalized") is True and values.dtype.kind in "iu":
        real /= np.iinfo(values.dtype).max
        np.maximum(real, -1, out=real)
    return real


def count_of(document: Document, index: int, by: Fields) -> int:
    """Return the number of elements of an accessor.

    Raises:
        FileError: it does not exist or does not say.
    """
    return document.at("accessors", index, by).integer("count", least=1)


def _elements(document: Document, accessor: Fields, kind: str) -> NDArray[Any]:
    got = accessor.text("type")
    if got != kind:
        raise accessor.error(f"must be of type {kind}, but is {got or 'of none'}")
    dtype = _component(accessor)
    count, width = accessor.integer("count", least=1), WIDTHS[kind]
    sparse = accessor.inner("sparse") if "sparse" in accessor else None
    if "bufferView" in accessor:
        stored = _strided(document, accessor, dtype, count, width)
    elif count > MOST_UNSTORED:
        raise accessor.error(f"claims {count} elements but stores none")
    else:
        stored = np.zeros((count, width), dtype)
    return stored if sparse is None else _with_sparse(document, sparse, stored)


def _component(fields: Fields) -> np.dtype[Any]:
    code = fields.integer("componentType")
    if code not in COMPONENTS:
        raise fields.error(f"has the unknown componentType {code}")
    return np.dtype(COMPONENTS[code])


def _strided(document: Document, fields: Fields, dtype: np.dtype[Any], count: int, width: int) -> NDArray[Any]:
    index = fields.integer("bufferView")
    view = document.at("bufferViews", index, fields)
    content = document.view(index, fields)
    size = dtype.itemsize * width
    stride = view.integer("byteStride", size, least=1)
    start = fields.integer("byteOffset", 0)
    if stride < size:
        raise view.error(f"has a byteStride of {stride}, too small for elements of {size} bytes")
    if start + stride * (count - 1) + size > len(content):
        raise fields.error(
            f"needs {count} × {stride} bytes from byte {start} of {view.where}, which has {len(content)}"
        )
    return np.ndarray((count, width), dtype, content, start, (stride, dtype.itemsize))


def _with_sparse(document: Document, sparse: Fields, base: NDArray[Any]) -> NDArray[Any]:
    count = sparse.integer("count", least=1)
    where, what = sparse.inner("indices"), sparse.inner("values")
    rows = _strided(document, where, _component(where), count, 1)[:, 0]
    if rows.dtype.kind == "f" or rows.max() >= len(base) or rows.min() < 0:
        raise sparse.error(f"replaces elements outside 0 … {len(base) - 1}")
    values = base.copy()
    values[rows] = _strided(document, what, base.dtype, count, base.shape[1])
    return values
