"""A lasso whose matrix has something added in some frames."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import InputError
from mien.core.correctives import correctives_of
from mien.solve import LassoProblem, Varying, solve_driven, solve_lasso


def problem(rng: np.random.Generator, size: int = 12) -> LassoProblem:
    shapes = rng.normal(size=(size, 40))
    return LassoProblem(shapes @ shapes.T / 40, 0.01, 0.0, 1.0)


def varying(rng: np.random.Generator, frames: int, size: int = 12) -> Varying:
    rows = rng.normal(size=(2, 3, size))
    shares = np.clip(rng.normal(0.3, 0.6, (frames, 2)), 0, None)
    return Varying(rows.transpose(0, 2, 1) @ rows, shares)


@pytest.mark.parametrize("smoothness", [0.0, 0.2])
def test_each_frame_is_the_lasso_in_its_own_matrix(smoothness: float, rng: np.random.Generator) -> None:
    posed, q = problem(rng), rng.normal(size=(15, 12))
    added = varying(rng, 15)
    solved = solve_lasso(posed, q, smoothness=smoothness, tol=1e-10, varying=added)
    before = None
    for one, share, w in zip(q, added.shares, solved.weights, strict=True):
        own = LassoProblem(posed.gram + np.tensordot(share, added.forms, 1), posed.l1, 0.0, 1.0)
        alone = solve_lasso(own, one, before, smoothness=smoothness, tol=1e-10).weights
        np.testing.assert_allclose(w, alone, atol=1e-8)
        step = solve_lasso(
            posed, one, before, smoothness=smoothness, tol=1e-10, varying=Varying(added.forms, share)
        ).weights
        np.testing.assert_allclose(w, step, atol=1e-9)
        before = w


def test_shares_of_nothing_change_nothing_bit_for_bit(rng: np.random.Generator) -> None:
    posed, q = problem(rng), rng.normal(size=(15, 12))
    none = Varying(varying(rng, 15).forms, np.zeros((15, 2)))
    for smoothness in (0.0, 0.2):
        plain = solve_lasso(posed, q, smoothness=smoothness).weights
        np.testing.assert_array_equal(solve_lasso(posed, q, smoothness=smoothness, varying=none).weights, plain)


def test_correctives_take_what_varies_too(rng: np.random.Generator) -> None:
    posed, q = problem(rng), rng.normal(size=(5, 12))
    names = [f"s{k}" for k in range(12)]
    correctives = correctives_of({"s11": {"s0": 1, "s1": 1}}, names)
    added = varying(rng, 5)
    solved = solve_driven(posed, correctives, q, tol=1e-9, varying=added)
    assert solved.converged
    own = LassoProblem(posed.gram + np.tensordot(added.shares[0], added.forms, 1), posed.l1, 0.0, 1.0)
    np.testing.assert_allclose(solved.weights[0], solve_driven(own, correctives, q[0], tol=1e-9).weights, atol=1e-7)


@pytest.mark.parametrize(
    ("forms", "shares", "said"),
    [
        (np.zeros((2, 12, 11)), np.zeros((5, 2)), "varying forms must have shape"),
        (np.zeros((2, 12, 12)), np.zeros((4, 2)), "shares of varying forms must have shape"),
        (np.zeros((2, 12, 12)), -np.ones((5, 2)), "not be negative"),
        (np.zeros((2, 12, 12)), np.full((5, 2), np.nan), "NaN"),
    ],
)
def test_what_does_not_belong_is_refused(
    forms: np.ndarray, shares: np.ndarray, said: str, rng: np.random.Generator
) -> None:
    with pytest.raises(InputError, match=said):
        solve_lasso(problem(rng), np.zeros((5, 12)), varying=Varying(forms, shares))
