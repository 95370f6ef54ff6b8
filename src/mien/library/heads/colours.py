"""Which colour each vertex of a head has: goats have horns and tortoises are green, which no general table knows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mien.core import Rig
from mien.core.arrays import Floats


def painted(rig: Rig, colours: Mapping[str, tuple[float, float, float]]) -> Floats:
    """Return the `(N, 3)` linear colour of each vertex: that of the last part in `colours` that holds it.

    Args:
        rig: a head of the cast, bare or rigged.
        colours: by group, or by what a group's name starts with before `_left` and the like.
    """
    colour = np.full((len(rig.neutral.vertices), 3), 0.5)
    for part, value in colours.items():
        for group, vertices in rig.neutral.groups.items():
            if group == part or group.startswith(part + "_"):
                colour[vertices] = value
    return colour
