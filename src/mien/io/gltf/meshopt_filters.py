"""What meshopt does to values so that they compress better, undone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mien.io.gltf.fields import Fields

Bytes = NDArray[np.uint8]


def octahedral(packed: Fields, values: Bytes) -> Bytes:
    """Unfold unit vectors from the octahedron; rows of four 8- or 16-bit integers.

    Raises:
        FileError: the rows have another size.
    """
    if values.shape[1] not in {4, 8}:
        raise packed.error("uses the filter OCTAHEDRAL on elements that are neither 4 nor 8 bytes")
    stored = values.view(np.int8 if values.shape[1] == 4 else "<i2")
    one = np.maximum(stored[:, 2].astype(np.float32), 1)
    x, y = stored[:, 0] / one, stored[:, 1] / one
    z = 1 - np.abs(x) - np.abs(y)
    fold = np.minimum(z, 0)
    unit = np.stack([x - np.copysign(fold, x), y - np.copysign(fold, y), z], axis=1)
    unit /= np.maximum(np.linalg.norm(unit, axis=1, keepdims=True), np.finfo(np.float32).tiny)
    result = stored.copy()
    result[:, :3] = np.rint(unit * np.iinfo(stored.dtype).max)
    return result.view(np.uint8)


def quaternion(packed: Fields, values: Bytes) -> Bytes:
    """Restore the largest component of unit quaternions; rows of four 16-bit integers.

    Raises:
        FileError: the rows have another size.
    """
    if values.shape[1] != 8:
        raise packed.error("uses the filter QUATERNION on elements that are not 8 bytes")
    stored = values.view("<i2")
    one = np.maximum((stored[:, 3] | 3).astype(np.float32), 1)
    three = stored[:, :3] / one[:, None] * np.float32(np.sqrt(0.5))
    largest = np.sqrt(np.maximum(0, 1 - (three**2).sum(axis=1)))
    place = ((stored[:, 3:] & 3) + np.arange(4)) % 4
    result = np.empty_like(stored)
    parts = np.concatenate([largest[:, None], three], axis=1)
    whole = np.rint(np.clip(parts, -1, 1) * 32767).astype("<i2")
    np.put_along_axis(result, place.astype(np.int64), whole, axis=1)
    return result.view(np.uint8)


def exponential(_: Fields, values: Bytes) -> Bytes:
    """Turn pairs of an 8-bit exponent and a 24-bit mantissa into float32."""
    stored = values.view("<i4")
    exponent, mantissa = stored >> 24, (stored << 8) >> 8
    return np.asarray(np.ldexp(mantissa.astype(np.float64), exponent).astype("<f4").view(np.uint8))


FILTERS: dict[str, Callable[[Fields, Bytes], Bytes]] = {
    "NONE": lambda _, values: values,
    "OCTAHEDRAL": octahedral,
    "QUATERNION": quaternion,
    "EXPONENTIAL": exponential,
}
