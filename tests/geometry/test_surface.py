from __future__ import annotations

import numpy as np

from mien.core import Mesh
from mien.geometry.laplacian import cotangent_laplacian, triangulate_markers
from mien.geometry.surface import closest_points, distances_along, vertex_normals
from tests.conftest import grid_rig


def test_closest_points_beat_a_dense_sampling_of_the_surface(rng: np.random.Generator) -> None:
    mesh = grid_rig(8).neutral
    queries = rng.uniform(-0.1, 0.15, (50, 3))
    points, distance, _ = closest_points(mesh.vertices, mesh.triangles, queries)
    found = points.of(mesh.vertices)
    assert np.allclose(np.linalg.norm(found - queries, axis=1), distance)
    weights = rng.dirichlet(np.ones(3), 400)
    samples = np.einsum("sc,tcx->tsx", weights, mesh.vertices[mesh.triangles]).reshape(-1, 3)
    nearest = np.linalg.norm(queries[:, None] - samples, axis=2).min(axis=1)
    assert (distance <= nearest + 1e-12).all()


def test_degenerate_triangles_do_not_disturb(rng: np.random.Generator) -> None:
    mesh = grid_rig(4).neutral
    extra = np.vstack([mesh.triangles, [[0, 0, 1], [2, 2, 2]]])
    queries = rng.uniform(-0.1, 0.1, (20, 3))
    with_extra = closest_points(mesh.vertices, extra, queries)[0].of(mesh.vertices)
    assert np.allclose(with_extra, closest_points(mesh.vertices, mesh.triangles, queries)[0].of(mesh.vertices))


def test_the_laplacian_of_a_linear_function_vanishes_inside() -> None:
    u, v = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 2, 7), indexing="ij")
    flat = np.stack([u.ravel(), v.ravel(), 0 * u.ravel()], axis=1)
    laplacian = cotangent_laplacian(flat, grid_rig(7).neutral.triangles)
    inside = ((u > 0) & (u < 1) & (v > 0) & (v < 2)).ravel()
    assert np.abs((laplacian @ (3 * flat[:, 0] - flat[:, 1]))[inside]).max() < 1e-12
    assert np.allclose((laplacian - laplacian.T).toarray(), 0)
    assert np.linalg.eigvalsh(laplacian.toarray()).max() < 1e-12


def test_the_laplacian_does_not_change_with_size() -> None:
    mesh = grid_rig(6).neutral
    small, large = (cotangent_laplacian(mesh.vertices * s, mesh.triangles).toarray() for s in (1, 100))
    assert np.allclose(small, large)


def test_an_unused_vertex_has_an_empty_row() -> None:
    mesh = grid_rig(4).neutral
    vertices = np.vstack([mesh.vertices, [[9, 9, 9]]])
    assert cotangent_laplacian(vertices, mesh.triangles)[-1].nnz == 0
    assert not vertex_normals(vertices, mesh.triangles)[-1].any()


def test_a_texture_seam_does_not_lengthen_the_way() -> None:
    mesh = grid_rig(5).neutral
    n = len(mesh.vertices)
    doubled = Mesh(np.vstack([mesh.vertices, mesh.vertices]), np.vstack([mesh.triangles[:16], mesh.triangles[16:] + n]))
    whole = distances_along(mesh, np.array([0]))[0]
    split = distances_along(doubled, np.array([0]))[0]
    assert np.allclose(np.minimum(split[:n], split[n:]), whole, atol=1e-6)


def test_markers_are_triangulated_without_holes_or_slivers(rng: np.random.Generator) -> None:
    angle, height = rng.uniform(-1.2, 1.2, 60), rng.uniform(-1, 1, 60)
    points = np.stack([np.sin(angle), height, np.cos(angle)], axis=1)
    triangles = triangulate_markers(points)
    a, b, c = (points[triangles[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert len(np.unique(triangles)) >= 56
    assert area.min() > 0
