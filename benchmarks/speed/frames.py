"""The performances that the per-frame benchmark solves: one made by code, one of a real rig and a real take."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mien.core.arrays import Floats, Ints, matching
from mien.geometry.laplacian import cotangent_laplacian
from mien.io.formats import read_clip, read_rig
from mien.solve import LassoProblem

MARKERS = 99
NOISE_CM = 0.02
PRIOR = 0.3


@dataclass(frozen=True)
class Performance:
    """A rig seen at some points, and a clip of those points, in centimetres as the paper's constants want.

    Attributes:
        name: what it is.
        points: `(K, 3 M)` shapes at the markers.
        bending: `(K, K)` Gram matrix of the shapes' Laplacians over the whole mesh, per vertex.
        clip: `(F, 3 M)` displacements of the markers.
    """

    name: str
    points: Floats
    bending: Floats
    clip: Floats

    def problem(self, sparsity: float, lower: float = -np.inf, upper: float = np.inf) -> LassoProblem:
        """Return Ribera et al. 2017, eq. 16, with µ = 0.3 and ν = `sparsity`."""
        gram = 2 / MARKERS * self.points @ self.points.T + 2 * PRIOR * self.bending
        size = len(gram)
        return LassoProblem(gram, np.full(size, sparsity / size), np.full(size, lower), np.full(size, upper))

    @property
    def projection(self) -> Floats:
        """The `(K, 3 M)` matrix that turns a frame into its data vector."""
        return np.ascontiguousarray(2 / MARKERS * self.points)

    def q(self) -> Floats:
        """Return the data vector of every frame."""
        return np.asarray(self.clip @ self.projection.T)


def synthetic(shapes: int = 51, frames: int = 2000) -> Performance:
    """Local shapes on a bent sheet, overlapping as lips and cheeks do, played by sparse smooth weights."""
    rng = np.random.default_rng(2)
    side = 45
    u, v = np.meshgrid(np.linspace(-8, 8, side), np.linspace(-11, 11, side), indexing="ij")
    vertices = np.stack([u.ravel(), v.ravel(), 8 - 0.08 * u.ravel() ** 2 - 0.04 * v.ravel() ** 2], axis=1)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    triangles = np.concatenate(
        [
            np.stack([corner, corner + side, corner + 1], axis=1),
            np.stack([corner + 1, corner + side, corner + side + 1], axis=1),
        ]
    )
    centres = vertices[rng.integers(len(vertices), size=shapes)]
    reach = rng.uniform(1.5, 4, (shapes, 1))
    falloff = np.exp(-((vertices - centres[:, None]) ** 2).sum(axis=2) / reach**2)
    deltas = falloff[..., None] * rng.normal(0, 0.6, (shapes, 1, 3))
    return performance("made by code", vertices, triangles, deltas, bumps(frames, shapes, rng), rng)


def bumps(frames: int, shapes: int, rng: np.random.Generator) -> Floats:
    """Return weights that rise and fall for some tenths of a second, most of them 0 at any time."""
    time = np.arange(frames)[:, None] / 30
    weights = np.zeros((frames, shapes))
    for _ in range(max(frames // 150, 1)):
        peak, width = rng.uniform(0, frames / 30, shapes), rng.uniform(0.15, 0.6, shapes)
        weights += rng.uniform(0.2, 1, shapes) * np.exp(-(((time - peak) / width) ** 2))
    return np.where(weights > 0.02, np.minimum(weights, 1), 0.0)


def real(folder: Path) -> Performance:
    """Play a recorded take on the ICT face, both read from the real data folder."""
    rig = read_rig(folder / "rigs" / "ict_face.glb")
    take = read_clip(folder / "clips" / "livelink" / "S07-001.csv")
    channels = [name.replace("_L", "Left").replace("_R", "Right") for name in rig.blendshapes.names]
    unsplit = [name.removesuffix("Left").removesuffix("Right") for name in channels]
    played = [name if name in take.names else whole for name, whole in zip(channels, unsplit, strict=True)]
    kept = np.flatnonzero(matching(take.names, played) >= 0)
    weights = take.channels([played[k] for k in kept])
    deltas, vertices = 100 * rig.blendshapes.deltas[kept], 100 * rig.neutral.vertices
    rng = np.random.default_rng(2)
    return performance(
        f"{rig.name} plays S07-001", vertices, rig.neutral.triangles, deltas, np.nan_to_num(weights), rng
    )


def performance(
    name: str, vertices: Floats, triangles: Ints, deltas: Floats, weights: Floats, rng: np.random.Generator
) -> Performance:
    """See a rig at well-spread markers on the part that moves, with the noise of a capture."""
    moving = np.flatnonzero(np.abs(deltas).max(axis=(0, 2)) > 0.1)
    markers = moving[spread(vertices[moving], MARKERS)]
    points = deltas[:, markers].reshape(len(deltas), -1)
    laplacian = cotangent_laplacian(vertices, triangles)
    bent = np.stack([(laplacian @ delta).ravel() for delta in deltas])
    alive = np.abs(points).max(axis=1) > 0
    points, bent = points[alive], bent[alive]
    clip = weights[:, alive] @ points
    clip += rng.normal(0, NOISE_CM, clip.shape)
    return Performance(name, points, bent @ bent.T / len(vertices), clip)


def spread(points: Floats, count: int) -> Ints:
    """Return the indices of `count` points, each the farthest from those before."""
    chosen = [0]
    distance = np.full(len(points), np.inf)
    while len(chosen) < count:
        distance = np.minimum(distance, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(distance.argmax()))
    return np.array(chosen)


def performances() -> list[Performance]:
    """Return the performances at hand: the real one only where MIEN_DATA names the real data."""
    named = os.environ.get("MIEN_DATA", "")
    return [synthetic()] + ([real(Path(named))] if named else [])
