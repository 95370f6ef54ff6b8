"""Animation: channel values over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats, distinct, floats, matching
from mien.core.errors import InputError, Note


@dataclass(frozen=True, eq=False)
class Clip:
    """What a face does over time, in the terms of a rig.

    Attributes:
        names: `K` channel names.
        values: `(F, K)` weights; a row of NaN is a frame that was not tracked.
        fps: frames per second.
        head: `(F, 4, 4)` rigid motion of the head relative to its rest [m], or None.
        eyes: `(F, 2, 3)` yaw, pitch, roll of the left and right eye [rad], or None.
        joints: `(F, J, 4, 4)` world matrices of the rig's joints, or None.
        start: time of the first frame [s], counted from midnight if it is a timecode.
        notes: what was repaired on reading.
    """

    names: tuple[str, ...]
    values: Floats
    fps: float
    head: Floats | None = None
    eyes: Floats | None = None
    joints: Floats | None = None
    start: float = 0.0
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "names", distinct(self.names, "channels"))
        put(self, "values", floats(self.values, (None, len(self.names)), "channel values", nan=True))
        f = len(self.values)
        put(self, "fps", checked_fps(self.fps))
        if self.head is not None:
            put(self, "head", floats(self.head, (f, 4, 4), "head motion"))
        if self.eyes is not None:
            put(self, "eyes", floats(self.eyes, (f, 2, 3), "eye rotations", nan=True))
        if self.joints is not None:
            put(self, "joints", floats(self.joints, (f, None, 4, 4), "joint matrices"))

    def __len__(self) -> int:
        return len(self.values)

    def channels(self, wanted: Sequence[str]) -> Floats:
        """Return `(F, len(wanted))` values in the wanted order, 0 where a channel is absent."""
        where = matching(self.names, wanted)
        picked = self.values[:, np.maximum(where, 0)] if self.names else np.zeros((len(self), len(wanted)))
        return np.where(where >= 0, picked, 0.0)


def checked_fps(fps: float) -> float:
    """Return `fps` if it is a usable frame rate.

    Raises:
        InputError: it is not a positive finite number.
    """
    if not (np.isfinite(fps) and fps > 0):
        raise InputError(f"the frame rate must be a positive number, but is {fps}.")
    return float(fps)
