"""What stands between an actor's face and the markers a method sees: noise, gaps, head motion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mien.core import Markers
from mien.core.arrays import Floats
from mien.geometry.align import transform

SHORT_S, LONG_S = 0.3, 2.0
"""Gaps are up to `SHORT_S` long, and one in ten about `LONG_S`."""
TURN = np.radians((9.0, 14.0, 4.0))
"""How far a head nods, turns and tilts."""
SWAY_MM = 15.0
TEMPO_HZ = (0.31, 0.17, 0.11)
NECK_MM = np.array([0.0, -100.0, -40.0])
"""Where a head turns, from the middle of the markers."""


@dataclass(frozen=True)
class Conditions:
    """How a performance is captured.

    Attributes:
        markers: how many points are followed.
        noise_mm: standard deviation of each coordinate, on a 23 cm head.
        gaps: share of the marker samples that are missing.
        head: whether the head moves, and its motion is left in.
        seed: of the noise, the gaps and the head's motion.
    """

    markers: int = 99
    noise_mm: float = 0.2
    gaps: float = 0.0
    head: bool = False
    seed: int = 0

    @property
    def special(self) -> tuple[str, ...]:
        """What is unusual about it, in words for a table."""
        usual = Conditions()
        words = [
            f"{self.markers}m" if self.markers != usual.markers else "",
            f"{self.noise_mm:g}mm" if self.noise_mm != usual.noise_mm else "",
            f"{self.gaps:.0%} gaps" if self.gaps else "",
            "head" if self.head else "",
        ]
        return tuple(filter(None, words))


def captured(clean: Markers, conditions: Conditions, millimetre: float, rng: np.random.Generator) -> Markers:
    """Return markers as a capture would have them.

    Args:
        clean: the points on the face, with the head at rest.
        conditions: what is added.
        millimetre: length of a millimetre in the unit of the points.
        rng: where noise and gaps come from.
    """
    points = clean.points
    if conditions.head:
        centre = np.nanmean(points[0], axis=0)
        points = transform(moving_head(len(points), clean.fps, centre, millimetre, rng), points)
    points = points + rng.normal(0, conditions.noise_mm * millimetre, points.shape)
    points[missing(points.shape[:2], conditions.gaps, clean.fps, rng)] = np.nan
    return replace(clean, points=points)


def missing(shape: tuple[int, int], share: float, fps: float, rng: np.random.Generator) -> np.ndarray:
    """Return `(F, M)` samples that are lost, in runs, until about the wanted share of them is."""
    lost = np.zeros(shape, dtype=bool)
    if share <= 0:
        return lost
    while lost.mean() < share:
        longest = LONG_S if rng.random() < 0.1 else SHORT_S
        length = int(rng.integers(1, max(2, round(longest * fps))))
        start = int(rng.integers(0, shape[0]))
        lost[start : start + length, rng.integers(shape[1])] = True
    return lost


def moving_head(frames: int, fps: float, centre: Floats, millimetre: float, rng: np.random.Generator) -> Floats:
    """Return `(F, 4, 4)` a head that nods, turns and sways about its neck, beginning at rest."""
    t = np.arange(frames) / fps
    ease = np.minimum(t, 1.0)[:, None]
    tempo = 2 * np.pi * np.array(TEMPO_HZ) * rng.uniform(0.8, 1.2, (2, 3))
    angles = ease * TURN * np.sin(t[:, None] * tempo[0])
    motion = np.tile(np.eye(4), (frames, 1, 1))
    for axis in range(3):
        motion[:, :3, :3] = _about(axis, angles[:, axis]) @ motion[:, :3, :3]
    neck = centre + NECK_MM * millimetre
    sway = ease * SWAY_MM * millimetre * np.sin(t[:, None] * tempo[1])
    motion[:, :3, 3] = neck - motion[:, :3, :3] @ neck + sway
    return motion


def _about(axis: int, angle: Floats) -> Floats:
    a, b = [(1, 2), (2, 0), (0, 1)][axis]
    turn = np.tile(np.eye(3), (len(angle), 1, 1))
    turn[:, a, a] = turn[:, b, b] = np.cos(angle)
    turn[:, b, a], turn[:, a, b] = np.sin(angle), -np.sin(angle)
    return turn
