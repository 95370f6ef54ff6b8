"""What the player is told: a surface, its shapes, its bones, and what they do over time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import Clip, Rig
from mien.core.arrays import Floats
from mien.io.gltf.write import held
from mien.look import shade
from mien.look.camera import View, frame_face
from mien.look.creases import Creases
from mien.look.openings import Openings
from mien.look.parts import Surface, surface_of
from mien.look.player.packing import numbers, sparse_shapes
from mien.look.portrait import frame_clip, weights_for

INFLUENCES = 4
"""The strongest joints of a vertex that the player follows."""

Arrays = dict[str, NDArray[Any]]


def scene_of(rig: Rig, clip: Clip | None = None, view: View = "front") -> tuple[dict[str, Any], Arrays]:
    """Return what a page needs to know to show a rig, in words and numbers, and in arrays.

    Args:
        rig: who is shown.
        clip: what it plays, in the rig's shapes; without one its shapes are set by hand.
        view: from where it is seen first.

    Raises:
        InputError: not one channel of the clip is a shape of the rig.
    """
    surface = surface_of(rig)
    camera = frame_face(rig, view) if clip is None else frame_clip(rig, clip, view)
    words = {
        "name": rig.name,
        "shapes": list(rig.blendshapes.names),
        "still": list(rig.blendshapes.empty),
        "fps": 0.0 if clip is None else clip.fps,
        "camera": {"position": camera.position.tolist(), "target": camera.target.tolist(), "angle": camera.angle},
        "light": _light(),
    }
    vertices, deltas = rig.neutral.vertices, rig.blendshapes.deltas
    creases = Creases.of(vertices, surface.triangles, surface.same, surface.teeth)
    arrays = _surface(surface, creases, _inner(surface.openings, vertices))
    if clip is not None and clip.joints is not None and rig.skin is not None and rig.skeleton is not None:
        own = np.linalg.inv(rig.skin.blend(rig.skeleton.rest))
        vertices = np.einsum("nab,nb->na", own[:, :3, :3], vertices) + own[:, :3, 3]
        deltas = np.einsum("nab,knb->kna", own[:, :3, :3], deltas)
        arrays |= _bones(rig, clip.joints, creases)
    deltas = deltas[:, creases.split(np.arange(len(vertices)))]
    arrays |= {"positions": creases.split(vertices).astype(np.float32), **sparse_shapes(deltas)}
    if clip is not None:
        arrays["weights"] = held(weights_for(rig, clip)).astype(np.float32)
        if clip.head is not None:
            arrays["head"] = clip.head[:, :3].astype(np.float32)
    return words, arrays


def _inner(openings: Openings, vertices: Floats) -> Openings:
    """Return the openings but for the longest, where the neck was cut or a mask ends: its lid would be seen beside it."""
    if not len(openings.rim):
        return openings
    length = np.linalg.norm(np.diff(vertices[openings.edges], axis=1)[:, 0], axis=1)
    kept = openings.rim != np.bincount(openings.rim, length).argmax()
    return Openings(openings.edges[kept], np.unique(openings.rim[kept], return_inverse=True)[1].astype(np.int64))


def _surface(surface: Surface, creases: Creases, openings: Openings) -> Arrays:
    count = len(creases.same)
    arrays = {
        "triangles": numbers(creases.triangles, count),
        "same": numbers(creases.same, count),
        "colours": np.round(255 * creases.split(surface.colours)).astype(np.uint8),
        "rims": numbers(openings.edges, count),
        "rim": openings.rim.astype(np.uint16),
    }
    if surface.gaze.any():
        gaze = creases.split(surface.gaze)
        length = np.linalg.norm(gaze, axis=1, keepdims=True)
        arrays["gaze"] = np.round(32767 * gaze / np.where(length > 0, length, 1)).astype(np.int16)
    return arrays


def _bones(rig: Rig, joints: Floats, creases: Creases) -> Arrays:
    """Return the strongest influences of each vertex, and per frame what each joint in use does `(F, J, 3, 4)`."""
    assert rig.skin is not None
    order = np.argsort(-rig.skin.weights, axis=1, kind="stable")[:, :INFLUENCES]
    weights = np.take_along_axis(rig.skin.weights, order, axis=1)
    weights = np.pad(weights / weights.sum(axis=1, keepdims=True), ((0, 0), (0, INFLUENCES - order.shape[1])))
    used, number = np.unique(np.take_along_axis(rig.skin.joints, order, axis=1), return_inverse=True)
    number = np.pad(number.reshape(order.shape), ((0, 0), (0, INFLUENCES - order.shape[1])))
    return {
        "joints": creases.split(number).astype(np.uint16),
        "grips": creases.split(weights).astype(np.float32),
        "bones": (joints[:, used] @ rig.skin.inverse_bind[used])[..., :3, :].astype(np.float32),
    }


def _light() -> dict[str, Any]:
    """Return the lights and colours that pictures have, so that the player's look the same."""
    return {
        "key": shade.KEY.tolist(),
        "fill": shade.FILL.tolist(),
        "rim": shade.RIM.tolist(),
        "wrap": shade.WRAP.tolist(),
        "hollow": shade.HOLLOW.tolist(),
        "hole": shade.HOLE_LIGHT.tolist(),
        "iris": shade.IRIS.tolist(),
        "pupil": shade.PUPIL.tolist(),
        "cosines": [shade.IRIS_COSINE, shade.PUPIL_COSINE],
        "knee": shade.KNEE,
    }
