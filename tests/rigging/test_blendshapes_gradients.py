"""Deformation transfer against the paper's own system, written out densely with its fourth vertices."""

from __future__ import annotations

import numpy as np

from mien.core import SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.rigging.blendshapes.deformation_transfer import Anchors, counterparts, solve
from mien.rigging.blendshapes.gradients import frames, gradient, hat_gradients
from tests.rigging.faces import sheet


def literal(
    source: Floats, source_triangles: Ints, delta: Floats, target: Floats, triangles: Ints, origin: Ints, held: Floats
) -> Floats:
    """Sumner & Popović 2004, eq. 8: `min Σ ‖S - T‖²_F` over vertices and fourth vertices, by least squares.

    `held` is `(N, 3)` with NaN where a vertex is free.
    """
    n, t = len(target), len(triangles)
    rest, posed = frames(source, source_triangles), frames(source + delta, source_triangles)
    wanted = (posed @ np.linalg.inv(rest))[origin]
    inverse = np.linalg.inv(frames(target, triangles))
    rows, right = np.zeros((3 * t, n + t)), np.zeros((3 * t, 3))
    for j, corners in enumerate(triangles):
        for a in range(3):
            # T = [v2 - v1, v3 - v1, v4 - v1] V⁻¹, one column of it per row here
            for k, column in enumerate((corners[1], corners[2], n + j)):
                rows[3 * j + a, column] += inverse[j, k, a]
                rows[3 * j + a, corners[0]] -= inverse[j, k, a]
            right[3 * j + a] = wanted[j, :, a]
    fixed = ~np.isnan(held[:, 0])
    free = np.concatenate([np.flatnonzero(~fixed), n + np.arange(t)])
    known = rows[:, np.flatnonzero(fixed)] @ held[fixed]
    result = np.array(held)
    result[~fixed] = np.linalg.lstsq(rows[:, free], right - known, rcond=None)[0][: (~fixed).sum()]
    return result


def test_deformation_transfer_is_the_papers_least_squares(rng: np.random.Generator) -> None:
    source, source_triangles = sheet(np.linspace(-0.08, 0.08, 7), np.linspace(-0.1, 0.1, 8))
    target, triangles = sheet(np.linspace(-0.09, 0.08, 6), np.linspace(-0.09, 0.12, 9), bulge=3.0)
    target = target + rng.normal(0, 0.002, target.shape)
    delta = np.exp(-((source - source[20]) ** 2).sum(1, keepdims=True) / 0.05**2) * [0.01, -0.02, 0.015]
    delta += rng.normal(0, 0.001, delta.shape)
    nearest = ((source[None] - target[:, None]) ** 2).sum(2).argmin(1)
    back = SurfacePoints.at_vertices(nearest)
    guess = delta[nearest]
    still = target[:, 1] > 0.08
    guess[still] *= 1e-6
    result = solve(source, source_triangles, delta[None], target, triangles, back, guess=guess[None], turn=np.eye(3))
    origin = counterparts(source, source_triangles, back, triangles)
    held = np.where(Anchors.of(guess[None], triangles).held[:, None], target + guess, np.nan)
    expected = literal(source, source_triangles, delta, target, triangles, origin, held)
    assert 0 < np.isnan(held[:, 0]).sum() < len(target)
    assert np.abs(target + result[0] - expected).max() < 1e-9 * np.abs(target).max()


def test_every_triangle_of_the_same_mesh_is_its_own_counterpart() -> None:
    vertices, triangles = sheet(np.linspace(-0.08, 0.08, 7), np.linspace(-0.1, 0.1, 8))
    back = SurfacePoints.at_vertices(np.arange(len(vertices)))
    assert (counterparts(vertices, triangles, back, triangles) == np.arange(len(triangles))).all()


def test_the_gradient_of_an_affine_map_is_its_matrix_in_the_plane(rng: np.random.Generator) -> None:
    vertices, triangles = sheet(np.linspace(-0.08, 0.08, 5), np.linspace(-0.1, 0.1, 6))
    matrix = rng.normal(size=(3, 3))
    slope = gradient(hat_gradients(vertices, triangles), triangles, len(vertices)) @ (vertices @ matrix.T)
    edges = frames(vertices, triangles)[:, :, :2]
    assert np.allclose(np.swapaxes(slope.reshape(-1, 3, 3), 1, 2) @ edges, matrix @ edges)
