from __future__ import annotations

import numpy as np
import pytest

from mien.solve.definite import padded, solve_definite


def system(matrix: np.ndarray, right: np.ndarray) -> tuple[bool, np.ndarray]:
    """Solve with the upper triangle alone, rubbish everywhere else."""
    n = len(right)
    upper, x = np.full((padded(n), padded(n)), np.nan), np.full(padded(n), np.nan)
    upper[:n, :n] = np.triu(matrix) + np.tril(np.full((n, n), 1e3), -1)
    x[:n] = right
    return solve_definite(upper, n, x), x[:n]


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 7, 8, 21, 44, 53])
def test_a_definite_system_is_solved_as_lapack_solves_it(n: int, rng: np.random.Generator) -> None:
    a = rng.normal(size=(n + 5, n))
    matrix, right = a.T @ a, rng.normal(size=n)
    definite, x = system(matrix, right)
    assert definite
    assert np.abs(x - np.linalg.solve(matrix, right)).max() < 1e-9 * np.abs(x).max() * np.linalg.cond(matrix)


@pytest.mark.parametrize("n", [2, 6, 17])
def test_what_is_not_definite_is_told(n: int, rng: np.random.Generator) -> None:
    a = rng.normal(size=(n, n))
    matrix = a.T @ a
    for where in (0, n // 2, n - 1):
        bent = matrix.copy()
        bent[where, where] = -1.0
        assert not system(bent, np.ones(n))[0]
    assert not system(np.full((n, n), np.nan), np.ones(n))[0]


def test_no_unknown_is_no_work() -> None:
    assert solve_definite(np.empty((0, 0)), 0, np.empty(0))
