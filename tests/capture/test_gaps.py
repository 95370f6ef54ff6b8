"""Bridging gaps: against SciPy's monotone cubics, and never beyond what was seen."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from mien.capture.gaps import monotone_cubic


@pytest.mark.parametrize("count", [2, 3, 4, 30])
@pytest.mark.parametrize("whole", [False, True])
def test_the_cubics_are_scipy_s(rng: np.random.Generator, count: int, whole: bool) -> None:
    for _ in range(30):
        x = np.sort(rng.choice(100, count, replace=False))
        y = rng.normal(size=(count, 3)) if not whole else rng.integers(-2, 3, (count, 3)).astype(float)
        at = np.arange(x[0], x[-1] + 1)
        assert np.allclose(monotone_cubic(x, y, at), PchipInterpolator(x, y, axis=0)(at), rtol=0, atol=1e-13)


def test_nothing_overshoots(rng: np.random.Generator) -> None:
    x, y = np.arange(0, 100, 10), rng.normal(size=(10, 3))
    between = monotone_cubic(x, y, np.arange(91))
    low, high = np.minimum(y[:-1], y[1:]), np.maximum(y[:-1], y[1:])
    for i in range(9):
        part = between[10 * i : 10 * i + 11]
        assert (part >= low[i] - 1e-12).all()
        assert (part <= high[i] + 1e-12).all()
