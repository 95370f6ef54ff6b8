"""Personalising the blendshapes: two eigenproblems against a sparse LU of the whole system.

    python -m benchmarks.speed.alignment

The system is that of Ribera et al. 2017, section 4.6, at the size of their largest rig:
every shape coupled to every other at each marker (dense `K × K`), every marker to its
neighbours' neighbours in each shape (a squared cotangent Laplacian).  The paper factors
it with SciPy's sparse solver and reports 5 to 23 s.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import scipy.sparse as sparse
from scipy.linalg import solve_sylvester as solve_schur
from scipy.sparse.linalg import splu
from scipy.spatial import Delaunay
from threadpoolctl import threadpool_limits

from benchmarks.report import Row, median_seconds, publish
from mien.core.arrays import Floats
from mien.geometry.laplacian import cotangent_laplacian
from mien.solve import solve_sylvester

ORDERINGS: dict[str, dict[str, object]] = {
    "SciPy sparse LU, default ordering (the paper's)": {},
    "SciPy sparse LU, minimum degree, symmetric": {
        "permc_spec": "MMD_AT_PLUS_A",
        "diag_pivot_thresh": 0.0,
        "options": {"SymmetricMode": True},
    },
}


def paper_system(shapes: int, markers: int, rng: np.random.Generator) -> tuple[Floats, sparse.csr_matrix, Floats]:
    """Return `S`, sparse `T` and `H` of a random rig: similarities, correlations, and a triangulated face."""
    deltas = rng.normal(size=(shapes, 3 * markers))
    deltas += deltas[rng.integers(shapes, size=shapes)]
    deltas /= np.linalg.norm(deltas, axis=1, keepdims=True)
    correlation = deltas @ deltas.T
    np.fill_diagonal(correlation, 0.0)
    neighbours = np.abs(correlation).sum(axis=1)
    expressions = (correlation - np.diag(correlation.sum(axis=1))) / neighbours[:, None]
    similarity = rng.uniform(0.01, 0.5, shapes)
    s = np.diag(similarity) + 0.1 / markers * expressions.T @ expressions
    plane = rng.uniform(-8, 8, (markers, 2))
    laplacian = cotangent_laplacian(np.column_stack([plane, np.zeros(markers)]), Delaunay(plane).simplices)
    return s, 0.01 / markers * (laplacian.T @ laplacian), rng.normal(size=(shapes, markers, 3))


def factor_and_solve(system: sparse.csc_matrix, h: Floats, **options: object) -> Floats:
    """Solve the assembled system for all three coordinates with one factorisation."""
    return np.asarray(splu(system, **options).solve(h.reshape(-1, 3))).reshape(h.shape)


def measure(shapes: int, markers: int, repeats: int, lu_repeats: int) -> list[Row]:
    """Return one row per solver, all on the same system."""
    s, t, h = paper_system(shapes, markers, np.random.default_rng(0))
    dense = t.toarray()
    ours = solve_sylvester(s, dense, h)
    seconds = median_seconds(lambda: solve_sylvester(s, dense, h), repeats)
    rows: list[Row] = [{"solver": "mien solve_sylvester", "ms": 1e3 * seconds, "residual": ours.residual}]
    schur = np.stack([solve_schur(s, dense, h[..., c]) for c in range(3)], axis=-1)
    schur_seconds = median_seconds(lambda: [solve_schur(s, dense, h[..., c]) for c in range(3)], repeats)
    rows.append(peer_row("SciPy solve_sylvester (Schur)", schur_seconds, seconds, schur, ours.P))
    system = sparse.csc_matrix(sparse.kron(s, sparse.eye(markers)) + sparse.kron(sparse.eye(shapes), t))
    for name, options in ORDERINGS.items():
        times, solution = [], h
        for _ in range(lu_repeats):
            start = time.perf_counter()
            solution = factor_and_solve(system, h, **options)
            times.append(time.perf_counter() - start)
        rows.append(peer_row(name, float(np.median(times)), seconds, solution, ours.P))
    return rows


def peer_row(name: str, peer_seconds: float, seconds: float, solution: Floats, ours: Floats) -> Row:
    """Return a peer's time, and how far its solution is from ours relative to the largest entry."""
    difference = float(np.abs(solution - ours).max() / np.abs(solution).max())
    return {"solver": name, "ms": 1e3 * peer_seconds, "times mien's": peer_seconds / seconds, "difference": difference}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", type=int, default=54)
    parser.add_argument("--markers", type=int, default=99)
    parser.add_argument("--repeats", type=int, default=51, help="of ours")
    parser.add_argument("--lu-repeats", type=int, default=3, help="of each sparse LU")
    args = parser.parse_args()
    with threadpool_limits(1):
        rows = measure(args.shapes, args.markers, args.repeats, args.lu_repeats)
    about = f"Blendshape alignment, K = {args.shapes} shapes, M = {args.markers} markers, 3 coordinates, one thread"
    publish("speed_alignment", about, rows, ["numpy", "scipy"])


if __name__ == "__main__":
    main()
