"""A small face with a known answer: an actor that is the character, bigger, turned and elsewhere."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mien.capture import Neutral
from mien.core import Blendshapes, Clip, Correspondence, Markers, Mesh, Rig, SurfacePoints

SHAPES = ("jawOpen", "smile_L", "smile_R", "blink_L", "blink_R", "browUp")
CENTRES = np.array([[0, -0.06], [0.03, -0.04], [-0.03, -0.04], [0.03, 0.03], [-0.03, 0.03], [0, 0.06]])
PUSHES = np.array([[0, -20, 0], [8, 7, -2], [-8, 7, -2], [0, -9, 0], [0, -9, 0], [0, 8, 1.0]]) / 1000


def face(n: int = 24) -> Rig:
    """A bent sheet the size of a face with six local shapes."""
    u, v = np.meshgrid(np.linspace(-0.07, 0.07, n), np.linspace(-0.1, 0.1, n), indexing="ij")
    vertices = np.stack([u.ravel(), v.ravel(), 0.05 - 6 * u.ravel() ** 2 - 3 * v.ravel() ** 2], axis=1)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate([np.stack([a, a + n, a + 1], 1), np.stack([a + 1, a + n, a + n + 1], 1)])
    reach = np.exp(-((vertices[None, :, :2] - CENTRES[:, None]) ** 2).sum(2) / 0.02**2)
    return Rig(Mesh(vertices, triangles), Blendshapes(SHAPES, reach[..., None] * PUSHES[:, None]), name="face")


def weights(frames: int = 240) -> np.ndarray:
    """A range-of-motion take: each shape alone to its full strength, then mixtures."""
    t = np.arange(frames) / frames
    curves = [np.exp(-(((t - (k + 0.7) / 9) / 0.03) ** 2)) for k in range(6)]
    mixed = [0.5 * np.exp(-(((t - 0.85) / 0.05) ** 2)) * (1 + np.sin(40 * t + k)) / 2 for k in range(6)]
    values = np.array(curves).T + np.array(mixed).T
    values[values < 1e-3] = 0
    return values


def points_on(rig: Rig, count: int = 49) -> SurfacePoints:
    n = int(round(np.sqrt(len(rig.neutral.vertices))))
    steps = np.linspace(0, n - 1, int(np.sqrt(count))).round().astype(int)
    return SurfacePoints.at_vertices((steps[:, None] * n + steps).ravel())


def capture(
    rig: Rig, values: np.ndarray, points: SurfacePoints, *, scale: float = 1.0, head: bool = False, noise: float = 0.0
) -> Markers:
    """The rig acting, as markers in another place, size and turn, with or without head motion."""
    rng = np.random.default_rng(3)
    traced = points.of(rig.pose(values))
    if head:
        turns = Rotation.from_euler("xy", 0.15 * np.sin(np.linspace(0, 6, 2 * len(values))).reshape(-1, 2)).as_matrix()
        traced = traced @ np.swapaxes(turns, 1, 2) + 0.02 * np.sin(np.linspace(0, 5, len(values)))[:, None, None]
    placed = _elsewhere(traced, scale)
    placed += rng.normal(0, noise, placed.shape) * scale
    return Markers(tuple(f"m{i}" for i in range(len(points))), placed, 60.0)


def at_rest(rig: Rig, points: SurfacePoints, scale: float = 1.0) -> Neutral:
    """The neutral of such a capture, exactly."""
    return Neutral(_elsewhere(points.of(rig.neutral.vertices), scale), None, float("nan"))


def _elsewhere(points: np.ndarray, scale: float) -> np.ndarray:
    turn = Rotation.from_euler("xyz", [90, 0, 30], degrees=True).as_matrix()
    return scale * (points @ turn.T + [0.3, 1.2, -0.4])


def pairs_of(points: SurfacePoints) -> Correspondence:
    return Correspondence(tuple(f"m{i}" for i in range(len(points))), points)


def clip_of(values: np.ndarray) -> Clip:
    return Clip(SHAPES, values, 60.0)
