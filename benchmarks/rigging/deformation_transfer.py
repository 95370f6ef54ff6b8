"""Deformation transfer, factored once for all shapes, against the usual solve with fourth vertices, shape by shape.

    python -m benchmarks.rigging.deformation_transfer
    python -m benchmarks.rigging.deformation_transfer --peer-shapes 5

Moves every shape of ICT-FaceKit's head onto another identity of the same triangulation.  No
public implementation installs from the package index, so the peer restates what the
public ones do: the system of Sumner & Popović 2004, eq. 8, in the vertices *and* the
fourth vertices, its normal equations factored by SciPy's sparse LU with default ordering
for every shape.  Triangle correspondences and held vertices are the same on both sides, and
so is the answer.  Times are of the processor, one thread.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from benchmarks.report import ROOT, Row, publish
from benchmarks.rigging.ground_truth import exact, identity, load
from mien.core.arrays import Floats, Ints
from mien.rigging.blendshapes import dense
from mien.rigging.blendshapes.deformation_transfer import Anchors, counterparts, solve
from mien.rigging.blendshapes.gradients import frames


def fourth_vertex_system(target: Floats, triangles: Ints) -> sparse.csr_matrix:
    """Return `(3T, N + T)`: the rows of eq. 8 for one coordinate."""
    inverse = np.linalg.inv(frames(target, triangles))
    hats = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
    t, n = len(triangles), len(target)
    columns = np.column_stack([triangles, n + np.arange(t)])
    rows = 3 * np.arange(t)[:, None, None] + np.arange(3) + np.zeros((1, 4, 1), np.int64)
    places = (rows.ravel(), np.repeat(columns[:, :, None], 3, axis=2).ravel())
    return sparse.csr_matrix((hats.ravel(), places), shape=(3 * t, n + t))


def shape_by_shape(
    source: Floats, deltas: Floats, target: Floats, triangles: Ints, origin: Ints, guess: Floats, held: np.ndarray
) -> Floats:
    """Solve for each shape on its own, as the public implementations do."""
    result = np.array(guess)
    for shape, delta in zip(result, deltas, strict=True):
        system = fourth_vertex_system(target, triangles)
        wanted = (frames(source + delta, triangles) @ np.linalg.inv(frames(source, triangles)))[origin]
        right = wanted.transpose(0, 2, 1).reshape(-1, 3)
        free = np.flatnonzero(np.concatenate([~held, np.ones(len(triangles), np.bool_)]))
        right = right - system[:, np.flatnonzero(held)] @ (target + shape)[held]
        rest = system[:, free]
        solved = splu((rest.T @ rest).tocsc()).solve(np.asarray(rest.T @ right))
        shape[~held] = solved[: int((~held).sum())] - target[~held]
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")))
    parser.add_argument("--peer-shapes", type=int, default=3, help="shapes that the peer is timed on")
    args = parser.parse_args()
    rig = load(args.data, "ict_face")
    deltas = rig.blendshapes.deltas
    fit = exact(rig, identity(args.data, rig, seed=1))
    source, target, triangles = rig.neutral.vertices, fit.target.vertices, rig.neutral.triangles
    with threadpool_limits(1):
        guess = dense.transfer(deltas, fit, fit.back)
        start = time.process_time()
        ours = solve(source, triangles, deltas, target, triangles, fit.back, guess=guess, turn=np.eye(3))
        seconds = time.process_time() - start
        origin = counterparts(source, triangles, fit.back, triangles)
        anchors = Anchors.of(guess, triangles)
        some = np.flatnonzero(np.abs(deltas).max(axis=(1, 2)) > 0)[: args.peer_shapes]
        start = time.process_time()
        theirs = shape_by_shape(source, deltas[some], target, triangles, origin, guess[some], anchors.held)
        peer = (time.process_time() - start) / len(some) * len(deltas)
        theirs, held = anchors.placed(theirs, guess[some]), anchors.held
    difference = float(np.abs(theirs - ours[some]).max() / np.abs(theirs).max())
    rows: list[Row] = [
        {"solver": "mien, factored once", "cpu s": seconds, "unknowns": int((~held).sum())},
        {
            "solver": f"LU of every shape, from {len(some)} of them",
            "cpu s": peer,
            "unknowns": int((~held).sum()) + len(triangles),
            "times mien's": peer / seconds,
            "difference": difference,
        },
    ]
    about = (
        f"Deformation transfer of {len(deltas)} shapes, {len(target)} vertices, {len(triangles)} triangles, one thread"
    )
    publish("rigging_deformation_transfer", about, rows, ["numpy", "scipy"])


if __name__ == "__main__":
    main()
