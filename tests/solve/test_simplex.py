from __future__ import annotations

from ctypes import c_int

import daqp
import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from mien.core import InputError
from mien.solve.simplex import project_simplex, simplex_qp, solve_simplices


def definite(rng: np.random.Generator, n: int, rank: int | None = None) -> np.ndarray:
    a = rng.normal(size=(rank or n + 2, n))
    return a.T @ a


def by_slsqp(Q: np.ndarray, q: np.ndarray) -> np.ndarray:
    found = minimize(
        lambda x: 0.5 * x @ Q @ x - q @ x,
        np.full(len(q), 1 / len(q)),
        jac=lambda x: Q @ x - q,
        bounds=[(0, 1)] * len(q),
        constraints=[{"type": "eq", "fun": lambda x: x.sum() - 1, "jac": lambda x: np.ones_like(x)}],
        options={"ftol": 1e-15, "maxiter": 500},
    )
    return found.x


def by_daqp(Q: np.ndarray, q: np.ndarray, sizes: tuple[int, ...]) -> np.ndarray:
    """Dual active sets: an exact solver of another kind."""
    rows = np.zeros((len(sizes), len(q)))
    for row, (begin, size) in zip(rows, zip(np.cumsum((0, *sizes)), sizes, strict=False), strict=True):
        row[begin : begin + size] = 1
    upper = np.concatenate([np.full(len(q), 1e30), np.ones(len(sizes))])
    lower = np.concatenate([np.zeros(len(q)), np.ones(len(sizes))])
    sense = np.concatenate([np.zeros(len(q), c_int), np.full(len(sizes), 5, c_int)]).astype(c_int)
    x, *_ = daqp.solve(Q, -q, rows, upper, lower, sense)
    return np.asarray(x)


def test_projection_is_the_closest_share(rng: np.random.Generator) -> None:
    for n in (1, 2, 3, 12, 44):
        points = rng.normal(0, 2, (40, n))
        closest = project_simplex(points)
        assert closest.min() >= 0
        assert np.abs(closest.sum(axis=1) - 1).max() < 1e-14
        for point, share in zip(points[:5], closest[:5], strict=True):
            assert np.abs(by_daqp(np.eye(n), point, (n,)) - share).max() < 1e-10


def test_projecting_a_share_leaves_it(rng: np.random.Generator) -> None:
    shares = rng.dirichlet(np.ones(7), 50)
    assert np.abs(project_simplex(shares) - shares).max() < 1e-15


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6, 9])
def test_a_small_problem_is_solved_as_slsqp_solves_it(n: int, rng: np.random.Generator) -> None:
    for _ in range(10):
        Q, q = definite(rng, n), rng.normal(0, 3, n)
        mine = simplex_qp(Q, q)
        assert np.abs(mine.x - by_slsqp(Q, q)).max() < 1e-6
        assert np.abs(mine.x - by_daqp(Q, q, (n,))).max() < 1e-9
        assert mine.kkt < 1e-12


def test_faces_and_active_sets_agree(rng: np.random.Generator) -> None:
    for _ in range(50):
        Q, q = definite(rng, 3, 2), rng.normal(size=3)
        value = [0.5 * x @ Q @ x - q @ x for x in (simplex_qp(Q, q).x, solve_simplices(Q, q, (3,)).x)]
        assert abs(value[0] - value[1]) < 1e-10


def test_three_simplices_of_44_shares_are_solved_as_daqp_solves_them(rng: np.random.Generator) -> None:
    sizes = (29, 12, 3)
    for rank in (60, 44, 20):
        Q, q = definite(rng, 44, rank) / rank + 1e-6 * np.eye(44), rng.normal(0, 0.5, 44)
        mine = solve_simplices(Q, q, sizes)
        peer = by_daqp(Q, q, sizes)
        assert mine.kkt < 1e-10
        assert np.abs(np.add.reduceat(mine.x, [0, 29, 41]) - 1).max() < 1e-14
        assert mine.x.min() >= 0
        assert np.abs(mine.x - peer).max() < (1e-8 if rank > 20 else 1e-4)
        energy = [0.5 * x @ Q @ x - q @ x for x in (mine.x, peer)]
        assert energy[0] <= energy[1] + 1e-10


def test_an_interior_point_method_finds_no_better_optimum(rng: np.random.Generator) -> None:
    sizes = (5, 4, 3)
    Q, q = definite(rng, 12), rng.normal(size=12)
    rows = np.repeat(np.eye(3), sizes, axis=1)
    peer = minimize(
        lambda x: 0.5 * x @ Q @ x - q @ x,
        np.repeat(1 / np.array(sizes), sizes),
        jac=lambda x: Q @ x - q,
        hess=lambda x: Q,
        method="trust-constr",
        bounds=[(0, None)] * 12,
        constraints=[LinearConstraint(rows, 1, 1)],
        options={"gtol": 1e-12, "xtol": 1e-14, "barrier_tol": 1e-14, "maxiter": 2000},
    )
    mine = solve_simplices(Q, q, sizes).x
    assert 0.5 * mine @ Q @ mine - q @ mine <= peer.fun + 1e-8


def test_a_warm_start_at_the_optimum_takes_no_step(rng: np.random.Generator) -> None:
    Q, q = definite(rng, 44), rng.normal(0, 4, 44)
    first = solve_simplices(Q, q, (29, 12, 3))
    again = solve_simplices(Q, q, (29, 12, 3), first.x)
    assert again.steps == 0
    assert np.array_equal(again.x, first.x)
    assert first.steps > 0


def test_equal_columns_and_no_curvature_still_give_an_optimum(rng: np.random.Generator) -> None:
    a = rng.normal(size=(8, 5))
    twice = np.concatenate([a, a[:, :3]], axis=1)
    for Q, q in ((twice.T @ twice, twice.T @ rng.normal(size=8)), (np.zeros((8, 8)), rng.normal(size=8))):
        solved = solve_simplices(Q, q, (5, 3))
        assert solved.kkt < 1e-9
        assert np.abs(np.add.reduceat(solved.x, [0, 5]) - 1).max() < 1e-14


def test_bad_input_is_refused_in_words(rng: np.random.Generator) -> None:
    Q, q = definite(rng, 4), rng.normal(size=4)
    for call, why in (
        (lambda: project_simplex([np.nan, 1]), "finite"),
        (lambda: simplex_qp(-Q, q), "semi-definite"),
        (lambda: simplex_qp(Q, q[:3]), "variables"),
        (lambda: solve_simplices(Q, q, (2, 0, 2)), "at least one"),
        (lambda: solve_simplices(Q, q, (2, 3)), "q"),
        (lambda: solve_simplices(Q, q, (2, 2), [0.5, 0.6, 1, 0]), "sum 1"),
    ):
        with pytest.raises(InputError, match=why):
            call()
