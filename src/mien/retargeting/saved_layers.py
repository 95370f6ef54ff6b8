"""Fitted layers as plain values and arrays, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture import Stabiliser
from mien.core import InputError, Labels, Note
from mien.core.arrays import Floats
from mien.geometry.align import Similarity
from mien.retargeting.layers.actor import Actor
from mien.retargeting.layers.compose import Projection
from mien.retargeting.layers.decompose import Decomposer, Lips
from mien.retargeting.layers.model import Layer, LayeredFace
from mien.retargeting.layers.planar import PlanarStabiliser
from mien.retargeting.layers.retargeter import LayeredRetargeter
from mien.retargeting.records import record, restored
from mien.solve import LassoProblem
from mien.solve.layered import Bias

CLASSES: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        *(LayeredRetargeter, Actor, Stabiliser, PlanarStabiliser, Similarity, Note),
        *(Decomposer, Lips, Bias, LayeredFace, Layer, Labels, Projection, LassoProblem),
    )
}
"""All that a saved model may be made of."""


def packed_layers(fitted: LayeredRetargeter) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return a fitted method as a header of plain values and its arrays."""
    arrays: dict[str, NDArray[Any]] = {}
    return {"kind": "layers", "names": fitted.names, "fitted": record(fitted, arrays)}, arrays


def unpacked_layers(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> LayeredRetargeter:
    """Return the fitted method that `packed_layers` made these from.

    Raises:
        InputError: what is found is no fitted method, or its parts do not fit each other.
        KeyError: something is missing.
        TypeError: something is of the wrong kind.
        ValueError: something has the wrong shape.
    """
    fitted = restored(header["fitted"], arrays, CLASSES)
    if not isinstance(fitted, LayeredRetargeter):
        raise InputError(f"the model holds a {type(fitted).__name__} instead of a fitted method; fit it again.")
    _check_actor(fitted.actor)
    _check_decomposer(fitted.decomposer, len(fitted.actor.markers))
    _check_character(fitted)
    _, weights = fitted.step(fitted.start(), fitted.actor.rest)
    if weights.shape != (len(fitted.names),) or not np.isfinite(weights).all():
        raise ValueError("the model does not map a frame to weights")
    return fitted


def _check_actor(actor: Actor) -> None:
    """Refuse points that do not fit each other: the compiled sums do not look."""
    m = len(actor.markers)
    _shape(actor.rest, (m, 3), "the points at rest")
    _shape(actor.centimetre, (m,), "the centimetres")
    if actor.planar.shape != (m,) or actor.planar.dtype != np.bool_:
        raise ValueError("the planar points are not marked one by one")
    flat = int(actor.planar.sum())
    if actor.stabiliser is not None:
        _shape(actor.stabiliser.neutral, (m - flat, 3), "the face that the head is held by")
        _shape(actor.stabiliser.stability, (m - flat,), "the stability")
        _number(actor.stabiliser.softness, "the softness")
    if actor.planar_stabiliser is not None:
        _shape(actor.planar_stabiliser.neutral, (flat, 2), "the planar face")
        _number(actor.planar_stabiliser.softness, "the softness of the planar face")


def _check_decomposer(decomposer: Decomposer, count: int) -> None:
    face, lips = decomposer.face, decomposer.lips
    _check_face(face)
    _shape(face.rest, (count, 3), "the actor's face")
    _shape(decomposer.importance, (count,), "the importance of the points")
    _number(decomposer.smooth, "the smoothness")
    if lips is None:
        return
    if not (0 <= lips.upper < count and 0 <= lips.lower < count):
        raise ValueError(f"the lips are the points {lips.upper} and {lips.lower} of {count}")
    for name in ("closed", "sigma", "closure", "closing"):
        _number(getattr(lips, name), f"{name} of the lips")


def _check_character(fitted: LayeredRetargeter) -> None:
    mine, theirs, projection = fitted.decomposer.face, fitted.character, fitted.projection
    _check_face(theirs)
    if mine.extremes != theirs.extremes or len(mine.regions.names) != len(theirs.regions.names):
        raise ValueError("actor and character have other layers or regions")
    k, mixed = len(fitted.names), len(theirs.regions.names) * len(theirs.extremes)
    _shape(projection.problem.gram, (k, k), "the projection")
    _shape(projection.match, (k, mixed), "the projection of the extremes")
    _shape(projection.energy, (mixed, mixed), "the energy of the extremes")
    _shape(fitted.placement.rotation, (3, 3), "the placement's rotation")
    _shape(fitted.placement.translation, (3,), "the placement's translation")
    _number(fitted.placement.scale, "the placement's scale")
    _number(fitted.fps, "the frame rate")


def _check_face(face: LayeredFace) -> None:
    """Refuse a layer or region that is no such thing: records restore whatever stands in the file."""
    if not all(isinstance(layer, Layer) for layer in face.layers) or not isinstance(face.regions, Labels):
        raise TypeError("a face is not made of layers and regions")


def _shape(array: Floats, shape: tuple[int, ...], what: str) -> None:
    if array.shape != shape or array.dtype != np.float64 or not np.isfinite(array).all():
        raise ValueError(f"{what} has shape {array.shape} and type {array.dtype}, not {shape} finite numbers")


def _number(value: float, what: str) -> None:
    if not isinstance(value, int | float) or not (np.isfinite(value) and value >= 0):
        raise ValueError(f"{what} is {value!r}, not a number of at least 0")
