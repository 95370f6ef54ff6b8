"""Every retargeting method, one row each: the command line, the docs and the contract tests read this table."""

from __future__ import annotations

import math
from dataclasses import fields, is_dataclass, replace
from typing import Any

from mien.core import InputError
from mien.core.errors import unknown
from mien.retargeting.copying import Copy
from mien.retargeting.direct import Direct
from mien.retargeting.method import Method
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.rbf import Rbf

METHODS: dict[str, type[Method]] = {method.name: method for method in (RangeOfMotion, Rbf, Direct, Copy)}


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
        if f.name == key and not is_dataclass(current):
            return replace(method, **{key: _as_kind(key, value, current)})
        if is_dataclass(current) and key in parameters(current):
            return replace(method, **{f.name: _changed(current, key, value)})
    raise InputError(unknown(f"parameter of {method.name!r}", key, parameters(method)))


def _as_kind(key: str, value: Any, current: Any) -> Any:
    if not isinstance(value, str):
        return value
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
    raise InputError(
        f"{key} is not a single number, so it cannot be set to {value!r}; give it by its own option or from Python."
    )
