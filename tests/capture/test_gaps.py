"""Bridging gaps: never beyond what was seen on both sides."""

from __future__ import annotations

import numpy as np

from mien.capture import fill_gaps
from mien.core import Markers


def test_what_bridges_a_gap_lies_between_its_ends(rng: np.random.Generator) -> None:
    points = np.repeat(rng.normal(size=(10, 1, 3)), 10, axis=0)
    seen = points.copy()
    gaps = np.arange(100) % 10 >= 6
    gaps[-10:] = False
    seen[gaps] = np.nan
    filled = fill_gaps(Markers(("chin",), seen, 60.0)).points
    assert np.array_equal(filled[~gaps], points[~gaps])
    for start in range(5, 90, 10):
        ends = np.sort(points[[start, start + 5]], axis=0)
        bridge = filled[start : start + 6]
        assert (bridge >= ends[0] - 1e-12).all()
        assert (bridge <= ends[1] + 1e-12).all()
