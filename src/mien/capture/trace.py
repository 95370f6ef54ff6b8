"""An animated face mesh as markers: its surface followed through morphs and skin."""

from __future__ import annotations

import numpy as np

from mien.core import Clip, InputError, Markers, Rig, SurfacePoints

CHUNK = 256
"""Frames posed at a time, so that long takes need little memory."""


def trace(rig: Rig, clip: Clip, points: SurfacePoints, names: tuple[str, ...]) -> Markers:
    """Follow points of a rig's surface through a clip.

    Args:
        rig: the actor's face.
        clip: what it does; channels are matched to blendshapes by name, absent ones rest.
        points: `M` points on it.
        names: `M` names for the markers.

    Returns:
        The points over time; NaN in frames whose weights are NaN (tracking lost).
    """
    if points.corners.max(initial=-1) >= len(rig.neutral.vertices):
        raise InputError(
            f"the points to follow use vertex {points.corners.max()}, but {rig.name} has {len(rig.neutral.vertices)} vertices: "
            "they were made for another mesh."
        )
    used, local = np.unique(points.corners, return_inverse=True)
    small = rig.only(used)
    local_points = SurfacePoints(local.reshape(points.corners.shape), points.weights)
    weights = clip.channels(rig.blendshapes.names)
    traced = np.empty((len(clip), len(points), 3))
    for begin in range(0, len(clip), CHUNK):
        part = slice(begin, begin + CHUNK)
        joints = None if clip.joints is None else clip.joints[part]
        traced[part] = local_points.of(small.pose(weights[part], joints))
    return Markers(names, traced, clip.fps, clip.notes)
