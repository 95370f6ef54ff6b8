"""The landmarks that stand opposite each other across an eye or the mouth.

Whether lids close and lips meet is measured (`evaluate.gaps`) and asked for
(`retargeting.contact`) at the same points.
"""

from __future__ import annotations

from collections.abc import Mapping

Facing = tuple[tuple[int, int], ...]
"""iBUG numbers (Sagonas et al. 2013) of an upper and a lower landmark that face each other."""

RIGHT_LIDS: Facing = ((37, 41), (38, 40))
LEFT_LIDS: Facing = ((43, 47), (44, 46))
INNER_LIPS: Facing = ((61, 67), (62, 66), (63, 65))

LIDS: Mapping[str, Facing] = {"right lids": RIGHT_LIDS, "left lids": LEFT_LIDS}
LIPS: Mapping[str, Facing] = {"lips": INNER_LIPS}
"""Openings by name."""
