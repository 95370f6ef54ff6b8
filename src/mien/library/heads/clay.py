"""Turned lumps, and the questions the cast's mesher asks of a blended skin."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mien.core.arrays import Floats
from mien.library.modelling.solids import Ball, Solids, skin_distance


@dataclass(frozen=True)
class Turned(Ball):
    """An ellipsoid that is turned about its centre: muzzles slope and cheekbones slant.

    Attributes:
        pitch, yaw, roll: turns about x (positive lowers the front), then y (positive turns the front to the left),
            then z [degrees].
    """

    pitch: float = 0.0
    yaw: float = 0.0
    roll: float = 0.0

    def distance(self, points: Floats) -> Floats:
        """Return the approximate signed distance of `(N, 3)` points, negative inside."""
        return super().distance((points - self.centre) @ self._turn + self.centre)

    @cached_property
    def _turn(self) -> Floats:
        return rotation(self.pitch, self.yaw, self.roll)


def rotation(pitch: float, yaw: float, roll: float = 0.0) -> Floats:
    """Return the `(3, 3)` matrix that turns about x, then y, then z [degrees]."""
    matrix = np.eye(3)
    for axis, angle in enumerate(np.radians([pitch, yaw, roll])):
        a, b = [(1, 2), (2, 0), (0, 1)][axis]
        turn = np.eye(3)
        turn[a, a] = turn[b, b] = np.cos(angle)
        turn[a, b], turn[b, a] = -np.sin(angle), np.sin(angle)
        matrix = turn @ matrix
    return matrix


def cast(solids: Solids, origins: Floats, directions: Floats, steps: int = 40) -> Floats:
    """Return where rays from outside first meet the skin, `(N, 3)`; rays may pass the midline."""
    points, moving = origins.astype(np.float64), np.arange(len(origins))
    for _ in range(steps):
        distance = left_distance(solids, points[moving])
        points[moving] += 0.85 * distance[:, None] * directions[moving]
        moving = moving[np.abs(distance) > 1e-4]
        if not moving.size:
            break
    return points


def left_distance(solids: Solids, points: Floats) -> Floats:
    """Return the signed distance of points on either side of the midline [cm]."""
    return skin_distance(solids, np.column_stack([np.abs(points[:, 0]), points[:, 1:]]))


def settled(solids: Solids, points: Floats, steps: int = 2) -> Floats:
    """Return points near the skin moved onto it along its normal; those on the midline stay there."""
    aside = 1e-4 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    for _ in range(steps):
        there, *beside = left_distance(solids, (points + aside[:, None]).reshape(-1, 3)).reshape(4, -1)
        normal = (np.array(beside) - there).T / 1e-4
        normal[points[:, 0] == 0, 0] = 0
        slope = np.maximum((normal**2).sum(axis=1), 0.05)
        points = points - (there / slope)[:, None] * normal
    return points
