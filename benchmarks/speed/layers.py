"""Layers of every frame: mien's solver beside SciPy's SLSQP and trust-constr on the same frames.

    python -m benchmarks.speed.layers
    MIEN_DATA=/path/to/data python -m benchmarks.speed.layers    # with a real rig and take too

The peers solve the joint problem of a frame from the frame before, as mien does, posed both
ways: as the paper poses it, on the points, with slopes by finite differences and its tolerance
of 1e-6; and helped, with mien's Gram matrices, analytic gradients and a tight tolerance.
`objective over mien` is the peer's objective divided by mien's, less 1, on the same frame: above 0 mien is better.
One thread, timed in seconds of the processor; live latency is by the clock on the wall.  Other jobs on
the machine take caches and clock rate all the same, so mien's frames per second and latencies are the
best of several passes, and how much faster than a peer it is goes by the mean of passes before and
after that peer.  Compilation happens before the clock starts.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import LinearConstraint, minimize
from threadpoolctl import threadpool_limits

from benchmarks.report import Row, publish
from benchmarks.speed.frames import bumps, spread
from mien.capture import learn_stabiliser
from mien.core import Labels
from mien.core.arrays import Floats
from mien.geometry.align import Similarity
from mien.io.formats import read_clip, read_rig
from mien.library.characters import globe
from mien.retargeting.layers.actor import Actor
from mien.retargeting.layers.choose import choose_extremes
from mien.retargeting.layers.comparison import compare_layers
from mien.retargeting.layers.compose import projection
from mien.retargeting.layers.decompose import BEGINNING, Decomposer
from mien.retargeting.layers.model import LayeredFace, natural_regions
from mien.retargeting.layers.retargeter import LayeredRetargeter
from mien.retargeting.layers.sources import layers_of_rig, picked_layers, rig_face
from mien.vocabularies import match

POINTS = 99
SMOOTH = 1e-4
CURVE = (40, 99, 500, 2000, 20000)
PASSES = 5
"""Times that mien is timed, of which the best counts."""


@dataclass(frozen=True, eq=False)
class Take:
    """A face in layers and what it does, in centimetres."""

    name: str
    face: LayeredFace
    moved: Floats

    def decomposer(self) -> Decomposer:
        """Return what takes it apart."""
        return Decomposer(self.face, np.ones(len(self.face.rest)), SMOOTH)

    def resampled(self, count: int) -> Take:
        """Return the take at another number of points: fewer of them, or all of them again and again."""
        rows = np.resize(np.arange(len(self.face.rest)), count)
        if count < len(self.face.rest):
            rows = spread(self.face.rest, count)
        layers = tuple(replace(layer, offsets=layer.offsets[:, rows]) for layer in self.face.layers)
        regions = Labels(self.face.regions.names, self.face.regions.of[rows])
        moved = np.ascontiguousarray(self.moved[:, rows])
        return Take(self.name, LayeredFace(self.face.rest[rows], layers, regions), moved)


def made_by_code(frames: int = 600) -> Take:
    """The library's globe, which has all 44 extremes, acted by wandering shares, with noise."""
    rng = np.random.default_rng(4)
    rig = globe()
    moving = np.flatnonzero(np.linalg.norm(rig.blendshapes.deltas, axis=2).max(axis=0) > 1e-3)
    rows = moving[spread(rig.neutral.vertices[moving], POINTS)]
    whole = rig_face(rig, masks=("body", "mouths", "eyes"))
    layers = tuple(replace(layer, offsets=100 * layer.offsets[:, rows]) for layer in whole.layers)
    face = LayeredFace(100 * whole.rest[rows], layers, Labels(whole.regions.names, whole.regions.of[rows]))
    shares = [bumps(frames, k, rng) + 1e-2 for k in face.sizes]
    weights = np.stack([bumps(frames, 3, rng) + 1e-1 for _ in range(3)], axis=1)
    alpha = np.concatenate([s / s.sum(axis=1, keepdims=True) for s in shares], axis=1)
    moved = face.compose(weights / weights.sum(axis=2, keepdims=True), alpha) - face.rest
    return Take("globe, made by code", face, moved + rng.normal(0, 0.02, moved.shape))


