"""A head's left half laid flat: a disc whose rim is the midline.

A long muzzle is not seen whole from any one point inside the head, but it is from a
bar inside.  So the skin is mapped to the bar's own rounded surface, that to a sphere,
and the sphere's left half to a disc.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Flags, Floats


@dataclass(frozen=True)
class Core:
    """A bar inside the head, in the midline, from which all of the skin is seen.

    Attributes:
        front, back: height and depth of its ends [cm].
        radius: how thick a bar the disc stands for [cm].
    """

    front: tuple[float, float]
    back: tuple[float, float]
    radius: float = 5.0

    def flat(self, points: Floats) -> Floats:
        """Return `(N, 2)` places in the disc of points with `x >= 0`."""
        start, axis, up, length = self._axes()
        offset = points[:, 1:] - start
        along = offset @ axis
        beside = np.stack([points[:, 0], offset @ up], axis=1)
        out = np.linalg.norm(beside, axis=1)
        cap = np.arctan2(out, along - np.clip(along, 0, length))
        arc = self.radius * cap + length - np.clip(along, 0, length)
        polar = arc * np.pi / (np.pi * self.radius + length)
        around = beside / np.maximum(out, 1e-12)[:, None]
        sphere = np.stack([np.sin(polar) * around[:, 0], np.sin(polar) * around[:, 1], np.cos(polar)], axis=1)
        return np.asarray(sphere[:, 1:] / (1 + sphere[:, :1]))

    def rays(self, flat: Floats) -> tuple[Floats, Floats]:
        """Return the origins on the bar and the outward directions of places in the disc."""
        start, axis, up, length = self._axes()
        square = (flat**2).sum(axis=1, keepdims=True)
        sphere = np.concatenate([1 - square, 2 * flat], axis=1) / (1 + square)
        polar = np.arccos(np.clip(sphere[:, 2], -1, 1))
        around = sphere[:, :2] / np.maximum(np.linalg.norm(sphere[:, :2], axis=1), 1e-12)[:, None]
        arc = polar / np.pi * (np.pi * self.radius + length)
        quarter = self.radius * np.pi / 2
        back = np.clip(arc - quarter, 0, length)
        cap = (arc - back) / self.radius
        origin = np.column_stack([0 * back, start + (length - back)[:, None] * axis])
        sideways = np.column_stack([around[:, 0], around[:, 1:] * up])
        return origin, np.sin(cap)[:, None] * sideways + np.cos(cap)[:, None] * np.array([0.0, *axis])

    def _axes(self) -> tuple[Floats, Floats, Floats, float]:
        start = np.array(self.back)
        axis = np.array(self.front) - start
        length = float(np.linalg.norm(axis))
        axis /= length
        return start, axis, np.array([axis[1], -axis[0]]), length


def within(polygon: Floats, points: Floats) -> Flags:
    """Return which `(N, 2)` points lie inside a polygon."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    return np.asarray((crosses & (x < a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise)).sum(axis=1) % 2 == 1)
