"""Bones of a face solved frame by frame: mien beside SciPy's bounded least squares on the same residuals.

    MIEN_DATA=/path/to/data python -m benchmarks.speed.bones

A face of MakeHuman's 163 bones plays known mixtures of its 59 pose units; 99 points of its
skin are followed with 0.2 mm of noise.  Either the pose units are to be found again, between
0 and 1, or the turns and moves of single bones that put the skin there, between -1 and 1.
Both solvers minimise the same energy without the penalty on absolute values, each frame from
the one before; SciPy is given mien's exact derivatives.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from benchmarks.report import Row, publish
from mien.capture import Neutral, trace
from mien.core import Clip, Correspondence, Markers, Rig, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.geometry.bones import Bones
from mien.io import makehuman
from mien.io.poses import read_poses
from mien.job.bones import FREE
from mien.retargeting import make_method
from mien.retargeting.bone_solver import BoneRetargeter, BoneSolver, on_bones
from mien.retargeting.bones import free_bones, with_bone_shapes
from mien.retargeting.shape_retargeter import ShapeRetargeter

FRAMES, POINTS, NOISE_M = 240, 99, 0.0002
NOSE_TIP, FACE_M = np.array([0.0, 0.72, 0.168]), 0.1


@dataclass(frozen=True, eq=False)
class Scene:
    """What is solved: a fitted method, a take, and the skin of the face as it really was, `(F, N, 3)` [m]."""

    method: BoneRetargeter
    take: Markers
    rig: Rig
    bones: Bones
    face: Ints
    truth: Floats

    def skin_mm(self, weights: Floats) -> float:
        """Return how far the face's skin is from the truth under weights `(F, K)`, on average."""
        still = np.zeros((len(weights), 0))
        found = self.rig.only(self.face).pose(still, self.bones.world(weights))
        return 1000 * float(np.linalg.norm(found - self.truth, axis=2).mean())


def scene(data: Path, *, free: bool) -> Scene:
    """Return the take, with a method that drives named poses or single bones."""
    rig = makehuman.read_rig(data / "bones", below="neck01")
    assert rig.skeleton is not None
    poses = read_poses(data / "bones" / "face-poseunits.json", rig.skeleton)
    skin = rig.neutral.groups["body"]
    face = skin[np.linalg.norm(rig.neutral.vertices[skin] - NOSE_TIP, axis=1) < FACE_M]
    points = SurfacePoints.at_vertices(np.random.default_rng(0).choice(face, POINTS, replace=False))
    names = tuple(f"m{i:02d}" for i in range(POINTS))
    still = Clip((), np.zeros((FRAMES, 0)), 60.0, joints=poses.world(known_weights(poses)))
    clean = trace(rig, still, points, names)
    take = replace(clean, points=clean.points + np.random.default_rng(1).normal(0, NOISE_M, clean.points.shape))
    pairs = Correspondence(names, points, points)
    bones = free_bones(rig, pairs) if free else poses
    settings = {"sparsity": 0.0, "unseen": False, **(FREE if free else {})}
    neutral = Neutral(points.of(rig.neutral.vertices), None, float("nan"))
    straight = make_method("direct", settings).fit(
        with_bone_shapes(rig, bones), take, pairs, neutral=neutral, head_moves=False
    )
    assert isinstance(straight, ShapeRetargeter)
    truth = rig.only(face).pose(still.values, still.joints)
    return Scene(on_bones(straight, rig, pairs, bones), take, rig, bones, face, truth)


def known_weights(bones: Bones) -> Floats:
    """Return `(F, K)` weights of six pose units at a time, that come and go over half a second."""
    rng = np.random.default_rng(2)
    t = np.arange(FRAMES)[:, None] / 60
    centres = rng.uniform(0, FRAMES / 60, len(bones.names))
    heights = rng.uniform(0.3, 0.9, len(bones.names)) * np.array(["Tongue" not in name for name in bones.names])
    return np.asarray(heights * np.exp(-(((t - centres) / 0.25) ** 2)))


def scipy_frame(solver: BoneSolver, frame: Floats, before: Floats, follow: float) -> Floats:
    """Solve one frame as nonlinear least squares with bounds (trust region reflective)."""
    root = np.linalg.cholesky(solver.regular / 2 + 1e-12 * np.eye(len(before))).T
    scale = np.sqrt(1 / len(frame))

    def residuals(w: Floats) -> Floats:
        fit = scale * (solver.displaced(w) - frame).ravel()
        return np.concatenate([fit, root @ w, np.sqrt(follow / 2) * (w - before)])

    def slopes(w: Floats) -> Floats:
        fit = scale * solver.around(w)[1].reshape(len(w), -1).T
        return np.concatenate([fit, root, np.sqrt(follow / 2) * np.eye(len(w))])

    low, high = float(solver.lower[0]), float(solver.upper[0])
    start = np.clip(before, low + 1e-9, high - 1e-9)
    found = least_squares(residuals, start, slopes, bounds=(low, high), xtol=1e-4, ftol=1e-6, gtol=1e-6)
    return np.asarray(found.x)


def rows(data: Path, *, free: bool) -> list[Row]:
    """Return one row per solver."""
    played = scene(data, free=free)
    solver = played.method.solver
    assert isinstance(solver, BoneSolver)
    moved, _ = played.method.displacements(played.take.points)
    follow = 2 * solver.settings.smooth * (60 / 30) ** 2
    solver.step(moved[0], None, 60.0)
    solvers: dict[str, Callable[[Floats, Floats], Floats]] = {
        "mien": lambda frame, before: solver.step(frame, before, 60.0),
        "scipy least_squares (trf)": lambda frame, before: scipy_frame(solver, frame, before, follow),
    }
    found = []
    for name, solve in solvers.items():
        before, weights, times = np.zeros(len(solver.shapes)), np.zeros((FRAMES, len(solver.shapes))), []
        for f, frame in enumerate(moved):
            begin = time.process_time()
            before = weights[f] = solve(frame, before)
            times.append(time.process_time() - begin)
        left = np.linalg.norm(solver.displaced(weights) - moved, axis=2)
        found.append(
            {
                "solver": name,
                "parameters": f"{weights.shape[1]} {'turns and moves of bones' if free else 'named poses'}",
                "points": POINTS,
                "frames": FRAMES,
                "processor ms a frame, median": 1000 * float(np.median(times)),
                "fit mm": 10 * float(left.mean()),
                "skin mm": played.skin_mm(weights),
            }
        )
    return found


def main() -> None:
    data = Path(os.environ["MIEN_DATA"])
    with threadpool_limits(limits=1):
        found = [*rows(data, free=False), *rows(data, free=True)]
    publish("speed_bones", "Bones solved frame by frame.", found, ["numpy", "scipy", "numba"])


if __name__ == "__main__":
    main()