def real(folder: Path, take: str = "S07-001", rig_name: str = "ict_face") -> Take:
    """A recorded take on a real face; its extremes are frames of the take, chosen by rule."""
    rig = read_rig(folder / "rigs" / f"{rig_name}.glb")
    clip = read_clip(folder / "clips" / "livelink" / f"{take}.csv")
    values = np.nan_to_num(clip.values) @ match(clip.names, rig.blendshapes.names).matrix.T
    moving = np.flatnonzero(np.linalg.norm(rig.blendshapes.deltas, axis=2).max(axis=0) > 1e-3)
    rows = moving[spread(rig.neutral.vertices[moving], POINTS)]
    moved = 100 * np.tensordot(values, rig.blendshapes.deltas[:, rows], axes=1)
    moved += np.random.default_rng(2).normal(0, 0.01, moved.shape)
    whole = natural_regions(layers_of_rig(rig))
    regions = Labels(whole.names, whole.of[rows])
    names = [f"p{i}" for i in range(len(rows))]
    layers = picked_layers(choose_extremes(moved, regions), moved, names)
    return Take(f"{rig_name} plays {take}", LayeredFace(100 * rig.neutral.vertices[rows], layers, regions), moved)


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame's joint problem, posed both ways."""

    take: Take
    decomposer: Decomposer
    data: Floats
    energy: float
    moved: Floats
    before: Floats

    def helped(self, z: Floats) -> tuple[float, Floats]:
        """Objective and gradient from the Gram matrices."""
        problem = self.decomposer.problem(np.ones(len(self.moved), bool), SMOOTH)
        cut = problem.regions * problem.layers
        value, slope, _ = problem.evaluate(
            z[:cut].reshape(problem.regions, problem.layers), z[cut:], self.data, self.energy, 0.0, self.before
        )
        return value, slope

    def on_points(self, z: Floats) -> float:
        """Objective from the points, as written: a sum over all of them in square millimetres, for which 1e-6 is tight."""
        face = self.take.face
        cut = len(face.regions.names) * len(face.layers)
        weights, alpha = z[:cut].reshape(len(face.regions.names), -1), z[cut:]
        outputs = [
            np.tensordot(alpha[a:b], layer.offsets, axes=1)
            for layer, a, b in zip(face.layers, face.starts[:-1], face.starts[1:], strict=True)
        ]
        share = weights[face.regions.of]
        made = sum(share[:, j, None] * out for j, out in enumerate(outputs))
        value = ((self.moved - made) ** 2).sum() / len(self.moved) + SMOOTH * ((z - self.before) ** 2).sum()
        return float(100 * len(self.moved) * value)


Solver = Callable[[Frame, Floats], Floats]


def slsqp(help_: bool) -> Solver:
    def solve(frame: Frame, rows: Floats) -> Floats:
        found = minimize(
            frame.helped if help_ else frame.on_points,
            frame.before,
            jac=help_ or None,
            method="SLSQP",
            bounds=[(0, 1)] * len(frame.before),
            constraints=[{"type": "eq", "fun": lambda z: rows @ z - 1, "jac": lambda z: rows}],
            options={"ftol": 1e-12 if help_ else 1e-6, "maxiter": 500},
        )
        return np.asarray(found.x)

    return solve


def trust_constr(help_: bool) -> Solver:
    def solve(frame: Frame, rows: Floats) -> Floats:
        found = minimize(
            frame.helped if help_ else frame.on_points,
            frame.before,
            jac=True if help_ else "2-point",
            method="trust-constr",
            bounds=[(0, 1)] * len(frame.before),
            constraints=[LinearConstraint(rows, 1, 1)],
            options={"gtol": 1e-9 if help_ else 1e-6, "maxiter": 1000},
        )
        return np.asarray(found.x)

    return solve


def on_simplices(z: Floats, rows: Floats) -> Floats:
    """Put a peer's answer exactly on the simplices, so that objectives can be compared."""
    positive = np.maximum(z, 0.0)
    return np.asarray(positive / (rows.T @ (rows @ positive)))


def passes(decomposer: Decomposer, moved: Floats) -> list[float]:
    """Return the processor's seconds for a take, several times."""
    seconds = []
    for _ in range(PASSES):
        start = time.process_time()
        decomposer.decompose(moved)
        seconds.append(time.process_time() - start)
    return seconds


def solver_rows(take: Take, peers: dict[str, tuple[Solver, int]]) -> list[Row]:
    """Return one row per solver."""
    decomposer = take.decomposer()
    found = decomposer.decompose(take.moved)
    seconds = passes(decomposer, take.moved)
    case: Row = {"take": take.name, "points": len(take.face.rest), "extremes": "+".join(map(str, take.face.sizes))}
    rows: list[Row] = [
        case
        | {
            "solver": "mien",
            "frames": len(take.moved),
            "frames/s": len(take.moved) / min(seconds),
            "frames/s, mean pass": len(take.moved) / float(np.mean(seconds)),
            "worst KKT": float(found.kkt.max()),
            "rounds": float(found.rounds.mean()),
        }
    ]
    data, energy = decomposer.project(take.moved)
    z = np.concatenate([found.weights.reshape(len(found.weights), -1), found.coefficients], axis=1)
    blocks = [len(take.face.layers)] * len(take.face.regions.names) + list(take.face.sizes)
    sums = np.repeat(np.eye(len(blocks)), blocks, axis=1)
    for name, (solve, count) in peers.items():
        chosen = np.linspace(1, len(take.moved) - 1, count).astype(int)
        excess, spent, before = [], 0.0, passes(decomposer, take.moved)
        for f in chosen:
            frame = Frame(take, decomposer, data[f], energy[f], take.moved[f], z[f - 1])
            start = time.process_time()
            answer = solve(frame, sums)
            spent += time.process_time() - start
            excess.append(frame.helped(on_simplices(answer, sums))[0] / found.objective[f] - 1)
        ours = float(np.mean(before + passes(decomposer, take.moved))) / len(take.moved)
        quantiles = np.quantile(excess, [0, 0.5, 1])
        rows.append(
            case
            | {
                "solver": name,
                "frames": count,
                "frames/s": count / spent,
                "objective over mien: mean": float(np.mean(excess)),
                "least": float(quantiles[0]),
                "median": float(quantiles[1]),
                "most": float(quantiles[2]),
                "mien is faster by": spent / count / ours,
            }
        )
    return rows


