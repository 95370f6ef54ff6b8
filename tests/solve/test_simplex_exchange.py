from __future__ import annotations

import numpy as np

from mien.solve.simplex import solve_simplices
from mien.solve.simplex_exchange import minimise_exchanging
from mien.solve.simplex_kernels import kkt, scratch

SIZES = (29, 12, 3)
STARTS = np.concatenate([[0], np.cumsum(SIZES)])


def exchanged(matrix: np.ndarray, q: np.ndarray, start: np.ndarray) -> tuple[bool, np.ndarray]:
    x, n = start.copy(), len(start)
    found = minimise_exchanging(matrix, matrix @ x - q, STARTS, x, np.empty(n, bool), scratch(n), 1e-12)
    return found, x


def test_exchange_finds_the_minimum_that_active_sets_find(rng: np.random.Generator) -> None:
    given_up = 0
    for _ in range(60):
        a = rng.normal(size=(60, 44))
        matrix, q = a.T @ a / 60 + 1e-3 * np.eye(44), rng.normal(0, 0.5, 44)
        start = np.concatenate([rng.dirichlet(np.full(n, 0.2)) for n in SIZES])
        start[start < 0.02] = 0
        start /= np.repeat(np.add.reduceat(start, STARTS[:-1]), SIZES)
        found, x = exchanged(matrix, q, start)
        given_up += not found
        if found:
            assert x.min() >= 0
            assert np.abs(np.add.reduceat(x, STARTS[:-1]) - 1).max() < 1e-14
            assert kkt(STARTS, x, matrix @ x - q) < 1e-10
            assert np.abs(x - solve_simplices(matrix, q, SIZES, tol=1e-14).x).max() < 1e-9
    assert given_up <= 3


def test_a_problem_without_a_minimum_inside_is_given_up(rng: np.random.Generator) -> None:
    a = rng.normal(size=(44, 44))
    start = np.repeat(1 / np.array(SIZES), SIZES)
    assert not exchanged(-a.T @ a, rng.normal(size=44), start)[0]


def test_coefficients_that_nothing_pulls_stay(rng: np.random.Generator) -> None:
    """A layer without weight: no curvature and no slope in its block."""
    a = rng.normal(size=(60, 44))
    a[:, 29:41] = 0
    start = np.concatenate([rng.dirichlet(np.ones(n)) for n in SIZES])
    found, x = exchanged(a.T @ a + 1e-6 * np.diag(a.any(axis=0)), a.T @ rng.normal(size=60), start)
    assert found
    assert np.abs(x[29:41] - start[29:41]).max() < 1e-12
