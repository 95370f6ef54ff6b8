"""Where a face is looked at from.

A performance is judged on the eyes and the lips, so the face has to fill the
picture.  For a rig that means looking where its blendshapes move things, which is
the face even when the mesh is a whole body, and at the crown, ears and horns around it.
Nothing of that may leave the picture in any pose shown.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mien.core import InputError, Rig
from mien.core.arrays import Floats, Ints, floats

View = Literal["front", "three-quarter", "side"]

TURNS: dict[View, float] = {"front": 0.0, "three-quarter": np.radians(35.0), "side": np.radians(90.0)}
"""How far the camera walks around the face, towards the subject's left [rad]."""

PORTRAIT_ANGLE = np.radians(20.0)
"""Vertical angle of view of a portrait lens: long enough not to swell the nose [rad]."""

STILL = 0.5
"""A vertex belongs to the face if some shape moves it by at least this share of its largest movement."""

AROUND = 1.5
"""What rises above the chin belongs to the head if it is no farther from the face's middle than this [its size]."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A perspective camera held upright.

    Attributes:
        position: where it stands [m].
        target: what stands in the middle of the picture [m].
        angle: vertical angle of view [rad].

    Raises:
        InputError: it stands on its target, looks straight up or down, or the angle is not in (0, π).
    """

    position: Floats
    target: Floats
    angle: float = PORTRAIT_ANGLE

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "position", floats(self.position, (3,), "the camera's position"))
        put(self, "target", floats(self.target, (3,), "the camera's target"))
        if not 0 < self.angle < np.pi:
            raise InputError(f"the camera's angle of view must lie between 0 and π, but is {self.angle}.")
        back = self.position - self.target
        if np.hypot(back[0], back[2]) <= 1e-6 * np.linalg.norm(back):
            raise InputError("the camera must not stand on its target, nor look straight up or down.")

    @property
    def axes(self) -> Floats:
        """`(3, 3)` the directions right, up and backward in the world, one a row."""
        back = self.position - self.target
        return _axes(back / np.linalg.norm(back))

    def seen(self, points: Floats) -> Floats:
        """Return `(…, 3)` points in the camera's own axes: right, up, backward [m]."""
        return np.asarray((points - self.position) @ self.axes.T)

    def project(self, points: Floats, width: int, height: int) -> Floats:
        """Return where `(…, 3)` points fall in a picture.

        Returns:
            `(…, 3)`: column and row [pixels], and the distance in front of the camera [m].
        """
        seen = self.seen(points)
        distance = -seen[..., 2]
        scale = self.pixels_per_slope(height) / np.where(distance > 0, distance, np.nan)
        return np.stack([width / 2 + seen[..., 0] * scale, height / 2 - seen[..., 1] * scale, distance], axis=-1)

    def pixels_per_slope(self, height: int) -> float:
        """Return how many pixels one metre covers at one metre's distance."""
        return float(height / 2 / np.tan(self.angle / 2))


def frame_face(
    face: Rig | Floats,
    view: View = "front",
    *,
    aspect: float = 1.0,
    margin: float = 0.08,
    angle: float = PORTRAIT_ANGLE,
) -> Camera:
    """Place a camera so that the face fills the picture.

    Args:
        face: a rig, framed at rest and in each of its shapes; or points `(…, 3)`, all framed [m].
        view: from where; `+Z` points out of the face and `+Y` up.
        aspect: width over height of the picture.
        margin: share of the picture left free on each side.
        angle: vertical angle of view [rad].

    Raises:
        InputError: the view is unknown, or there is nothing to frame.
    """
    points = face_points(face) if isinstance(face, Rig) else face
    return frame_all([points], view, aspect=aspect, margin=margin, angle=angle)


def frame_all(
    clouds: Iterable[Floats],
    view: View = "front",
    *,
    aspect: float = 1.0,
    margin: float = 0.08,
    angle: float = PORTRAIT_ANGLE,
) -> Camera:
    """Place a camera as near as it can be with every point of every cloud in the picture; `frame_face` says the rest.

    Args:
        clouds: points `(…, 3)`, of which only those are kept that decide: so there may be any number [m].
        view: from where.
        aspect: width over height of the picture.
        margin: share of the picture left free on each side.
        angle: vertical angle of view [rad].
    """
    if view not in TURNS:
        raise InputError(f"unknown view {view!r}. Known: {', '.join(TURNS)}.")
    axes = _axes(np.array([np.sin(TURNS[view]), 0.0, np.cos(TURNS[view])]))
    high = np.tan(angle / 2) * (1 - 2 * margin)
    wide = high * aspect
    deciding = np.array([[1 / wide, 0, 1], [-1 / wide, 0, 1], [0, 1 / high, 1], [0, -1 / high, 1]])
    deciding = np.concatenate([np.eye(3), -np.eye(3), deciding]) @ axes
    kept = [np.empty((0, 3))]
    for cloud in clouds:
        points = floats(np.reshape(cloud, (-1, 3)), (None, 3), "points to frame")
        if len(points):
            kept.append(points[(deciding @ points.T).argmax(axis=1)])
    turned = np.concatenate(kept) @ axes.T
    if not len(turned):
        raise InputError("there are no points to frame.")
    centre = (turned.min(axis=0) + turned.max(axis=0)) / 2
    x, y, z = (turned - centre).T
    distance = max(float((np.abs(x) / wide + z).max()), float((np.abs(y) / high + z).max()), 1e-9)
    return Camera((centre + distance * np.array([0.0, 0.0, 1.0])) @ axes, centre @ axes, angle)


def face_points(rig: Rig) -> Floats:
    """Return the points `(…, 3)` the face reaches: at rest and at each shape's full strength."""
    face = face_vertices(rig)
    vertices, deltas = rig.neutral.vertices[face], rig.blendshapes.deltas[:, face]
    if not len(deltas):
        return vertices
    return np.concatenate([vertices, vertices + deltas.min(axis=0), vertices + deltas.max(axis=0)])


def face_vertices(rig: Rig) -> Ints:
    """Return the vertices to be kept in a picture: what the shapes move, and what of the head rises around it."""
    vertices = rig.neutral.vertices
    length = np.linalg.norm(rig.blendshapes.deltas, axis=2)
    length = length[length.any(axis=1)]
    if not len(length):
        return np.arange(len(vertices))
    moved = (length > STILL * length.max(axis=1, keepdims=True)).any(axis=0)
    low, high = vertices[moved].min(axis=0), vertices[moved].max(axis=0)
    near = np.abs(vertices - (low + high) / 2).max(axis=1) <= AROUND * (high - low).max()
    return np.flatnonzero(moved | (near & (vertices[:, 1] >= low[1])))


def _axes(back: Floats) -> Floats:
    right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])
