"""The lasso against its optimality conditions, three independent solvers, and the behaviours an animator sees."""

from __future__ import annotations

import itertools

import daqp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear
from sklearn.linear_model import Lasso

from mien.core import InputError
from mien.solve import LassoProblem, solve_lasso, symmetric_penalty


def random_fit(rng: np.random.Generator, rows: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    return rng.normal(size=(rows, size)), rng.normal(size=rows)


@st.composite
def awkward_problems(draw: st.DrawFn) -> tuple[LassoProblem, np.ndarray]:
    """Random Gram matrices of every rank, with duplicated, nearly duplicated and empty shapes, and mixed bounds."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    size = draw(st.integers(1, 20))
    columns, target = random_fit(rng, draw(st.integers(1, 30)), size)
    columns *= 10.0 ** rng.uniform(-draw(st.integers(0, 2)), 0, size)
    for _ in range(draw(st.integers(0, 3))):
        a, b = rng.integers(size, size=2)
        columns[:, a] = columns[:, b] * draw(st.sampled_from([1.0, -1.0, 0.0]))
        columns[:, a] += draw(st.sampled_from([0.0, 1e-4])) * rng.normal(size=len(target))
    l1 = draw(st.sampled_from([0.0, 0.01, 0.3])) * rng.uniform(0, 1, size) * np.abs(columns.T @ target).max()
    lower = np.where(rng.random(size) < draw(st.sampled_from([0, 0.5, 1])), rng.uniform(-1, 0.2, size), -np.inf)
    upper = np.where(rng.random(size) < draw(st.sampled_from([0, 0.5, 1])), rng.uniform(0.2, 1, size), np.inf)
    return LassoProblem(columns.T @ columns, l1, lower, upper), columns.T @ target


@settings(deadline=None, max_examples=300)
@given(awkward_problems())
def test_the_optimality_conditions_hold_on_awkward_problems(case: tuple[LassoProblem, np.ndarray]) -> None:
    problem, q = case
    found = solve_lasso(problem, q, tol=1e-9, max_sweeps=200)
    rounding = 1e-14 * (np.abs(problem.gram) @ np.abs(found.weights)).max() / max(problem.scale(q), 1e-300)
    assert problem.kkt(found.weights, q) <= max(1.1e-9, rounding)
    assert found.converged or rounding > 1e-9
    assert (found.weights >= problem.lower).all()
    assert (found.weights <= problem.upper).all()


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32), strength=st.floats(0.01, 0.9))
def test_it_agrees_with_scikit_learn(seed: int, strength: float) -> None:
    columns, target = random_fit(np.random.default_rng(seed), 30, 12)
    l1 = strength * np.abs(columns.T @ target).max()
    found = solve_lasso(LassoProblem(columns.T @ columns, l1), columns.T @ target, tol=1e-12)
    peer = Lasso(alpha=l1 / len(target), fit_intercept=False, tol=1e-14, max_iter=100_000).fit(columns, target)
    assert np.allclose(found.weights, peer.coef_, atol=1e-6)
    assert ((found.weights == 0) == (np.abs(peer.coef_) < 1e-9)).all()


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 2**32))
def test_it_agrees_with_bounded_least_squares(seed: int) -> None:
    columns, target = random_fit(np.random.default_rng(seed), 25, 10)
    problem = LassoProblem(columns.T @ columns, 0.0, -0.1, 0.2)
    peer = lsq_linear(columns, target, (-0.1, 0.2), method="bvls", tol=1e-14)
    assert np.allclose(solve_lasso(problem, columns.T @ target, tol=1e-12).weights, peer.x, atol=1e-9)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 2**32))
def test_it_agrees_with_a_quadratic_programme_when_weights_cannot_be_negative(seed: int) -> None:
    rng = np.random.default_rng(seed)
    columns, target = random_fit(rng, 25, 10)
    gram, q, l1 = columns.T @ columns, columns.T @ target, rng.uniform(0, 5, 10)
    peer, _, flag, _ = daqp.solve(gram, l1 - q, np.empty((0, 10)), np.full(10, 0.3), np.zeros(10))
    assert flag == 1
    assert np.allclose(solve_lasso(LassoProblem(gram, l1, 0.0, 0.3), q, tol=1e-12).weights, peer, atol=1e-6)


@settings(deadline=None, max_examples=50)
@given(awkward_problems(), st.integers(0, 2**32))
def test_no_other_weights_cost_less(case: tuple[LassoProblem, np.ndarray], seed: int) -> None:
    problem, q = case
    found = solve_lasso(problem, q, tol=1e-10, max_sweeps=200).weights
    rng = np.random.default_rng(seed)
    others = found + rng.normal(size=(200, len(q))) * 10.0 ** rng.uniform(-6, 0, (200, 1))
    others = np.clip(others, problem.lower, problem.upper)
    size = np.abs(found) @ np.abs(problem.gram) @ np.abs(found) + np.abs(found) @ np.abs(q)
    slack = problem.kkt(found, q) * problem.scale(q) * np.abs(others - found).sum(axis=1) + 1e-14 * size
    costs = problem.objective(others, np.broadcast_to(q, others.shape))
    assert (costs >= problem.objective(found, q) - 1.01 * slack).all()


def test_duplicated_shapes_converge_to_rounding_in_a_few_sweeps(rng: np.random.Generator) -> None:
    columns, target = random_fit(rng, 300, 50)
    columns[:, 25:] = columns[:, :25] + 1e-4 * rng.normal(size=(300, 25))
    for l1, bound in itertools.product((1e-3, 0.1, 3.0), (np.inf, 1.0)):
        problem, q = LassoProblem(columns.T @ columns, l1, -bound, bound), columns.T @ target
        found = solve_lasso(problem, q, tol=1e-11)
        assert found.converged
        assert found.sweeps < 20


def test_a_shape_that_moves_nothing_stays_at_zero_or_the_bound_nearest_it() -> None:
    problem = LassoProblem(np.diag([1.0, 0.0, 0.0]), 0.1, np.array([-1, -1, 0.2]), 1.0)
    assert solve_lasso(problem, np.array([0.5, 0.0, 0.0])).weights.tolist() == [0.4, 0.0, 0.2]


def test_a_problem_without_a_minimum_is_reported_as_not_converged() -> None:
    found = solve_lasso(LassoProblem(np.diag([1.0, 0.0]), 0.1), np.array([0.5, 0.5]), max_sweeps=20)
    assert not found.converged


def test_weights_too_weak_for_the_penalty_are_exactly_zero(rng: np.random.Generator) -> None:
    columns, target = random_fit(rng, 40, 15)
    q = columns.T @ target
    weights = solve_lasso(LassoProblem(columns.T @ columns, np.abs(q).max() * 1.001), q).weights
    assert (weights == 0).all()
    assert not np.signbit(weights).any()


def clip_problem(rng: np.random.Generator, frames: int = 60) -> tuple[LassoProblem, np.ndarray]:
    columns = rng.normal(size=(90, 20))
    truth = np.maximum(np.sin(np.linspace(0, 9, frames)[:, None] * rng.uniform(0.5, 2, 20) + rng.uniform(0, 6, 20)), 0)
    seen = truth @ columns.T + rng.normal(size=(frames, 90)) * 0.05
    return LassoProblem(columns.T @ columns, 3.0, -0.2, 1.0), seen @ columns


def test_warm_and_cold_starts_agree(rng: np.random.Generator) -> None:
    problem, q = clip_problem(rng)
    batch = solve_lasso(problem, q, tol=1e-12)
    cold = np.stack([solve_lasso(problem, frame, tol=1e-12).weights for frame in q])
    assert batch.converged
    assert np.abs(batch.weights - cold).max() < 1e-10


@pytest.mark.parametrize("smoothness", [0.0, 7.0])
def test_frame_by_frame_equals_the_whole_clip_exactly(rng: np.random.Generator, smoothness: float) -> None:
    problem, q = clip_problem(rng)
    problem = LassoProblem(problem.gram, problem.l1, problem.lower, problem.upper, np.array([[0, 1], [2, 3]]))
    previous, one_by_one = None, []
    for frame in q:
        previous = solve_lasso(problem, frame, previous, smoothness=smoothness).weights
        one_by_one.append(previous)
    assert np.array_equal(solve_lasso(problem, q, smoothness=smoothness).weights, one_by_one)


@pytest.mark.parametrize("smoothness", [0.1, 10.0, 1000.0])
@pytest.mark.parametrize("pairs", [np.empty((0, 2), int), np.array([[0, 1], [4, 7]])])
def test_a_held_pose_is_held_exactly_and_reached_from_anywhere(
    rng: np.random.Generator, smoothness: float, pairs: np.ndarray
) -> None:
    problem, q = clip_problem(rng)
    problem = LassoProblem(problem.gram, problem.l1, problem.lower, problem.upper, pairs)
    held = np.repeat(q[20:21], 2000, axis=0)
    sharp = solve_lasso(problem, q[20], tol=1e-10).weights
    assert (solve_lasso(problem, held[:50], sharp, smoothness=smoothness, tol=1e-10).weights == sharp).all()
    if not len(pairs):
        late = solve_lasso(problem, held, np.zeros(20), smoothness=smoothness, tol=1e-10).weights[-1]
        assert np.abs(late - sharp).max() < 1e-6


def test_smoothness_lessens_the_jitter(rng: np.random.Generator) -> None:
    problem, q = clip_problem(rng)
    jitter = [np.abs(np.diff(solve_lasso(problem, q, smoothness=s).weights, axis=0)).sum() for s in (0, 20, 200)]
    assert jitter[0] > jitter[1] > jitter[2]


def test_one_exclusive_pair_is_solved_to_the_better_of_its_two_sides(rng: np.random.Generator) -> None:
    for _ in range(20):
        columns, target = random_fit(rng, 30, 8)
        gram, q = columns.T @ columns, columns.T @ target
        problem = LassoProblem(gram, 0.5, exclusive=np.array([[2, 5]]))
        found = solve_lasso(problem, q, tol=1e-11).weights
        costs = []
        for zeroed in (2, 5):
            bound = np.where(np.arange(8) == zeroed, 0.0, np.inf)
            costs.append(problem.objective(solve_lasso(LassoProblem(gram, 0.5, -bound, bound), q).weights, q))
        assert found[2] == 0 or found[5] == 0
        assert problem.objective(found, q) == pytest.approx(min(costs), abs=1e-8)


def test_several_exclusive_pairs_all_hold_and_come_close_to_the_best_combination(rng: np.random.Generator) -> None:
    columns, target = random_fit(rng, 60, 8)
    gram, q = columns.T @ columns, columns.T @ target
    pairs = np.array([[0, 1], [2, 3], [4, 5]])
    problem = LassoProblem(gram, 0.1, exclusive=pairs)
    found = solve_lasso(problem, q).weights
    assert (found[pairs] == 0).any(axis=1).all()
    costs = []
    for zeroed in itertools.product(*pairs):
        bound = np.where(np.isin(np.arange(8), zeroed), 0.0, np.inf)
        costs.append(float(problem.objective(solve_lasso(LassoProblem(gram, 0.1, -bound, bound), q).weights, q)))
    assert min(costs) - 1e-9 <= problem.objective(found, q) < np.median(costs)


def test_a_symmetric_pair_is_drawn_together_as_its_penalty_grows(rng: np.random.Generator) -> None:
    columns, target = random_fit(rng, 30, 6)
    gaps = []
    for strength in (0.0, 10.0, 1e6):
        gram = columns.T @ columns + symmetric_penalty(6, [(1, 4)], strength)
        weights = solve_lasso(LassoProblem(gram, 0.0), columns.T @ target, tol=1e-10).weights
        gaps.append(abs(weights[1] - weights[4]))
    assert gaps[0] > gaps[1] > gaps[2]
    assert gaps[2] < 1e-5
    w = rng.normal(size=6)
    assert 0.5 * w @ symmetric_penalty(6, [(1, 4), (0, 2)], 3.0) @ w == pytest.approx(
        3 * ((w[1] - w[4]) ** 2 + (w[0] - w[2]) ** 2)
    )


def test_the_unit_of_length_changes_nothing(rng: np.random.Generator) -> None:
    problem, q = clip_problem(rng)
    larger = LassoProblem(1e4 * problem.gram, 1e4 * problem.l1, problem.lower, problem.upper)
    assert np.allclose(solve_lasso(larger, 1e4 * q).weights, solve_lasso(problem, q).weights, atol=1e-12)


def test_inputs_are_left_as_they_were(rng: np.random.Generator) -> None:
    problem, q = clip_problem(rng)
    start, before = np.full(20, 0.5), q.copy()
    solve_lasso(problem, q, start, smoothness=1.0)
    assert np.array_equal(q, before)
    assert (start == 0.5).all()


def test_no_frames_give_no_weights() -> None:
    found = solve_lasso(LassoProblem(np.eye(3), 0.1), np.empty((0, 3)))
    assert found.weights.shape == (0, 3)
    assert found.converged


def test_an_untracked_frame_is_named() -> None:
    q = np.zeros((9, 3))
    q[4, 1] = np.nan
    with pytest.raises(InputError, match="frame 4"):
        solve_lasso(LassoProblem(np.eye(3), 0.1), q)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"gram": -np.eye(3)}, "semi-definite"),
        ({"l1": -0.1}, "negative"),
        ({"l1": np.inf}, "infinite"),
        ({"l1": np.zeros(2)}, "one per shape"),
        ({"lower": 1.0, "upper": 0.0}, "between its bounds"),
        ({"lower": np.inf}, "between its bounds"),
        ({"exclusive": np.array([[0, 3]])}, "index 3"),
        ({"exclusive": np.array([[1, 1]])}, "itself"),
        ({"exclusive": np.array([[1, 2]]), "lower": 0.1}, "allowed to be 0"),
    ],
)
def test_unusable_problems_are_refused_in_words(change: dict[str, np.ndarray], said: str) -> None:
    with pytest.raises(InputError, match=said):
        LassoProblem(**{"gram": np.eye(3), "l1": 0.1} | change)


def test_unusable_data_and_settings_are_refused_in_words() -> None:
    problem = LassoProblem(np.eye(3), 0.1)
    with pytest.raises(InputError, match="shape"):
        solve_lasso(problem, np.zeros(4))
    with pytest.raises(InputError, match="starting weights"):
        solve_lasso(problem, np.zeros(3), np.zeros(2))
    with pytest.raises(InputError, match="smoothness"):
        solve_lasso(problem, np.zeros(3), smoothness=-1.0)
    with pytest.raises(InputError, match="tolerance"):
        solve_lasso(problem, np.zeros(3), tol=0.0)
    with pytest.raises(InputError, match="strength"):
        symmetric_penalty(3, [(0, 1)], -1.0)
