"""A rig of 50 shapes and 120 correctives: mien's exact solve beside SciPy's trust-region least squares.

    python -m benchmarks.speed.correctives

The rig is the built-in actor: combinations for the 90 pairs of shapes that overlap most, 10 triples
and 20 in-betweens, made by code.  Both solvers minimise the same energy, fit and a ridge, between 0
and 1, frame after frame from the frame before; SciPy's `trf` gets the analytic Jacobian of the
residuals at all markers.  `worse` is the mean excess of its energy over mien's.  For comparison:
the published solver of the quartic model takes 1.9 s a frame (Racković et al. 2023, their rigs).
"""

from __future__ import annotations

import argparse
import time
from itertools import combinations

import numpy as np
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from benchmarks.report import Row, publish
from benchmarks.speed.frames import MARKERS, bumps, spread
from mien.core import Correctives
from mien.core.arrays import Floats, Ints
from mien.core.correctives import correctives_of
from mien.library import actor
from mien.solve import LassoProblem, solve_driven
from mien.solve.driven import rules_of
from mien.solve.driven_kernels import expand, place

PAIRS, TRIPLES, BETWEEN = 90, 10, 20
RIDGE = 0.003
"""Damping, as a share of each shape's movement: the default of mien's solve."""
NOISE_CM = 0.02
LEFT_OUT = ("tongueOut", "jawForward")


def corrected(rng: np.random.Generator) -> tuple[Floats, Correctives, tuple[str, ...]]:
    """Return shapes at the markers `(K, 3 M)` [cm], which of them follow from which, and their names."""
    rig = actor()
    kept = [k for k, name in enumerate(rig.blendshapes.names) if name not in LEFT_OUT]
    names = [rig.blendshapes.names[k] for k in kept]
    deltas, vertices = 100 * rig.blendshapes.deltas[kept], 100 * rig.neutral.vertices
    moving = np.flatnonzero(np.abs(deltas).max(axis=(0, 2)) > 0.1)
    shapes = deltas[:, moving[spread(vertices[moving], MARKERS)]]
    size = np.linalg.norm(shapes, axis=2)
    overlap = {pair: np.minimum(size[pair[0]], size[pair[1]]).sum() for pair in combinations(range(len(names)), 2)}
    pairs = sorted(overlap, key=overlap.__getitem__, reverse=True)
    found = [np.minimum(*size[list(p)])[:, None] * _unit(shapes[list(p)].sum(axis=0)) * -0.4 for p in pairs[:PAIRS]]
    rules = {f"{names[a]}_{names[b]}": {names[a]: 1.0, names[b]: 1.0} for a, b in pairs[:PAIRS]}
    for a, b in pairs[:TRIPLES]:
        overlaps = np.minimum(size, size[[a, b]].min(axis=0)).sum(axis=1)
        overlaps[[a, b]] = 0
        c = int(overlaps.argmax())
        rules[f"{names[a]}_{names[b]}_{names[c]}"] = {names[k]: 1.0 for k in (a, b, c)}
        found.append(0.2 * size[[a, b, c]].min(axis=0)[:, None] * _unit(rng.normal(size=(MARKERS, 3))))
    for k in np.argsort(-size.sum(axis=1))[:BETWEEN]:
        rules[f"{names[k]}50"] = {names[k]: 0.5}
        found.append(0.15 * size[k][:, None] * np.array([0.0, 0.3, 1.0]))
    every = (*names, *rules)
    return np.concatenate([shapes, found]).reshape(len(every), -1), correctives_of(rules, every), every


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))


def trf(
    shapes: Floats, correctives: Correctives, clip: Floats, damping: Floats, frames: int
) -> tuple[Floats, list[float]]:
    """Solve frames with `scipy.optimize.least_squares`, from the frame before, and time each."""
    rules = rules_of(correctives, len(shapes))
    free, slopes = rules[0], np.zeros(rules[2].shape)
    low, high = np.empty(len(free)), np.empty(len(free))
    scale, root = np.sqrt(1 / MARKERS), np.sqrt(damping)
    weights, times = np.zeros((frames, len(shapes))), []
    x = np.full(len(free), 1e-3)

    def completed(x: Floats) -> Floats:
        w = np.zeros(len(shapes))
        w[free] = x
        return correctives.complete(w)

    def jacobian(x: Floats) -> Floats:
        place(rules, x, low, high)
        expand(rules, x, low, high, np.empty(len(shapes)), slopes)
        whole = np.zeros((len(free) + 1, len(shapes)))
        for drivers, slope in zip(rules[2].T, slopes.T, strict=True):
            np.add.at(whole, (drivers, correctives.shapes), slope)
        whole[np.arange(len(free)), free] = 1.0
        return np.concatenate([scale * (whole[:-1] @ shapes), whole[:-1] * root], axis=1).T

    for f in range(frames):

        def residuals(x: Floats, frame: Floats = clip[f]) -> Floats:
            u = completed(x)
            return np.concatenate([scale * (u @ shapes - frame), root * u])

        begin = time.perf_counter()
        x = least_squares(residuals, np.clip(x, 1e-6, 1 - 1e-6), jacobian, bounds=(0, 1), ftol=1e-8, xtol=1e-8).x
        times.append(time.perf_counter() - begin)
        weights[f] = completed(x)
    return weights, times