def curve_rows(take: Take) -> list[Row]:
    """Return the speed at several numbers of points: the solve alone, and with the projection of the points."""
    rows = []
    for count in CURVE:
        other = take.resampled(count)
        decomposer, moved = other.decomposer(), other.moved[:300]
        decomposer.decompose(moved[:3])
        projecting = []
        for _ in range(PASSES):
            start = time.process_time()
            decomposer.project(moved)
            projecting.append(time.process_time() - start)
        whole = min(passes(decomposer, moved))
        alone = whole - min(projecting)  # of two minima: on a busy machine it may not be positive
        rows.append(
            {
                "take": take.name,
                "points": count,
                "frames/s": len(moved) / whole,
                "frames/s, solve alone": len(moved) / alone if alone > 0 else float("nan"),
                "projection, GFlop/s": 6e-9 * count * sum(take.face.sizes) * len(moved) / min(projecting),
            }
        )
    return rows


def least_times(run: Callable[[], list[float]]) -> dict[str, float]:
    """Return quantiles [ms] over the frames of a stream, each frame at its best of three passes."""
    late = 1e3 * np.min([run() for _ in range(3)], axis=0)
    return {"median ms": float(np.median(late[1:])), "99 % ms": float(np.quantile(late[1:], 0.99))}


def latency_row(take: Take) -> Row:
    """Time a live stream: displacements in, layers out, one frame at a time."""

    def stream() -> list[float]:
        decomposer, memory, times = take.decomposer(), BEGINNING, []
        for frame in take.moved:
            start = time.perf_counter()
            _, memory = decomposer.follow(frame[None], memory=memory)
            times.append(time.perf_counter() - start)
        return times

    return {"take": take.name, "points": len(take.face.rest), "live": "layers"} | least_times(stream)


def step_row(take: Take) -> Row:
    """Time a whole live step: markers in, the globe's blendshape weights out; head motion taken out between."""
    rig, rest = globe(), take.face.rest
    names = tuple(f"p{i}" for i in range(len(rest)))
    points = take.moved + rest
    still = learn_stabiliser(rest, points, [])
    actor = Actor(names, rest, np.ones(len(rest)), still, np.zeros(len(rest), bool))
    character = rig_face(rig)
    retargeter = LayeredRetargeter(
        rig.blendshapes.names, actor, take.decomposer(), character, projection(rig, character), nowhere(), 30.0
    )

    def stream() -> list[float]:
        state, times = retargeter.start(), []
        for frame in points:
            start = time.perf_counter()
            state, _ = retargeter.step(state, frame)
            times.append(time.perf_counter() - start)
        return times

    return {"take": take.name, "points": len(rest), "live": "markers to weights of the globe"} | least_times(stream)


def nowhere() -> Similarity:
    """Return no placement: the heads are in one space."""
    return Similarity(1.0, np.eye(3), np.zeros(3), 0.0, 0.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=200, help="frames for the helped SLSQP")
    parser.add_argument("--few", type=int, default=5, help="frames for the slow peers")
    parser.add_argument("--no-figure", action="store_true", help="leave out the reconstruction table")
    arguments = parser.parse_args()
    peers = {
        "SLSQP, helped": (slsqp(True), arguments.frames),
        "SLSQP on the points": (slsqp(False), arguments.few),
        "trust-constr, helped": (trust_constr(True), arguments.few),
        "trust-constr on the points": (trust_constr(False), max(1, arguments.few // 5)),
    }
    named = os.environ.get("MIEN_DATA", "")
    takes = [made_by_code()] + ([real(Path(named))] if named else [])
    rows: list[Row] = []
    with threadpool_limits(1):
        for take in takes:
            rows += solver_rows(take, peers) + curve_rows(take) + [latency_row(take), step_row(take)]
            if not arguments.no_figure:
                figures = compare_layers(take.decomposer(), take.moved).figures()
                rows.append({"take": take.name, "points": len(take.face.rest), "figure 8": str(figures)})
    publish("speed_layers", "Layers per frame, one thread", rows, ("numpy", "scipy", "numba", "mien"))


if __name__ == "__main__":
    main()
