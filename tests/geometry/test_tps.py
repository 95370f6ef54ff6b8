from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from mien.core import InputError
from mien.geometry.tps import fit_thin_plate


def test_the_warp_interpolates_its_points(rng: np.random.Generator) -> None:
    p, q = rng.normal(size=(40, 3)), rng.normal(size=(40, 3))
    assert np.abs(fit_thin_plate(p, q)(p) - q).max() < 1e-10


@pytest.mark.parametrize("smoothing", [0.0, 0.5])
def test_affine_maps_are_reproduced_exactly(rng: np.random.Generator, smoothing: float) -> None:
    p, x = rng.normal(size=(30, 3)), rng.normal(size=(50, 3))
    matrix, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    warp = fit_thin_plate(p, p @ matrix.T + shift, smoothing)
    assert np.abs(warp(x) - (x @ matrix.T + shift)).max() < 1e-9
    assert np.abs(warp.bend).max() < 1e-9


@pytest.mark.parametrize("smoothing", [0.0, 0.3])
def test_the_warp_agrees_with_scipy(rng: np.random.Generator, smoothing: float) -> None:
    p, q, x = rng.normal(size=(60, 3)), rng.normal(size=(60, 3)), rng.normal(size=(200, 3))
    reference = RBFInterpolator(p, q, kernel="linear", degree=1, smoothing=smoothing)(x)
    assert np.abs(fit_thin_plate(p, q, smoothing)(x) - reference).max() < 1e-9


def test_the_jacobian_is_the_derivative(rng: np.random.Generator) -> None:
    warp = fit_thin_plate(rng.normal(size=(20, 3)), rng.normal(size=(20, 3)))
    x, h = rng.normal(size=(10, 3)), 1e-6
    numeric = np.stack([(warp(x + h * e) - warp(x - h * e)) / (2 * h) for e in np.eye(3)], axis=-1)
    assert np.abs(warp.jacobian(x) - numeric).max() < 1e-7


def test_four_points_give_the_affine_map(rng: np.random.Generator) -> None:
    p, q = rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    assert np.abs(fit_thin_plate(p, q)(p) - q).max() < 1e-10


def test_too_few_coplanar_or_coinciding_points_are_refused(rng: np.random.Generator) -> None:
    p = rng.normal(size=(10, 3))
    with pytest.raises(InputError, match="at least 4"):
        fit_thin_plate(p[:3], p[:3])
    with pytest.raises(InputError, match="one plane"):
        fit_thin_plate(p * [1, 1, 0], p)
    with pytest.raises(InputError, match="points 2 and 7"):
        fit_thin_plate(np.where(np.arange(10)[:, None] == 7, p[2], p), p)
