"""Small faces with exact correspondence, to carry shapes between."""

from __future__ import annotations

import numpy as np

from mien.core import Blendshapes, Mesh, Rig, SurfacePoints
from mien.core.arrays import Flags, Floats
from mien.geometry.tps import fit_thin_plate
from mien.rigging.dense import DenseFit


def exact_fit(source: Mesh, target: Mesh, skin: Flags | None = None) -> DenseFit:
    """The correspondence of two meshes with the same vertices, by a warp of a dozen of them."""
    flags = np.ones(len(source.vertices), np.bool_) if skin is None else skin
    own = np.flatnonzero(flags)
    marks = own[np.linspace(0, len(own) - 1, 12).astype(int)]
    warp = fit_thin_plate(source.vertices[marks], target.vertices[marks])
    same = SurfacePoints.at_vertices(np.arange(len(source.vertices)))
    warped = warp(source.vertices)
    stuck = np.where(flags[:, None], target.vertices, warped)
    return DenseFit(source, target, flags, flags, warp, warped, same, stuck, flags, same, np.zeros(len(stuck)), 0, 0)


def sheet(across: Floats, along: Floats, bulge: float = 2.0) -> tuple[Floats, np.ndarray]:
    """A bent grid: vertices `(A·B, 3)` and triangles."""
    u, v = np.meshgrid(across, along, indexing="ij")
    vertices = np.stack([u.ravel(), v.ravel(), 0.1 - bulge * (u.ravel() ** 2 + 1.3 * v.ravel() ** 2)], axis=1)
    n = len(along)
    a = (np.arange(len(across) - 1)[:, None] * n + np.arange(n - 1)).ravel()
    return vertices, np.concatenate([np.stack([a, a + n, a + 1], 1), np.stack([a + 1, a + n, a + n + 1], 1)])


def face_with_slit(gap: float, n: int = 25) -> tuple[Mesh, np.ndarray, np.ndarray]:
    """A sheet of 16 cm with a mouth across it that stands open by `gap`; and its upper and lower margin."""
    across = np.linspace(-0.08, 0.08, n)
    upper, triangles = sheet(across, np.linspace(0, 0.08, n))
    lower, _ = sheet(across, np.linspace(-0.08, 0, n))
    rows = np.arange(n)
    top, bottom = rows * n, len(upper) + rows * n + n - 1
    vertices = np.vstack([upper, lower])
    faces = np.vstack([triangles, triangles + len(upper)])
    inner = np.abs(across) < 0.05
    shared = np.arange(len(vertices))
    shared[bottom[~inner]] = top[~inner]  # beyond the corners of the mouth the skin is one
    open_by = gap / 2 * np.clip(1 - (vertices[:, 0] / 0.05) ** 2, 0, None) * np.exp(-np.abs(vertices[:, 1]) / 0.01)
    vertices[:, 1] += np.where(np.arange(len(vertices)) < len(upper), open_by, -open_by)
    used = np.unique(shared)
    number = np.zeros(len(vertices), np.int64)
    number[used] = np.arange(len(used))
    return Mesh(vertices[used], number[shared[faces]]), number[top[inner]], number[bottom[inner]]


def closing(mesh: Mesh, upper: np.ndarray, lower: np.ndarray) -> Floats:
    """The delta that brings the upper margin down to the lower, fading upwards."""
    delta = np.zeros_like(mesh.vertices)
    for top, bottom in zip(upper, lower, strict=True):
        column = np.flatnonzero((mesh.vertices[:, 0] == mesh.vertices[top, 0]) & (mesh.vertices[:, 1] > 0))
        fade = np.exp(-(mesh.vertices[column, 1] - mesh.vertices[top, 1]) / 0.015)
        delta[column] = fade[:, None] * (mesh.vertices[bottom] - mesh.vertices[top])
    return delta


def rig_of(mesh: Mesh, **deltas: Floats) -> Rig:
    """A rig with these shapes."""
    return Rig(mesh, Blendshapes(tuple(deltas), np.stack(list(deltas.values()))), name="sheet")


def ball(centre: Floats, radius: float) -> tuple[Floats, np.ndarray]:
    """An eyeball: vertices and triangles of a sphere with poles."""
    tilt, turn = np.meshgrid(np.linspace(0.1, np.pi - 0.1, 9), np.linspace(0, 2 * np.pi, 13)[:-1], indexing="ij")
    points = np.stack([np.sin(tilt) * np.cos(turn), np.cos(tilt), np.sin(tilt) * np.sin(turn)], axis=2).reshape(-1, 3)
    a = (np.arange(8)[:, None] * 12 + np.arange(12)).ravel()
    b = (np.arange(8)[:, None] * 12 + (np.arange(12) + 1) % 12).ravel()
    return centre + radius * points, np.concatenate([np.stack([a, b, a + 12], 1), np.stack([b, b + 12, a + 12], 1)])
