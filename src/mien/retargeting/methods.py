"""Every retargeting method, one row each: the command line, the docs and the contract tests read this table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from importlib import import_module
from typing import Any

from mien.core import InputError
from mien.core.errors import unknown
from mien.retargeting.method import Method

_ROWS = {
    "range-of-motion": "range_of_motion:RangeOfMotion",
    "layers": "layers:Layers",
    "latent": "few_labels:Latent",
    "example-based": "example_based:ExampleBased",
    "spacetime": "spacetime:Spacetime",
    "rbf": "rbf:Rbf",
    "direct": "direct:Direct",
    "copy": "copying:Copy",
    "sgplvm": "latent.method:Sgplvm",
    "gpr": "regression.methods:Gpr",
    "svr": "regression.methods:Svr",
    "ridge": "regression.methods:Ridge",
    "cross-mapping": "regression.methods:CrossMapping",
}
"""Each method's name, and the module and class it is."""


class MethodTable(Mapping[str, type[Method]]):
    """The methods by name, each imported when it is first looked up: a command needs one, and all take a while."""

    def __getitem__(self, name: str) -> type[Method]:
        """Return a method."""
        module, _, kind = _ROWS[name].partition(":")
        return getattr(import_module(f"mien.retargeting.{module}"), kind)  # type: ignore[no-any-return]

    def __iter__(self) -> Iterator[str]:
        """Go over the names."""
        return iter(_ROWS)

    def __len__(self) -> int:
        """Return how many methods there are."""
        return len(_ROWS)


METHODS: Mapping[str, type[Method]] = MethodTable()


def make_method(name: str, settings: dict[str, Any] | None = None) -> Method:
    """Make a method by name, with some of its parameters changed.

    Args:
        name: a key of `METHODS`.
        settings: parameter names and values, of the method or of its solve; `preset` names
            a whole set of them (`paper`: as published), which the others then change.

    Raises:
        InputError: unknown method or parameter, or a value of the wrong kind.
    """
    if name not in METHODS:
        raise InputError(unknown("method", name, METHODS))
    method: Any = METHODS[name]()
    given = dict(settings or {})
    preset = given.pop("preset", None)
    if preset is not None:
        known = getattr(method, "presets", {})
        if preset not in known:
            raise InputError(unknown(f"preset of {name!r}", str(preset), known))
        given = {**known[preset], **given}
    for key, value in given.items():
        method = _changed(method, key, value)
    return method  # type: ignore[no-any-return]


def parameters(method: Any) -> dict[str, Any]:
    """Return a method's parameters, those of its parts included, by name."""
    found: dict[str, Any] = {}
    for f in fields(method):
        value = getattr(method, f.name)
        found.update(parameters(value) if is_dataclass(value) else {f.name: value})
    return found


def _changed(method: Any, key: str, value: Any) -> Any:
    for f in fields(method):
        current = getattr(method, f.name)
        if f.name == key and (not is_dataclass(current) or is_dataclass(value)):
            return replace(method, **{key: _as_kind(key, value, current)})
        if is_dataclass(current) and key in parameters(current):
            return replace(method, **{f.name: _changed(current, key, value)})
    raise InputError(unknown(f"parameter of {method.name!r}", key, parameters(method)))


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _pairs(text: str) -> tuple[tuple[str, str], ...]:
    """Read `a:b,c:d`."""
    found = [tuple(part.strip() for part in item.rsplit(":", 1)) for item in _names(text)]
    if not all(len(pair) == 2 and all(pair) for pair in found):
        raise ValueError
    return tuple((pair[0], pair[1]) for pair in found)


def _factors(text: str) -> dict[str, float]:
    return {name: float(factor) for name, factor in _pairs(text)}


def _bounds(text: str) -> tuple[float, float] | None:
    if text.strip().lower() == "none":
        return None
    ((low, high),) = _pairs(text)
    return float(low), float(high)


WRITTEN: dict[str, tuple[Callable[[str], Any], str]] = {
    "masks": (_names, "vertex groups, as in body,mouths,eyes"),
    "lips": (_names, "two markers, as in Mouth_Up,Mouth_Down"),
    "regions": (_names, "words in names, as in brow,eye; or auto"),
    "planar": (_names, "names of markers, as in lip_1,lip_2"),
    "off": (_names, "names or patterns, as in viseme_*,tongueOut"),
    "exclusive": (_pairs, "pairs, as in jawLeft:jawRight,mouthLeft:mouthRight"),
    "symmetric": (_pairs, "pairs, as in eyeBlinkLeft:eyeBlinkRight"),
    "shape_sparsity": (_factors, "factors, as in tongueOut:5,jawForward:2"),
    "bounds": (_bounds, "lowest:highest, as in 0:1, or none"),
}
"""How parameters that are not one number are written on the command line."""


def _as_kind(key: str, value: Any, current: Any) -> Any:
    if not isinstance(value, str):
        return value
    if key in WRITTEN:
        read, wanted = WRITTEN[key]
        try:
            return read(value)
        except ValueError:
            raise InputError(f"{key} must be {wanted}, but is {value!r}.") from None
    try:
        if isinstance(current, bool):
            return {"true": True, "false": False}[value.lower()]
        if isinstance(current, int | float):
            number = type(current)(value)
            if not math.isfinite(number):
                raise ValueError
            return number
    except (KeyError, ValueError):
        raise InputError(f"{key} must be a {type(current).__name__}, but is {value!r}.") from None
    if isinstance(current, str):
        return value
    raise InputError(f"{key} cannot be set to {value!r} on the command line; set it from Python.")
