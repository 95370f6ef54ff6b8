"""Checking and freezing arrays as they enter a noun."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mien.core.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


def floats(value: ArrayLike, shape: tuple[int | None, ...], what: str, *, nan: bool = False) -> Floats:
    """Return `value` as a read-only float64 array of the given shape.

    Args:
        value: anything array-like.
        shape: the expected shape; `None` matches any length.
        what: the name used in the error.
        nan: whether NaN is allowed (it means "not seen"); infinity never is.

    Raises:
        InputError: the shape differs or a value is not finite.
    """
    array = _shaped(np.asarray(value, dtype=np.float64), shape, what)
    bad = np.isinf(array) if nan else ~np.isfinite(array)
    if bad.any():
        first = tuple(int(i) for i in np.argwhere(bad)[0])
        kind = "infinite" if nan else "NaN or infinite"
        raise InputError(
            f"{what} holds {int(bad.sum())} {kind} values, the first at index {first}; finite numbers are needed."
        )
    return _frozen(array)


def indices(value: ArrayLike, shape: tuple[int | None, ...], count: int, what: str) -> Ints:
    """Return `value` as a read-only array of indices into something of length `count`.

    Raises:
        InputError: the shape differs or an index is out of range.
    """
    array = _shaped(np.asarray(value, dtype=np.int64), shape, what)
    if array.size and (array.min() < 0 or array.max() >= count):
        worst = int(array.max()) if array.max() >= count else int(array.min())
        raise InputError(f"{what} refers to index {worst}, but only 0 … {count - 1} exist.")
    return _frozen(array)


def distinct(names: Sequence[str], what: str) -> tuple[str, ...]:
    """Return `names` as a tuple, after checking that none repeats.

    Raises:
        InputError: a name occurs twice, or holds half a character (a lone surrogate), which no file can be written with.
    """
    broken = next((name for name in names if str(name).encode("utf-8", "replace").decode() != str(name)), None)
    if broken is not None:
        raise InputError(
            f"{what} must have names that are whole text, but {broken!a} holds half a character; rename it."
        )
    repeated = [name for name, n in Counter(names).items() if n > 1]
    if repeated:
        raise InputError(
            f"{what} must have distinct names, but {', '.join(map(repr, repeated[:5]))} occurs more than once."
        )
    return tuple(str(name) for name in names)


def unique_numbers(values: Ints) -> Ints:
    """Return the sorted distinct numbers of a flat array.

    NumPy's own `unique` hashes integers, which takes fifty times as long on a million of them.
    """
    ordered = np.sort(values)
    return np.asarray(ordered[np.append(np.ones(min(len(ordered), 1), np.bool_), ordered[1:] != ordered[:-1])])


def _shaped(array: NDArray[Any], shape: tuple[int | None, ...], what: str) -> NDArray[Any]:
    fits = array.ndim == len(shape) and all(want in (None, got) for want, got in zip(shape, array.shape, strict=True))
    if not fits:
        wanted = "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
        raise InputError(f"{what} must have shape {wanted}, but has {array.shape}.")
    return array


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    view = array.view()
    view.flags.writeable = False
    return view


def matching(names: Sequence[str], wanted: Sequence[str]) -> Ints:
    """Return where each wanted name stands in `names`, -1 where it is absent."""
    place = {name: i for i, name in enumerate(names)}
    return np.array([place.get(name, -1) for name in wanted], dtype=np.int64)
