"""The solve with correctives: exact derivatives, a true minimum, and weights that come back."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import least_squares

from mien.core import InputError
from mien.core.correctives import Correctives, correctives_of
from mien.solve import LassoProblem, solve_driven, solve_lasso
from mien.solve.driven import rules_of
from mien.solve.driven_kernels import chain, energy, expand, place

DRIVERS = 8


def rig(rng: np.random.Generator, points: int = 60) -> tuple[np.ndarray, Correctives]:
    """Shapes of a made-up rig, `(K, 3 M)`: free ones, combinations of two and three, and in-betweens."""
    names = [f"s{k}" for k in range(DRIVERS)]
    rules = {f"{a}_{b}": {a: 1, b: 1} for a, b in pairwise(names)}
    rules |= {"s0_s3_s6": {"s0": 1, "s3": 1, "s6": 1}, "s1_50": {"s1": 0.5}, "s1_80": {"s1": 0.8}, "s2_40": {"s2": 0.4}}
    rules |= {"s2_40_s5": {"s2": 0.4, "s5": 1}}
    shapes = rng.normal(size=(DRIVERS + len(rules), 3 * points))
    shapes[DRIVERS:] *= 0.3
    return shapes, correctives_of(rules, [*names, *rules])


def problem(shapes: np.ndarray, l1: float = 0.0, ridge: float = 0.0) -> LassoProblem:
    gram = shapes @ shapes.T / shapes.shape[1]
    return LassoProblem(gram + ridge * np.eye(len(gram)), l1, 0.0, 1.0)


def drawn(correctives: Correctives, size: int, frames: int, rng: np.random.Generator) -> np.ndarray:
    """Smooth curves between 0 and 1, completed."""
    t = np.linspace(0, 2 * np.pi, frames)[:, None]
    weights = np.zeros((frames, size))
    waves = np.sin(t * rng.uniform(0.5, 1.5, DRIVERS) + rng.uniform(0, 6, DRIVERS))
    weights[:, :DRIVERS] = np.clip(0.45 + 0.6 * waves, 0, 1)
    return correctives.complete(weights)


def test_weights_become_data_and_come_back(rng: np.random.Generator) -> None:
    shapes, correctives = rig(rng)
    truth = drawn(correctives, len(shapes), 60, rng)
    data = truth @ shapes
    solved = solve_driven(problem(shapes), correctives, data @ shapes.T / shapes.shape[1], tol=1e-10)
    assert solved.converged
    np.testing.assert_allclose(solved.weights, truth, atol=1e-6)


def test_the_gradient_is_that_of_finite_differences(rng: np.random.Generator) -> None:
    shapes, correctives = rig(rng)
    posed = problem(shapes)
    q = rng.normal(size=len(shapes))
    rules = rules_of(correctives, len(shapes))
    before = rng.uniform(size=DRIVERS)
    low, high, u, full = np.empty(DRIVERS), np.empty(DRIVERS), np.empty(len(shapes)), np.empty(len(shapes))
    slopes, g = np.zeros(rules[2].shape), np.empty(DRIVERS)

    def value(w: np.ndarray) -> float:
        place(rules, w, low, high)
        expand(rules, w, low, high, u, slopes)
        return float(energy(posed.gram, posed.l1[rules[0]], q, w, u, before, 0.0, full))

    for w in rng.uniform(0.05, 0.95, (20, DRIVERS)):
        step = 1e-6 * np.eye(DRIVERS)
        numeric = [(value(w + e) - value(w - e)) / 2e-6 for e in step]
        value(w)
        chain(rules, slopes, full, g)
        np.testing.assert_allclose(g, numeric, atol=2e-8, rtol=1e-6)
        completed = np.zeros(len(shapes))
        completed[rules[0]] = w
        np.testing.assert_allclose(u, correctives.complete(completed), atol=1e-15)


@pytest.mark.parametrize("l1", [0.0, 0.05])
def test_noisy_frames_end_at_a_minimum_no_worse_than_a_general_solver_finds(
    l1: float, rng: np.random.Generator
) -> None:
    shapes, correctives = rig(rng)
    truth = drawn(correctives, len(shapes), 12, rng)
    data = truth @ shapes + 0.3 * rng.normal(size=(12, shapes.shape[1]))
    posed = problem(shapes, l1, 1e-3)
    q = data @ shapes.T / shapes.shape[1]
    solved = solve_driven(posed, correctives, q, tol=1e-9)
    assert solved.converged
    root = np.linalg.cholesky(posed.gram).T
    for w, one in zip(solved.weights, q, strict=True):

        def completed(x: np.ndarray) -> np.ndarray:
            return correctives.complete(np.concatenate([x, np.zeros(len(shapes) - DRIVERS)]))

        def value(x: np.ndarray, one: np.ndarray = one) -> float:
            return float(posed.objective(completed(x), one) - l1 * (completed(x)[DRIVERS:]).sum())

        for _ in range(50):
            beside = np.clip(w[:DRIVERS] + rng.normal(0, 1e-3, DRIVERS), 0, 1)
            assert value(beside) >= value(w[:DRIVERS]) - 1e-12
        if l1 == 0:
            target = np.linalg.solve(root.T, one)
            peer = least_squares(
                lambda x, target=target: root @ completed(x) - target, w[:DRIVERS].clip(1e-3, 1 - 1e-3), bounds=(0, 1)
            )
            assert value(w[:DRIVERS]) <= value(peer.x) + 1e-9


def test_without_active_correctives_it_is_the_lasso(rng: np.random.Generator) -> None:
    shapes, _ = rig(rng)
    none = Correctives(np.empty(0, np.int64), np.empty((0, 2), np.int64), np.empty((0, 2)))
    q = rng.normal(size=(20, len(shapes)))
    for smoothness in (0.0, 0.3):
        known = solve_lasso(problem(shapes, 0.02), q, smoothness=smoothness, tol=1e-10)
        found = solve_driven(problem(shapes, 0.02), none, q, smoothness=smoothness, tol=1e-10)
        np.testing.assert_allclose(found.weights, known.weights, atol=1e-8)


def test_frames_one_by_one_are_the_whole_clip_and_a_solved_frame_is_left_alone(rng: np.random.Generator) -> None:
    shapes, correctives = rig(rng)
    posed = problem(shapes, 0.01)
    q = drawn(correctives, len(shapes), 15, rng) @ shapes @ shapes.T / shapes.shape[1]
    whole = solve_driven(posed, correctives, q, smoothness=0.1).weights
    before = None
    for one, w in zip(q, whole, strict=True):
        before = solve_driven(posed, correctives, one, before, smoothness=0.1).weights
        np.testing.assert_array_equal(before, w)
    first = solve_driven(posed, correctives, q[-1], whole[-1]).weights
    again = solve_driven(posed, correctives, q[-1], first, smoothness=0.1).weights
    np.testing.assert_array_equal(again, first)


def test_a_minimum_at_the_peak_of_an_in_between_is_found_and_held() -> None:
    shapes = np.array([[1.0, 0.0], [0.0, 2.0]])
    correctives = correctives_of({"a50": {"a": 0.5}}, ["a", "a50"])
    solved = solve_driven(problem(shapes), correctives, np.array([0.5, 2.2]) @ shapes.T / 2, tol=1e-12)
    assert solved.converged
    np.testing.assert_allclose(solved.weights, [0.5, 1.0], atol=1e-12)


def test_what_cannot_be_solved_is_refused(rng: np.random.Generator) -> None:
    shapes, correctives = rig(rng)
    posed = problem(shapes)
    with pytest.raises(InputError, match="beyond"):
        solve_driven(problem(shapes[:9]), correctives, np.zeros(9))
    with pytest.raises(InputError, match="frame 1"):
        solve_driven(posed, correctives, np.array([[0.0] * len(shapes), [np.nan] * len(shapes)]))
    paired = LassoProblem(posed.gram, 0.0, 0.0, 1.0, np.array([[0, 1]]))
    with pytest.raises(InputError, match="exclude"):
        solve_driven(paired, correctives, np.zeros(len(shapes)))
