"""Frozen records as plain values and named arrays, and back: how learned models are saved without pickle.

Only the classes of a given table are ever made, so that a hostile file can make nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]


def record(value: Any, arrays: Arrays, path: str = "learnt") -> Any:
    """Return a value as JSON would hold it; arrays are put into `arrays` and stand there under their path."""
    if isinstance(value, np.ndarray):
        arrays[path] = value
        return {"array": path}
    if is_dataclass(value) and not isinstance(value, type):
        parts = {f.name: record(getattr(value, f.name), arrays, f"{path}.{f.name}") for f in fields(value)}
        return {"record": type(value).__name__, "fields": parts}
    if isinstance(value, Mapping):
        return {"mapping": {key: record(item, arrays, f"{path}.{key}") for key, item in value.items()}}
    if isinstance(value, tuple | list):
        return [record(item, arrays, f"{path}.{i}") for i, item in enumerate(value)]
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return {"number": str(value)}
    return value


def restored(found: Any, arrays: Mapping[str, NDArray[Any]], classes: Mapping[str, type[Any]]) -> Any:
    """Return the value that `record` made this from.

    Raises:
        KeyError: an array is missing, or a class is not in the table.
        ValueError: an array does not hold numbers.
        TypeError: a record lacks a field.
    """
    if isinstance(found, list):
        return tuple(restored(item, arrays, classes) for item in found)
    if not isinstance(found, Mapping):
        return found
    if "mapping" in found:
        return {str(key): restored(item, arrays, classes) for key, item in found["mapping"].items()}
    if "number" in found:
        return float(found["number"])
    if "array" in found:
        array = arrays[found["array"]]
        if array.dtype not in (np.float64, np.int64, np.bool_):
            raise ValueError(f"{found['array']} holds {array.dtype}, not numbers")
        return array
    made = classes[found["record"]]
    return made(**{key: restored(item, arrays, classes) for key, item in found["fields"].items()})
