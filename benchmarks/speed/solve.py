"""Weights of every frame: mien's exact lasso beside reweighted least squares and three libraries.

    python -m benchmarks.speed.solve
    MIEN_DATA=/path/to/data python -m benchmarks.speed.solve    # with a real rig and take too

Every solver gets the same Gram matrix and data vectors, one thread, and is judged by the
same two numbers: the largest KKT residual over the frames (as `LassoProblem.kkt` defines
it) and the mean excess of its energy over mien's.  Peers' weights under 1e-9 count as 0.
Compilation happens before the clock starts and is reported.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import daqp
import numpy as np
from sklearn.linear_model import Lasso
from threadpoolctl import threadpool_limits

from benchmarks.report import Row, median_seconds, publish
from benchmarks.speed.frames import Performance, performances
from mien.core.arrays import Floats
from mien.solve import LassoProblem, solve_lasso

SPARSITIES = (0.6, 0.1, 0.02)
BOUNDS = {"none": (-np.inf, np.inf), "0 to 1": (0.0, 1.0)}

Solver = Callable[[LassoProblem, Floats], Floats]


def reweighted(problem: LassoProblem, q: Floats) -> Floats:
    """Iterate reweighted least squares as the paper does, to a change of 1e-4 or 100 rounds."""
    weights = np.empty_like(q)
    w = np.ones(len(problem))
    for f, b in enumerate(q):
        w = np.where(np.abs(w) < 1e-2, 1e-2, w)
        for _ in range(100):
            previous = w
            w = np.linalg.solve(problem.gram + np.diag(problem.l1 / np.maximum(np.abs(w), 1e-8)), b)
            if np.abs(w - previous).max() < 1e-4:
                break
        weights[f] = w
    return weights


def scikit_learn(problem: LassoProblem, q: Floats) -> Floats:
    """Give scikit-learn a square root of the Gram matrix as its design, and the Gram matrix precomputed."""
    values, vectors = np.linalg.eigh(problem.gram)
    root = np.sqrt(np.maximum(values, values[-1] * 1e-14))
    design = np.asfortranarray((vectors * root).T)
    targets = (q @ vectors / root).T
    model = Lasso(
        problem.l1[0] / len(problem), fit_intercept=False, precompute=design.T @ design, tol=1e-7, max_iter=10**5
    )
    return np.asarray(model.fit(design, targets).coef_)


def daqp_bounded(problem: LassoProblem, q: Floats) -> Floats:
    """Solve for non-negative weights, where the penalty is linear, set up once and warm-started."""
    size = len(problem)
    model = daqp.Model()
    model.setup(problem.gram.copy(), problem.l1 - q[0], np.empty((0, size)), problem.upper.copy(), problem.lower.copy())
    weights = np.empty_like(q)
    for f, b in enumerate(q):
        model.update(f=problem.l1 - b)
        weights[f] = model.solve()[0]
    return weights


def daqp_split(problem: LassoProblem, q: Floats) -> Floats:
    """Split each weight into a positive and a negative part, with a ridge that makes the doubled matrix definite."""
    size = len(problem)
    gram = np.block([[problem.gram, -problem.gram], [-problem.gram, problem.gram]])
    gram += 1e-9 * problem.gram.diagonal().max() * np.eye(2 * size)
    penalty = np.tile(problem.l1, 2)
    model = daqp.Model()
    model.setup(gram, penalty, np.empty((0, 2 * size)), np.full(2 * size, 1e3), np.zeros(2 * size))
    weights = np.empty_like(q)
    for f, b in enumerate(q):
        model.update(f=penalty - np.concatenate([b, -b]))
        parts = model.solve()[0]
        weights[f] = parts[:size] - parts[size:]
    return weights


PEERS: dict[str, list[tuple[str, Solver]]] = {
    "none": [
        ("reweighted least squares", reweighted),
        ("scikit-learn Lasso", scikit_learn),
        ("daqp, split weights", daqp_split),
    ],
    "0 to 1": [("daqp, warm", daqp_bounded)],
}


def clip_rows(performance: Performance, sparsity: float, bounds: str, repeats: int, peer_frames: int) -> list[Row]:
    """Return one row per solver for one performance, sparsity and kind of bounds."""
    problem, q = performance.problem(sparsity, *BOUNDS[bounds]), performance.q()
    case: Row = {"performance": performance.name, "K": len(problem), "nu": sparsity, "bounds": bounds}
    exact = solve_lasso(problem, q, tol=1e-12).weights
    found = solve_lasso(problem, q).weights
    seconds = median_seconds(lambda: solve_lasso(problem, q), repeats)
    rows = [case | judged("mien solve_lasso", problem, q, found, exact, seconds)]
    few, exact = q[:peer_frames], exact[:peer_frames]
    for name, solver in PEERS[bounds]:
        start = time.perf_counter()
        weights = solver(problem, few)
        seconds = time.perf_counter() - start
        weights = np.clip(np.where(np.abs(weights) < 1e-9, 0.0, weights), problem.lower, problem.upper)
        rows.append(case | judged(name, problem, few, weights, exact, seconds))
    return rows


def judged(solver: str, problem: LassoProblem, q: Floats, weights: Floats, exact: Floats, seconds: float) -> Row:
    """Return how fast and how good a solver was."""
    best = problem.objective(exact, q)
    excess = (problem.objective(weights, q) - best).mean() / np.abs(best).mean()
    return {
        "solver": solver,
        "frames/s": len(q) / seconds,
        "worst KKT": float(problem.kkt(weights, q).max()),
        "excess energy": float(excess),
        "non-zero": float((weights != 0).sum(axis=1).mean()),
    }


def latency_row(performance: Performance, sparsity: float, smoothness: float) -> Row:
    """Time a live stream: one frame in, its weights out, through the Python interface, projection included."""
    problem = performance.problem(sparsity)
    projection = performance.projection
    previous, times = None, []
    for frame in performance.clip:
        start = time.perf_counter()
        previous = solve_lasso(problem, projection @ frame, previous, smoothness=smoothness).weights
        times.append(time.perf_counter() - start)
    return {
        "performance": performance.name,
        "K": len(problem),
        "nu": sparsity,
        "bounds": "none",
        "solver": f"mien, frame by frame, smoothness {smoothness:g}",
        "frames/s": 1 / float(np.median(times)),
        "median ms": 1e3 * float(np.median(times)),
        "99% ms": 1e3 * float(np.percentile(times, 99)),
    }


def compile_seconds() -> float:
    """Return what the first solve in this process costs, compiled or read from the cache."""
    start = time.perf_counter()
    solve_lasso(LassoProblem(np.eye(2), np.ones(2)), np.ones((2, 2)))
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=9, help="of ours")
    parser.add_argument("--peer-frames", type=int, default=200, help="frames given to the peers")
    args = parser.parse_args()
    rows: list[Row] = []
    with threadpool_limits(1):
        first = compile_seconds()
        for performance in performances():
            for sparsity in SPARSITIES:
                for bounds in BOUNDS:
                    rows += clip_rows(performance, sparsity, bounds, args.repeats, args.peer_frames)
            rows += [latency_row(performance, sparsity, s) for sparsity in SPARSITIES for s in (0.0, 0.1)]
    about = (
        f"Weights per frame, M = 99 markers, one thread, KKT 1e-6; first call {first:.1f} s (compiled or from cache)"
    )
    publish("speed_solve", about, rows, ["numpy", "numba", "scikit-learn", "daqp"])


if __name__ == "__main__":
    main()
