"""Whole clips at once: against SciPy's sparse solver, against a bounded solver, and at the edges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import lsq_linear
from scipy.sparse.linalg import spsolve

from mien.core import InputError
from mien.core.arrays import Floats
from mien.solve.spacetime import ClipProblem, solve_clip, solve_uniform


def clip_problem(
    rng: np.random.Generator, frames: int = 40, size: int = 6, kinds: int = 3, l1: float = 0.0, bound: float = np.inf
) -> tuple[ClipProblem, Floats, Floats]:
    """Return a problem of frames that see different things, its roots `R` and data: `½|R x − data|²`."""
    rows = 2 * size
    seen, tied = rng.normal(size=(kinds, rows, size)), rng.normal(size=(kinds, rows, size))
    which, joined = rng.integers(kinds, size=frames), rng.integers(kinds, size=frames - 1)
    roots, data = [], []
    for f in range(frames):
        row = np.zeros((rows, frames * size))
        row[:, f * size : (f + 1) * size] = seen[which[f]]
        roots.append(row)
        data.append(rng.normal(size=rows))
    for f in range(frames - 1):
        row = np.zeros((rows, frames * size))
        row[:, f * size : (f + 1) * size] = -tied[joined[f]]
        row[:, (f + 1) * size : (f + 2) * size] = tied[joined[f]]
        roots.append(row)
        data.append(rng.normal(size=rows))
    root, wanted = np.concatenate(roots), np.concatenate(data)
    hessian = root.T @ root
    blocks = np.stack([hessian[f * size : (f + 1) * size, f * size : (f + 1) * size] for f in range(frames)])
    links = np.stack([t.T @ t for t in tied])
    load = (root.T @ wanted).reshape(frames, size)
    limits = (np.full(size, l1), np.full(size, 0.0 if np.isfinite(bound) else -np.inf), np.full(size, bound))
    return ClipProblem(blocks, np.arange(frames), links, joined, load, *limits), root, wanted


def test_without_bounds_it_is_the_sparse_system_in_one_step(rng: np.random.Generator) -> None:
    problem, root, wanted = clip_problem(rng)
    solved = solve_clip(problem, np.zeros(problem.load.shape), tol=1e-10)
    reference = spsolve(sparse.csc_matrix(root.T @ root), root.T @ wanted).reshape(problem.load.shape)
    assert solved.converged
    assert np.abs(solved.weights - reference).max() < 1e-8
    assert solved.rounds == 1


def test_with_bounds_it_is_what_a_bounded_solver_finds(rng: np.random.Generator) -> None:
    problem, root, wanted = clip_problem(rng, bound=0.3)
    solved = solve_clip(problem, np.zeros(problem.load.shape))
    reference = lsq_linear(root, wanted, bounds=(0.0, 0.3), tol=1e-13, max_iter=500).x.reshape(problem.load.shape)
    assert solved.converged
    assert solved.kkt <= 1e-8
    assert np.abs(solved.weights - reference).max() < 1e-6
    assert 0.1 < (solved.weights == 0).mean() < 0.9


@pytest.mark.parametrize("bound", [np.inf, 0.4])
def test_no_point_nearby_is_lower(rng: np.random.Generator, bound: float) -> None:
    problem, _, _ = clip_problem(rng, l1=2.0, bound=bound)
    solved = solve_clip(problem, np.zeros(problem.load.shape)).weights
    least = problem.objective(solved)
    assert (solved == 0).any()
    for size in (1e-3, 1e-2, 0.1):
        other = np.clip(solved + rng.normal(0, size, solved.shape), problem.lower, problem.upper)
        assert problem.objective(other) > least


def test_any_start_leads_to_the_same_weights(rng: np.random.Generator) -> None:
    problem, _, _ = clip_problem(rng, l1=1.0, bound=0.5)
    one = solve_clip(problem, np.zeros(problem.load.shape)).weights
    other = solve_clip(problem, rng.uniform(0, 0.5, problem.load.shape)).weights
    assert np.abs(one - other).max() < 1e-7


def test_the_uniform_way_is_the_sparse_system(rng: np.random.Generator) -> None:
    gram, link = (m.T @ m for m in rng.normal(size=(2, 8, 5)))
    load = rng.normal(size=(30, 5))
    chain = sparse.diags([np.r_[1, np.full(28, 2.0), 1], -np.ones(29), -np.ones(29)], [0, 1, -1])
    whole = sparse.kron(sparse.eye(30), gram) + sparse.kron(chain, link)
    reference = spsolve(whole.tocsc(), load.ravel()).reshape(load.shape)
    assert np.abs(solve_uniform(gram, link, load) - reference).max() < 1e-9


def test_the_uniform_way_takes_the_smallest_of_many_solutions(rng: np.random.Generator) -> None:
    half = rng.normal(size=(2, 5))
    gram = half.T @ half
    load = rng.normal(size=(7, 5)) @ gram
    found = solve_uniform(gram, 0.5 * gram, load)
    assert np.isfinite(found).all()
    assert np.abs(found @ (np.eye(5) - np.linalg.pinv(gram) @ gram)).max() < 1e-9


def test_equal_shapes_and_a_shape_that_does_nothing_are_no_trouble(rng: np.random.Generator) -> None:
    problem, _, _ = clip_problem(rng, size=5, bound=1.0)
    copies = np.array([0, 1, 2, 3, 4, 4])
    blocks = np.pad(problem.blocks[:, copies][:, :, copies], ((0, 0), (0, 1), (0, 1)))
    links = np.pad(problem.links[:, copies][:, :, copies], ((0, 0), (0, 1), (0, 1)))
    load = np.pad(problem.load[:, copies], ((0, 0), (0, 1)))
    doubled = ClipProblem(blocks, problem.which, links, problem.joined, load, np.zeros(7), np.zeros(7), np.ones(7))
    solved = solve_clip(doubled, np.zeros(load.shape))
    assert solved.converged
    assert not solved.weights[:, 6].any()


def test_one_frame_is_a_clip_too(rng: np.random.Generator) -> None:
    problem, _, _ = clip_problem(rng, frames=2)
    one = replace(problem, which=problem.which[:1], joined=problem.joined[:0], load=problem.load[:1])
    solved = solve_clip(one, np.zeros((1, 6)))
    assert np.allclose(one.blocks[0] @ solved.weights[0], one.load[0])


def test_what_does_not_fit_is_refused(rng: np.random.Generator) -> None:
    problem, _, _ = clip_problem(rng)
    with pytest.raises(InputError, match="links of frames"):
        replace(problem, joined=problem.joined[1:])
    with pytest.raises(InputError, match="cross"):
        replace(problem, lower=np.ones(6), upper=np.zeros(6))
    with pytest.raises(InputError, match="load"):
        replace(problem, load=problem.load * np.nan)
