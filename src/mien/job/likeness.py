"""Pictures of the actor, however captured: markers on a coarse skin, or the animated face."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mien.core import Markers
from mien.core.arrays import Floats, Ints
from mien.geometry.laplacian import triangulate_markers
from mien.job.performance import Performance
from mien.look.camera import frame_face
from mien.look.portrait import Portrait
from mien.look.raster import Dots, Picture, render
from mien.retargeting.by_example import ExampleRetargeter
from mien.retargeting.rows import MarkerRows
from mien.retargeting.shape_retargeter import ShapeRetargeter

DOT, DOT_RADIUS = (0.10, 0.36, 0.70), 0.0031
CLAY = (0.86, 0.85, 0.83)


def actor_pictures(
    performance: Performance,
    markers: Markers | None,
    reading: MarkerRows | ShapeRetargeter | None,
    frames: Ints | Sequence[int],
    size: int = 300,
) -> list[Picture]:
    """Picture an actor at some frames, the head held still; nothing if only weights are known.

    Args:
        performance: the actor's side.
        markers: the performance at its points, if it has any.
        reading: what holds the head still and turns the actor upright.
        frames: which.
        size: width and height [pixels].
    """
    chosen = np.asarray(frames, dtype=np.int64)
    if performance.actor is not None and performance.clip is not None:
        sitter = Portrait.of(performance.actor, size=(size, size))
        values = np.nan_to_num(performance.clip.channels(performance.actor.blendshapes.names))
        joints = performance.clip.joints
        return [sitter.picture(values[f], joints=None if joints is None else joints[f]) for f in chosen]
    if markers is None or reading is None:
        return []
    if isinstance(reading, MarkerRows):
        rows, _ = reading.rows(markers)
        moved = rows.reshape(len(rows), -1, 3)[chosen]
    else:
        moved, _ = reading.displacements(markers.points[chosen])
    turn = reading.placement.rotation.T
    return marker_pictures(reading.neutral / reading.centimetre @ turn / 100, moved @ turn / 100, size)


def marker_pictures(neutral: Floats, moved: Floats, size: int = 300) -> list[Picture]:
    """Picture markers as dots on a coarse skin.

    Args:
        neutral: `(M, 3)` the actor at rest, upright [m].
        moved: `(F, M, 3)` displacements [m], NaN where not seen.
        size: width and height [pixels].
    """
    triangles = triangulate_markers(neutral)
    shown = neutral + np.nan_to_num(moved)
    camera = frame_face(np.vstack([neutral, shown.reshape(-1, 3)]))
    clay = np.broadcast_to(CLAY, neutral.shape)
    pictures = []
    for points in shown:
        a, b, c = (points[triangles[:, i]] for i in range(3))
        away = (np.cross(b - a, c - a) * (camera.position - a)).sum(axis=1) < 0
        skin = np.where(away[:, None], triangles[:, ::-1], triangles)  # so coarse a skin folds at the lips
        dots = [Dots(points, DOT, DOT_RADIUS, on_top=True)]
        pictures.append(render(points, skin, camera, size=(size, size), colours=clay, dots=dots, crevices=0.0))
    return pictures


def reading_of(retargeter: object) -> MarkerRows | ShapeRetargeter | None:
    """Return what of a fitted method holds an actor's head still, if it follows points."""
    if isinstance(retargeter, ShapeRetargeter):
        return retargeter
    if isinstance(retargeter, ExampleRetargeter) and isinstance(retargeter.reading, MarkerRows):
        return retargeter.reading
    return None
