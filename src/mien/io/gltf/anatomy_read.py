"""Reading back what `anatomy` put into `extras`, or anything that stands there instead.

Nothing here may fail a file that is a good glTF file: what cannot be understood is left
out with a note.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mien.core import Anatomy, Clip, Cluster, Controls, Flexor, Labels, MienError, Muscle, Note, SurfacePoints
from mien.core.arrays import Floats
from mien.io.gltf.accessors import count_of, floats_at, integers_at
from mien.io.gltf.anatomy import VERSION, called
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields

MOST_NUMBERS = 1 << 27
"""The most numbers that are believed of all of a file's anatomy (1 GiB): sparse ones take no room in it."""

Landmarks = Mapping[str, SurfacePoints]


def described(document: Document, count: int) -> tuple[Anatomy | None, Landmarks, list[Note]]:
    """Return the anatomy and the landmarks that a document carries for its `count` vertices, and what was left out."""
    extras = document.root.get("extras")
    if not isinstance(extras, dict) or "mien" not in extras:
        return None, {}, []
    try:
        said = Fields(document.path, "extras", extras).inner("mien")
        if said.integer("version") != VERSION:
            raise said.error(f"is of version {said.values['version']}, this mien reads version {VERSION}")
        if said.integer("vertices") != count:
            raise said.error(f"is about {said.values['vertices']} vertices, but the file has {count}")
        landmarks = {name: _landmark(spot, count) for name, spot in _each(said, "landmarks")}
        anatomy = _Shelf(document, count).anatomy(said.inner("anatomy")) if "anatomy" in said else None
    except MienError as error:
        return (
            None,
            {},
            [Note("anatomy-unread", f"its muscles, templates and landmarks are left out: {error}", "extras")],
        )
    return anatomy, landmarks, []


def _each(by: Fields, key: str) -> list[tuple[str, Fields]]:
    """Return the objects by name that stand under a key."""
    held = by.inner(key)
    return [(name, held.inner(name)) for name in held.values]


def _landmark(spot: Fields, count: int) -> SurfacePoints:
    corners, weights = spot.integers("corners"), spot.numbers("weights", 3)
    if len(corners) != 3 or max(corners) >= count or weights is None:
        raise spot.error(f"needs three corners among {count} vertices, and their weights")
    return SurfacePoints(np.array([corners]), np.array([weights]))


def _number(by: Fields, key: str) -> float:
    value = by.values.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise by.error(f"needs a number as {key!r}")
    return float(value)


def _words(by: Fields, key: str) -> tuple[str, ...]:
    found = by.texts(key)
    if found is None:
        raise by.error(f"needs a list of texts as {key!r}")
    return tuple(found)


class _Shelf:
    """Finds the arrays of an anatomy in a document."""

    def __init__(self, document: Document, count: int) -> None:
        self._document = document
        self._count = count
        self._left = MOST_NUMBERS

    def anatomy(self, said: Fields) -> Anatomy:
        """Read an anatomy from its JSON."""
        return Anatomy(
            tuple(self._muscle(muscle) for muscle in said.each("muscles")),
            tuple(self._cluster(cluster) for cluster in said.each("clusters")),
            tuple(self._flexor(flexor) for flexor in said.each("flexors")),
            fields={name: self._field(ref, f"field {name}") for name, ref in _each(said, "fields")},
            labels={name: self._labels(labels, name) for name, labels in _each(said, "labels")},
            templates={name: _template(controls) for name, controls in _each(said, "templates")},
            bases={name: said.inner("bases").text(name) for name in said.inner("bases").values},
            scripts={name: self._script(script, f"script {name}") for name, script in _each(said, "scripts")},
        )

    def _muscle(self, said: Fields) -> Muscle:
        placed = self._cluster(said)
        pivot = said.numbers("pivot", 3)
        return Muscle(
            placed.name,
            self._array(said.inner("fibre"), f"{placed.name} fibre"),
            placed.weights,
            placed.frame,
            placed.scale,
            _number(said, "shortening"),
            self._array(said.inner("seam"), f"{placed.name} seam") if "seam" in said else None,
            None if pivot is None else np.array(pivot),
        )

    def _cluster(self, said: Fields) -> Cluster:
        name, frame = said.text("name"), said.numbers("frame", 16)
        if frame is None:
            raise said.error("has no frame")
        return Cluster(name, self._weights(said), np.array(frame).reshape(4, 4), _number(said, "scale"))

    def _flexor(self, said: Fields) -> Flexor:
        return Flexor(said.text("name"), said.text("joint"), self._weights(said))

    def _weights(self, said: Fields) -> Floats:
        return self._field(said.inner("weights"), f"{said.text('name')} weights")

    def _field(self, ref: Fields, name: str) -> Floats:
        values = self._array(ref, name)
        if values.ndim not in {1, 2} or len(values) != self._count:
            raise ref.error(f"must have one row for each of {self._count} vertices, but has the shape {values.shape}")
        return values

    def _labels(self, said: Fields, name: str) -> Labels:
        ref = said.inner("of")
        return Labels(_words(said, "names"), self._array(ref, f"label {name}", whole=True).astype(np.int64))

    def _script(self, said: Fields, name: str) -> Clip:
        parts = {
            part: self._array(said.inner(part), f"{name} {part}") if part in said else None
            for part in ("values", "head", "eyes", "joints")
        }
        values = parts["values"]
        if values is None:
            raise said.error("has no values")
        return Clip(
            _words(said, "names"),
            values,
            _number(said, "fps"),
            parts["head"],
            parts["eyes"],
            parts["joints"],
            _number(said, "start"),
        )

    def _array(self, ref: Fields, name: str, whole: bool = False) -> NDArray[np.float64]:
        """Return a stored array, after checking that the accessor is the one that was written for it."""
        shape = ref.integers("shape")
        size = math.prod(shape)
        self._left -= size
        if not 0 < len(shape) <= 4 or max(shape) > MOST_NUMBERS or self._left < 0:
            raise ref.error(f"has the shape {shape[:5]}, which no anatomy needs")
        if not size:
            return np.zeros(shape)
        index = ref.integer("accessor")
        stored = self._document.at("accessors", index, ref)
        if stored.text("name") != called(name) or count_of(self._document, index, ref) != size:
            raise ref.error(f"refers to accessors[{index}], which is not the {size} numbers of {called(name)!r}")
        read = integers_at if whole else floats_at
        return np.asarray(read(self._document, index, ref, "SCALAR"), dtype=np.float64).reshape(shape)


def _template(said: Fields) -> Controls:
    return {control: _number(said, control) for control in said.values}
