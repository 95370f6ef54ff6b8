"""Which colour each part of a head has: goats have horns and tortoises are green, which no general table knows."""

from __future__ import annotations

from collections.abc import Mapping

from mien.core import Mesh
from mien.core.rig import Colour


def of_groups(mesh: Mesh, parts: Mapping[str, Colour]) -> dict[str, Colour]:
    """Return the colours of vertex groups, in the order of the parts.

    Args:
        mesh: a head.
        parts: by group, or by what a group's name starts with before `_left` and the like.
    """
    return {
        group: colour
        for part, colour in parts.items()
        for group in mesh.groups
        if group == part or group.startswith(part + "_")
    }
