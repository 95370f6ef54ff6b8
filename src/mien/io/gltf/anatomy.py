"""What glTF has no word for, kept in the file all the same: muscles, deformers, templates, landmarks.

`extras.mien` of the document's outermost object describes them; everything that is long
is an accessor, referred to by its number and checked by its name, because a program
that renumbers accessors does not know of these.  Per-vertex values are in the order of
the file's vertices as `read_rig` numbers them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mien.core import Anatomy, Clip, Cluster, Flexor, InputError, Muscle, Rig
from mien.core.arrays import Ints
from mien.io.gltf.packing import Packing

VERSION = 1


def describe(packing: Packing, rig: Rig, rows: Ints) -> None:
    """Put the anatomy and the landmarks of a rig into a document, in place of any it has.

    Args:
        packing: the document.
        rig: the rig.
        rows: `(M,)` per vertex of the file the rig's vertex that it is.

    Raises:
        InputError: a script has frames that were not tracked.
    """
    if rig.anatomy is None and not rig.landmarks:
        return
    said: dict[str, Any] = {"version": VERSION, "vertices": len(rows)}
    if rig.landmarks:
        said["landmarks"] = {
            name: {"corners": point.corners[0].tolist(), "weights": point.weights[0].tolist()}
            for name, point in rig.landmarks.items()
        }
    if rig.anatomy is not None:
        said["anatomy"] = _Shelf(packing, rows).anatomy(rig.anatomy)
    root = packing.document.root
    extras = root.get("extras")
    root["extras"] = {**(extras if isinstance(extras, dict) else {}), "mien": said}


class _Shelf:
    """Stores arrays in a document and says where each one is."""

    def __init__(self, packing: Packing, rows: Ints) -> None:
        self._packing = packing
        self._rows = rows

    def anatomy(self, anatomy: Anatomy) -> dict[str, Any]:
        """Return an anatomy as JSON, its arrays packed."""
        return {
            "muscles": [self._muscle(muscle) for muscle in anatomy.muscles],
            "clusters": [self._cluster(cluster) for cluster in anatomy.clusters],
            "flexors": [self._flexor(flexor) for flexor in anatomy.flexors],
            "fields": {name: self._per_vertex(values, f"field {name}") for name, values in anatomy.fields.items()},
            "labels": {
                name: {"names": list(labels.names), "of": self._per_vertex(labels.of, f"label {name}", "<u4")}
                for name, labels in anatomy.labels.items()
            },
            "templates": {
                name: {control: float(value) for control, value in controls.items()}
                for name, controls in anatomy.templates.items()
            },
            "bases": dict(anatomy.bases),
            "scripts": {name: self._script(clip, f"script {name}") for name, clip in anatomy.scripts.items()},
        }

    def _muscle(self, muscle: Muscle) -> dict[str, Any]:
        said = {
            **self._cluster(muscle),
            "fibre": self._array(muscle.fibre, f"{muscle.name} fibre"),
            "shortening": float(muscle.shortening),
        }
        if muscle.seam is not None:
            said["seam"] = self._array(muscle.seam, f"{muscle.name} seam")
        if muscle.pivot is not None:
            said["pivot"] = muscle.pivot.tolist()
        return said

    def _cluster(self, part: Muscle | Cluster) -> dict[str, Any]:
        return {
            "name": part.name,
            "weights": self._per_vertex(part.weights, f"{part.name} weights"),
            "frame": part.frame.ravel().tolist(),
            "scale": float(part.scale),
        }

    def _flexor(self, flexor: Flexor) -> dict[str, Any]:
        weights = self._per_vertex(flexor.weights, f"{flexor.name} weights")
        return {"name": flexor.name, "joint": flexor.joint, "weights": weights}

    def _script(self, clip: Clip, name: str) -> dict[str, Any]:
        said: dict[str, Any] = {"names": list(clip.names), "fps": clip.fps, "start": clip.start}
        for part in ("values", "head", "eyes", "joints"):
            values = getattr(clip, part)
            if values is not None:
                if np.isnan(values).any():
                    raise InputError(f"the {name} has frames that were not tracked (NaN in its {part}); fill them.")
                said[part] = self._array(values, f"{name} {part}")
        return said

    def _per_vertex(self, values: ArrayLike, name: str, dtype: str = "<f4") -> dict[str, Any]:
        return self._array(np.asarray(values)[self._rows], name, dtype)

    def _array(self, values: ArrayLike, name: str, dtype: str = "<f4") -> dict[str, Any]:
        array = np.asarray(values)
        said: dict[str, Any] = {"shape": list(array.shape)}
        if array.size:
            said["accessor"] = self._packing.sparse(array.reshape(-1, 1), dtype)
            self._packing.document.root["accessors"][said["accessor"]]["name"] = called(name)
        return said


def called(name: str) -> str:
    """Return what the accessor of an array is called in the file."""
    return f"mien {name}"
