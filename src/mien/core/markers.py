"""Captured points over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mien.core.arrays import Flags, Floats, Ints, distinct, floats
from mien.core.clip import checked_fps
from mien.core.errors import InputError, Note, unknown


@dataclass(frozen=True, eq=False)
class Markers:
    """Named points over time.

    Attributes:
        names: `M` marker names.
        points: `(F, M, 3)` positions [m]; NaN where a marker was not seen.
        fps: frames per second.
        notes: what was repaired on reading.
    """

    names: tuple[str, ...]
    points: Floats
    fps: float
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "names", distinct(self.names, "markers"))
        points = floats(self.points, (None, len(self.names), 3), "marker positions", nan=True)
        half_seen = np.asarray(np.isnan(points).any(axis=2) & ~np.isnan(points).all(axis=2))
        if half_seen.any():
            points = np.where(half_seen[..., None], np.nan, points)
        put(self, "points", points)
        put(self, "fps", checked_fps(self.fps))

    def __len__(self) -> int:
        return len(self.points)

    @property
    def seen(self) -> Flags:
        """`(F, M)` whether each marker was seen."""
        return np.asarray(~np.isnan(self.points[..., 0]))

    def index(self, names: Sequence[str]) -> Ints:
        """Return the columns of these markers.

        Raises:
            InputError: a name is unknown.
        """
        place = {name: i for i, name in enumerate(self.names)}
        for name in names:
            if name not in place:
                raise InputError(unknown("marker", name, self.names))
        return np.array([place[name] for name in names], dtype=np.int64)

    def only(self, names: Sequence[str]) -> Markers:
        """Return these markers, in this order."""
        return replace(self, names=tuple(names), points=self.points[:, self.index(names)])