def rows(frames: int, peer_frames: int) -> list[Row]:
    """Solve a sparse and a dense take."""
    rng = np.random.default_rng(5)
    shapes, correctives, names = corrected(rng)
    damping = RIDGE * (shapes**2).sum(axis=1) / MARKERS
    gram = 2 / MARKERS * shapes @ shapes.T + 2 * np.diag(damping)
    problem = LassoProblem(gram, np.zeros(len(gram)), np.zeros(len(gram)), np.ones(len(gram)))
    free = np.setdiff1d(np.arange(len(names)), correctives.shapes)
    solve_driven(problem, correctives, np.zeros(len(names)))
    result: list[Row] = []
    for take, layers in (("sparse", 1), ("dense", 4)):
        truth = np.zeros((frames, len(names)))
        truth[:, free] = np.minimum(sum(bumps(frames, len(free), rng) for _ in range(layers)), 1)
        truth = correctives.complete(truth)
        clip = truth @ shapes + rng.normal(0, NOISE_CM, (frames, shapes.shape[1]))
        q = 2 / MARKERS * clip @ shapes.T
        times, weights, before, left = [], np.empty_like(truth), None, 0.0
        for f in range(frames):
            begin = time.perf_counter()
            solved = solve_driven(problem, correctives, q[f], before)
            times.append(time.perf_counter() - begin)
            before = weights[f] = solved.weights
            left = max(left, float(solved.kkt))
        begin = time.perf_counter()
        solve_driven(problem, correctives, q)
        whole = (time.perf_counter() - begin) / frames
        shared = {"take": take, "shapes": len(free), "correctives": len(correctives)}
        shared["active"] = float((truth[:, free] > 0.01).sum(axis=1).mean())
        result.append(
            shared
            | {"solver": "mien", "frames": frames, "ms a frame": 1000 * whole, "live p50 ms": 1000 * np.median(times)}
            | {"live p99 ms": 1000 * np.quantile(times, 0.99), "kkt": left, "weights off": _rms(weights - truth, free)}
        )
        found, spent = trf(shapes, correctives, clip, damping, peer_frames)
        excess = problem.objective(found, q[:peer_frames]) - problem.objective(weights[:peer_frames], q[:peer_frames])
        result.append(
            shared
            | {"solver": "SciPy trf", "frames": peer_frames, "ms a frame": 1000 * float(np.mean(spent))}
            | {"live p50 ms": 1000 * np.median(spent), "live p99 ms": 1000 * np.quantile(spent, 0.99)}
            | {"weights off": _rms(found - truth[:peer_frames], free), "worse": float(excess.mean())}
            | {"times slower": float(np.mean(spent)) / whole}
        )
        linear = solve_driven(problem, _none(), q)
        result.append(shared | {"solver": "mien, correctives free", "weights off": _rms(linear.weights - truth, free)})
    return result


def _none() -> Correctives:
    return Correctives(np.empty(0, np.int64), np.empty((0, 1), np.int64), np.empty((0, 1)))


def _rms(difference: Floats, free: Ints) -> float:
    return float(np.sqrt((difference[:, free] ** 2).mean()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=600, help="frames of each take")
    parser.add_argument("--peer-frames", type=int, default=40, help="frames given to SciPy")
    args = parser.parse_args()
    with threadpool_limits(1):
        found = rows(args.frames, args.peer_frames)
    about = "Weights of a rig with correctives, M = 99 markers, one thread, KKT 1e-6"
    publish("speed_correctives", about, found, ["numpy", "scipy", "numba", "mien"])


if __name__ == "__main__":
    main()
