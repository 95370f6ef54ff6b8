"""Nostrils: small hollows in the skin."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mien.core.arrays import Ints
from mien.library.heads.clay import cast, rotation
from mien.library.modelling.half import Half
from mien.library.modelling.solids import Point, Solids


@dataclass(frozen=True)
class Pit:
    """A hollow on the left [cm].

    Attributes:
        centre: near the middle of its mouth.
        half_width, half_height: of its mouth.
        depth: how deep it goes.
        yaw, pitch, roll: which way it opens, turned to the left and down, and how it lies [degrees].
        bend: how far its middle bows up against its ends, over its half width.
        rim: width of the skin ring around it.
    """

    centre: Point
    half_width: float
    half_height: float
    depth: float
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    bend: float = 0.0
    rim: float = 0.2
    points: int = 12


def pit_rings(half: Half, pit: Pit, solids: Solids) -> Ints:
    """Lay the hollow's rings and one on the skin around it; return the outermost."""
    turn = np.arange(pit.points) * 2 * np.pi / pit.points
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    mouth = circle * [pit.half_width, pit.half_height]
    mouth[:, 1] += pit.bend * pit.half_width * (1 - circle[:, 0] ** 2)
    frame = (rotation(pit.pitch, pit.yaw) @ rotation(0, 0, pit.roll)).T
    flat = np.concatenate([mouth, mouth + 0.35 * pit.rim * circle, mouth + pit.rim * circle])
    origins = np.column_stack([flat, np.full(len(flat), 6.0)]) @ frame + pit.centre
    edge, *skin = np.split(cast(solids, origins, np.broadcast_to(-frame[2], origins.shape)), 3)
    middle = edge.mean(axis=0) - pit.depth * frame[2]
    inner = [
        middle + scale * (edge - edge.mean(axis=0)) + lift * frame[2]
        for scale, lift in ((0.6, 0), (0.95, 0.5 * pit.depth))
    ]
    rings = [half.add(points, "face", "nostril") for points in (*inner, edge)]
    rings += [half.add(points, "face") for points in skin]
    tip = half.add(middle[None], "face", "nostril")
    half.fan(rings[0], int(tip[0]), closed=True)
    for inside, outside in pairwise(rings):
        half.strip(inside, outside, closed=True)
    return rings[-1]
