"""The Sylvester equation against SciPy's Schur method and a sparse LU of the whole system."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from mien.core import InputError
from mien.solve import solve_sylvester


def semidefinite(rng: np.random.Generator, size: int, rank: int) -> np.ndarray:
    factor = rng.normal(size=(rank, size))
    return factor.T @ factor


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32), k=st.integers(1, 12), m=st.integers(1, 15))
def test_it_agrees_with_the_schur_method_on_definite_matrices(seed: int, k: int, m: int) -> None:
    rng = np.random.default_rng(seed)
    s, t, h = semidefinite(rng, k, 2 * k) + np.eye(k), semidefinite(rng, m, max(m // 2, 1)), rng.normal(size=(k, m, 3))
    found = solve_sylvester(s, t, h)
    expected = np.stack([scipy.linalg.solve_sylvester(s, t, h[..., c]) for c in range(3)], axis=-1)
    assert np.allclose(found.P, expected, atol=1e-11)
    assert found.null_rank == 0
    assert found.residual < 1e-13


def test_it_agrees_with_a_sparse_lu_of_the_kronecker_system(rng: np.random.Generator) -> None:
    k, m = 9, 14
    s, t, h = semidefinite(rng, k, 12), semidefinite(rng, m, m - 1), rng.normal(size=(k, m, 3))
    system = scipy.sparse.kron(s, scipy.sparse.eye(m)) + scipy.sparse.kron(scipy.sparse.eye(k), t)
    expected = scipy.sparse.linalg.splu(system.tocsc()).solve(h.reshape(k * m, 3)).reshape(h.shape)
    assert np.abs(solve_sylvester(s, t, h).P - expected).max() < 1e-10 * np.abs(expected).max()


def test_what_the_equation_leaves_open_is_taken_from_the_null_space_values(rng: np.random.Generator) -> None:
    """A shape without evidence is known from its Laplacian only up to a translation of all markers."""
    k, m = 4, 10
    s = np.diag([1.0, 2.0, 0.0, 3.0])
    laplacian = np.eye(m) * 2 - np.roll(np.eye(m), 1, 0) - np.roll(np.eye(m), -1, 0)
    t = laplacian.T @ laplacian
    truth = rng.normal(size=(k, m, 3))
    h = np.einsum("ij,jmc->imc", s, truth) + np.einsum("kmc,mn->knc", truth, t)
    guess = rng.normal(size=(k, m, 3))
    found = solve_sylvester(s, t, h, null=guess)
    assert found.null_rank == 1
    assert found.residual < 1e-14
    moved = found.P - truth
    assert np.allclose(moved[[0, 1, 3]], 0, atol=1e-10)
    assert np.allclose(moved[2], (guess - truth)[2].mean(axis=0), atol=1e-10)
    assert np.allclose(solve_sylvester(s, t, h).P[2].mean(axis=0), 0, atol=1e-10)


def test_a_right_hand_side_the_equation_cannot_reach_shows_in_the_residual(rng: np.random.Generator) -> None:
    s, t = np.diag([1.0, 0.0]), np.zeros((3, 3))
    assert solve_sylvester(s, t, np.ones((2, 3, 1))).residual > 0.1
    assert solve_sylvester(np.zeros((2, 2)), t, np.zeros((2, 3, 1)), null=np.ones((2, 3, 1))).P.min() == 1


def test_the_result_scales_with_the_right_hand_side(rng: np.random.Generator) -> None:
    s, t, h = semidefinite(rng, 5, 9), semidefinite(rng, 6, 5), rng.normal(size=(5, 6, 3))
    assert np.allclose(solve_sylvester(1e8 * s, 1e8 * t, h).P * 1e8, solve_sylvester(s, t, h).P, rtol=1e-9)


@pytest.mark.parametrize(
    ("s", "t", "h", "said"),
    [
        (np.eye(3), np.eye(2), np.zeros((3, 3, 3)), "shape"),
        (np.eye(3)[:2], np.eye(2), np.zeros((3, 2, 3)), "square"),
        (np.array([[1.0, 2.0], [0.0, 1.0]]), np.eye(2), np.zeros((2, 2, 1)), "symmetric"),
        (-np.eye(2), np.eye(2), np.zeros((2, 2, 1)), "semi-definite"),
        (np.eye(2), np.full((2, 2), np.nan), np.zeros((2, 2, 1)), "NaN"),
        (np.empty((0, 0)), np.eye(2), np.zeros((0, 2, 1)), "square"),
    ],
)
def test_unusable_matrices_are_refused_in_words(s: np.ndarray, t: np.ndarray, h: np.ndarray, said: str) -> None:
    with pytest.raises(InputError, match=said):
        solve_sylvester(s, t, h)
