"""Fitted methods as plain values and arrays, and back: what a `.mien` file holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture import Stabiliser
from mien.core import Correctives, InputError, Note
from mien.geometry.align import Similarity
from mien.retargeting.by_example import ExampleRetargeter
from mien.retargeting.contact import Contacts
from mien.retargeting.copying import Copier
from mien.retargeting.energy import FrameSolver
from mien.retargeting.layers import LayeredRetargeter
from mien.retargeting.saved_examples import packed_examples, unpacked_examples
from mien.retargeting.saved_layers import packed_layers, unpacked_layers
from mien.retargeting.settings import SolveSettings
from mien.retargeting.shape_retargeter import ShapeRetargeter
from mien.retargeting.spacetime import SpacetimeRetargeter

CONTACTS = {
    "reading": "RM3",
    **dict.fromkeys(("begin", "full", "shut", "follow", "parts", "rest"), "R"),
    **dict.fromkeys(("opening", "ways"), "RK"),
}
"""The arrays of contacts and their shapes: of `R` openings, `K` shapes and `M` markers."""

Packed = tuple[dict[str, Any], dict[str, NDArray[Any]]]


def packed(retargeter: Any) -> Packed:
    """Return a fitted method as a header of plain values and its arrays.

    Raises:
        InputError: a kind of method that cannot be saved.
    """
    if isinstance(retargeter, Copier):
        values = {"kind": "copy", "sources": retargeter.sources, "names": retargeter.names}
        return {**values, "notes": _notes(retargeter.notes)}, {"matrix": retargeter.matrix}
    if isinstance(retargeter, SpacetimeRetargeter):
        header, arrays = _packed_shapes(retargeter)
        return header | {"kind": "spacetime", "velocity": retargeter.velocity}, arrays
    if isinstance(retargeter, ShapeRetargeter):
        return _packed_shapes(retargeter)
    if isinstance(retargeter, ExampleRetargeter):
        return packed_examples(retargeter)
    if isinstance(retargeter, LayeredRetargeter):
        return packed_layers(retargeter)
    raise InputError(f"a fitted {type(retargeter).__name__} cannot be saved.")


def unpacked(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Any:
    """Return the fitted method that `packed` made these from.

    Raises:
        InputError: something is missing, of the wrong kind or shape.
    """
    try:
        if header["kind"] == "copy":
            return Copier(tuple(header["sources"]), tuple(header["names"]), arrays["matrix"], _noted(header))
        if header["kind"] == "shapes":
            return _unpacked_shapes(header, arrays)
        if header["kind"] == "spacetime":
            return SpacetimeRetargeter.of(_unpacked_shapes(header, arrays), float(header["velocity"]))
        if header["kind"] == "examples":
            return unpacked_examples(header, arrays)
        if header["kind"] == "layers":
            return unpacked_layers(header, arrays)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise InputError(f"the model lacks or garbles something ({error}); fit it again.") from None
    raise InputError(f"the model is of the unknown kind {header['kind']!r}; a newer mien may have written it.")


def _packed_shapes(fitted: ShapeRetargeter) -> Packed:
    placement, solver = fitted.placement, fitted.solver
    header = {
        "kind": "shapes",
        "method": fitted.method,
        "names": fitted.names,
        "markers": fitted.markers,
        "centimetre": fitted.centimetre,
        "fps": fitted.fps,
        "neutral_frame": fitted.neutral_frame,
        "scale": placement.scale,
        "residuals": [placement.residual, placement.mirrored_residual],
        "softness": fitted.stabiliser.softness if fitted.stabiliser else None,
        "settings": solver.settings.as_dict(),
        "evidence": dict(fitted.evidence),
        "notes": _notes(fitted.notes),
    }
    arrays = {
        "neutral": fitted.neutral,
        "rotation": placement.rotation,
        "translation": placement.translation,
        "shapes": fitted.shapes,
        "confidence": solver.confidence,
        "regular": solver.regular,
        "l1": solver.l1,
        "lower": solver.lower,
        "upper": solver.upper,
        "exclusive": solver.exclusive,
    }
    if fitted.stabiliser is not None:
        arrays["stability"] = fitted.stabiliser.stability
    if fitted.contacts is not None:
        header["contacts"] = fitted.contacts.names
        arrays |= {f"contact_{name}": getattr(fitted.contacts, name) for name in CONTACTS}
    if solver.correctives is not None:
        arrays |= {f"corrective_{name}": getattr(solver.correctives, name) for name in ("shapes", "drivers", "at")}
    return header, arrays


def _unpacked_shapes(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> ShapeRetargeter:
    k, m = len(header["names"]), len(header["markers"])
    wanted = {
        "neutral": (m, 3),
        "rotation": (3, 3),
        "translation": (3,),
        "shapes": (k, m, 3),
        "confidence": (m,),
        "regular": (k, k),
        "l1": (k,),
        "lower": (k,),
        "upper": (k,),
    }
    for name, shape in wanted.items():
        if arrays[name].shape != shape or arrays[name].dtype != np.float64:
            raise ValueError(
                f"{name} has shape {arrays[name].shape} and type {arrays[name].dtype}, not {shape} numbers"
            )
        if name not in ("lower", "upper") and not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name} is not finite")
    settings = dict(header["settings"])
    settings["bounds"] = None if settings["bounds"] is None else tuple(settings["bounds"])
    solver = FrameSolver(
        **{name: arrays[name] for name in ("shapes", "confidence", "regular", "l1", "lower", "upper", "exclusive")},
        settings=SolveSettings(**settings),
        correctives=_correctives(arrays, k),
    )
    stabiliser = None
    if header["softness"] is not None:
        stabiliser = Stabiliser(arrays["neutral"], arrays["stability"], float(header["softness"]))
    return ShapeRetargeter(
        str(header["method"]),
        tuple(header["names"]),
        tuple(header["markers"]),
        stabiliser,
        arrays["neutral"],
        float(header["centimetre"]),
        Similarity(float(header["scale"]), arrays["rotation"], arrays["translation"], *map(float, header["residuals"])),
        arrays["shapes"],
        solver,
        float(header["fps"]),
        dict(header["evidence"]),
        header["neutral_frame"],
        _noted(header),
        contacts=_contacts(header, arrays, k, m),
    )


def _contacts(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], k: int, m: int) -> Contacts | None:
    if "contacts" not in header:
        return None
    sizes = {"R": len(header["contacts"]), "K": k, "M": m, "3": 3}
    found = {name: arrays[f"contact_{name}"] for name in CONTACTS}
    for name, array in found.items():
        shape = tuple(sizes[letter] for letter in CONTACTS[name])
        if array.shape != shape or not np.isfinite(array).all():
            raise ValueError(f"contact_{name} has shape {array.shape}, not {shape} finite numbers")
    return Contacts(tuple(header["contacts"]), **found)


def _correctives(arrays: Mapping[str, NDArray[Any]], count: int) -> Correctives | None:
    if "corrective_shapes" not in arrays:
        return None
    found = Correctives(*(arrays[f"corrective_{name}"] for name in ("shapes", "drivers", "at")))
    if found.last >= count:
        raise ValueError("the correctives name shapes that are not there")
    return found


def _notes(notes: tuple[Note, ...]) -> list[list[str]]:
    return [[note.code, note.message, note.where] for note in notes]


def _noted(header: Mapping[str, Any]) -> tuple[Note, ...]:
    return tuple(Note(*map(str, note)) for note in header["notes"])
