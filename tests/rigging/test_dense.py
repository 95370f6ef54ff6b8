"""Laying one face on another: landmarks met, skin on the surface, every side of a slit kept."""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pytest

from mien.core import Mesh, Rig, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.geometry.surface import closest_points, distances_along
from mien.io.documents import join, landmarks_on_mesh, read_landmarks
from mien.io.formats import read_rig
from mien.library import actor, character
from mien.rigging.dense import DenseFit, lay
from mien.rigging.warp_and_stick.sheet import Sheet, twins_of
from mien.rigging.warp_and_stick.triangle import nearest

TEN = [f"ibug_{n}" for n in (30, 36, 39, 42, 45, 48, 54)] + ["chin_tip", "gonion_left", "gonion_right"]
TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


@pytest.fixture(scope="module")
def source() -> Rig:
    return actor()


@pytest.fixture(scope="module")
def target() -> Rig:
    return character()


@pytest.fixture(scope="module")
def fit(source: Rig, target: Rig) -> DenseFit:
    names = sorted(set(source.landmarks) & set(target.landmarks))
    return lay(source.neutral, points(source, names), target.neutral, points(target, names))


def points(rig: Rig, names: list[str]) -> SurfacePoints:
    return join([rig.landmarks[name] for name in names])


def on_itself(mesh: Mesh, landmarks: SurfacePoints, other: Mesh) -> DenseFit:
    return lay(mesh, landmarks, other, landmarks)


def changed(mesh: Mesh, vertices: Floats) -> Mesh:
    return Mesh(vertices, mesh.triangles)


def test_landmarks_are_met(source: Rig, target: Rig, fit: DenseFit) -> None:
    names = sorted(set(source.landmarks) & set(target.landmarks))
    wanted = points(target, names).of(target.neutral.vertices)
    size = np.ptp(target.neutral.vertices, axis=0).max()
    assert np.abs(fit.warp(points(source, names).of(source.neutral.vertices)) - wanted).max() < 1e-9 * size
    assert np.abs(points(source, names).of(fit.stuck) - wanted).max() < 1e-9 * size


def test_every_stuck_vertex_is_on_the_surface(target: Rig, fit: DenseFit) -> None:
    away = closest_points(target.neutral.vertices, target.neutral.triangles, fit.stuck[fit.source_skin])[1]
    assert away.max() < 1e-9 * np.ptp(target.neutral.vertices, axis=0).max()
    assert (fit.points.weights >= 0).all()


def test_eyes_and_teeth_are_left_where_the_warp_brings_them(fit: DenseFit) -> None:
    assert not fit.source_skin.all()
    assert not fit.target_skin.all()
    np.testing.assert_array_equal(fit.stuck[~fit.source_skin], fit.warped[~fit.source_skin])


def test_repair_leaves_fewer_folds(source: Rig, target: Rig, fit: DenseFit) -> None:
    names = sorted(set(source.landmarks) & set(target.landmarks))
    bare = lay(source.neutral, points(source, names), target.neutral, points(target, names), repair=False)
    assert bare.folds_before == bare.folds_after == fit.folds_before > fit.folds_after


def test_a_face_lies_on_its_moved_copy_vertex_by_vertex(source: Rig) -> None:
    mesh, landmarks = source.neutral, join(list(source.landmarks.values()))
    moved = 1000 * mesh.vertices @ TURN.T + np.array([3.0, -2.0, 5.0])
    fit = on_itself(mesh, landmarks, changed(mesh, moved))
    size = np.ptp(moved, axis=0).max()
    assert np.abs(fit.stuck - moved).max() < 1e-6 * size
    assert fit.back_distance[fit.target_skin].max() < 1e-6 * size
    back = fit.back.of(mesh.vertices)
    assert np.abs(back - mesh.vertices)[fit.target_skin].max() < 1e-6 * np.ptp(mesh.vertices, axis=0).max()
    assert fit.folds_before == 0
    assert fit.notes == ()


def test_a_target_turned_inside_out_is_noted_and_changes_nothing(source: Rig, target: Rig, fit: DenseFit) -> None:
    names = sorted(set(source.landmarks) & set(target.landmarks))
    turned = Mesh(target.neutral.vertices, target.neutral.triangles[:, ::-1])
    other = lay(source.neutral, points(source, names), turned, points(target, names))
    assert "inside-out" in [note.code for note in other.notes]
    np.testing.assert_allclose(other.stuck, fit.stuck, atol=1e-9)


def slit_sheet(height: float, n: int = 41) -> tuple[Mesh, Ints]:
    """A bulging sheet 10 cm wide, cut from x = -2.5 to 2.5 cm at `height`; and each vertex's side, 0 far away."""
    side = np.linspace(-0.05, 0.05, n)
    rows = np.concatenate([np.linspace(-0.05, height, 20), [height], np.linspace(height, 0.05, 20)[1:]])
    x, y = np.meshgrid(side, rows)
    y[20] += 2e-4 * np.clip(1 - (side / 0.025) ** 2, 0, None)  # vertices in one place would be one point of the skin
    vertices = np.stack([x, y, 0.03 - 6 * x**2 - 6 * y**2], axis=-1).reshape(-1, 3)
    below, above = 19 * n + np.arange(n), 20 * n + np.arange(n)
    number = np.arange(len(vertices))
    closed = np.abs(side) > 0.0251
    number[above[closed]] = below[closed]
    i, j = np.meshgrid(np.delete(np.arange(len(rows) - 1), 19), np.arange(n - 1), indexing="ij")
    a = (i * n + j).ravel()
    triangles = np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)])
    near = (np.abs(x.ravel()) < 0.02) & (np.abs(y.ravel() - height) < 0.012)
    sides = np.where(near, np.where(np.arange(len(vertices)) >= 20 * n, 1, -1), 0)
    return Mesh(vertices, number[triangles]), sides


def corners_of(mesh: Mesh, height: float) -> SurfacePoints:
    """Landmarks around the sheet and at the two ends of the slit."""
    spots = [(-0.045, -0.045), (0.045, -0.045), (0.045, 0.045), (-0.045, 0.045), (0.0, 0.03), (0.0, -0.03)]
    spots += [(-0.0275, height), (0.0275, height)]
    flat = mesh.vertices[:, :2]
    return SurfacePoints.at_vertices(np.array([((flat - spot) ** 2).sum(1).argmin() for spot in spots]))


def wrong_sides(places: SurfacePoints, mine: Ints, theirs: Ints) -> int:
    landed = np.einsum("mi,mi->m", theirs[places.corners].astype(float), places.weights)
    return int(((mine != 0) & (landed * mine < 0)).sum())


def test_each_side_of_a_slit_is_kept_with_only_its_ends_marked() -> None:
    (high, high_sides), (low, low_sides) = slit_sheet(0.003), slit_sheet(-0.004)
    fit = lay(high, corners_of(high, 0.003), low, corners_of(low, -0.004))
    nearest = closest_points(low.vertices, low.triangles, fit.warped)[0]
    assert wrong_sides(nearest, high_sides, low_sides) > 10
    assert wrong_sides(fit.points, high_sides, low_sides) == 0
    assert wrong_sides(fit.back, low_sides, high_sides) == 0


def test_damaged_meshes_work(source: Rig, target: Rig, fit: DenseFit) -> None:
    names = sorted(set(source.landmarks) & set(target.landmarks))
    mesh = target.neutral
    marked = np.unique(points(target, names).corners)
    spare = np.flatnonzero(~np.isin(mesh.triangles, marked).any(axis=1))[::97]
    a, b, _ = mesh.triangles[0]
    odd = np.array([[a, a, b], [a, b, b], [a, b, len(mesh.vertices)]])  # no area, no area, a third triangle on an edge
    stray = np.vstack([mesh.vertices[a] + 0.001, [9.0, 9.0, 9.0]])  # the second is of no triangle
    triangles = np.vstack([np.delete(mesh.triangles, spare, axis=0), odd])
    damaged = Mesh(np.vstack([mesh.vertices, stray]), triangles)
    other = lay(source.neutral, points(source, names), damaged, points(target, names))
    assert not other.target_skin[-1]
    moved = np.linalg.norm(other.stuck - fit.stuck, axis=1)[fit.source_skin]
    assert np.median(moved) < 1e-6
    assert np.isfinite(other.stuck).all()


def test_vertices_doubled_along_a_texture_seam_are_one_skin(source: Rig) -> None:
    mesh, landmarks = source.neutral, join(list(source.landmarks.values()))
    left = mesh.vertices[mesh.triangles].mean(axis=1)[:, 0] > 0
    seam = np.intersect1d(mesh.triangles[left], mesh.triangles[~left])
    number = np.arange(len(mesh.vertices))
    number[seam] = len(mesh.vertices) + np.arange(len(seam))
    split = Mesh(
        np.vstack([mesh.vertices, mesh.vertices[seam]]), np.where(left[:, None], number[mesh.triangles], mesh.triangles)
    )
    assert len(twins_of(split.vertices, split.triangles)) >= 0.9 * len(seam)
    fit = on_itself(mesh, landmarks, split)
    whole = on_itself(mesh, landmarks, mesh)
    np.testing.assert_array_equal(fit.target_skin[: len(mesh.vertices)], whole.target_skin)
    np.testing.assert_allclose(fit.stuck, whole.stuck, atol=1e-9)


def test_a_tear_film_that_touches_the_lid_is_not_skin(source: Rig) -> None:
    """A strip that shares places with the skin where the skin has no border."""
    mesh, landmarks = source.neutral, join(list(source.landmarks.values()))
    whole = on_itself(mesh, landmarks, mesh)
    edges = np.concatenate([mesh.triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    a, b = edges[whole.source_skin[edges].all(axis=1)][:200:5].T
    strip = np.concatenate([mesh.vertices[a], mesh.vertices[b], (mesh.vertices[a] + mesh.vertices[b]) / 2 + 1e-3])
    n = len(mesh.vertices) + np.arange(len(strip)).reshape(3, -1)
    touching = Mesh(np.vstack([mesh.vertices, strip]), np.vstack([mesh.triangles, n.T]))
    assert len(twins_of(touching.vertices, touching.triangles)) == 0
    fit = on_itself(mesh, landmarks, touching)
    assert not fit.target_skin[len(mesh.vertices) :].any()


def test_a_slit_is_laid_last_and_from_outside() -> None:
    mesh, sides = slit_sheet(0.0)
    order = Sheet.of(mesh.vertices, mesh.triangles, np.empty((0, 2), np.int64)).order(
        0.04, corners_of(mesh, 0.0).corners[:, 0]
    )
    at_slit = (sides != 0) & (np.abs(mesh.vertices[:, 1]) < 3e-4)
    assert order[at_slit].max() < 0 < np.median(order)


def test_the_closest_point_of_one_triangle_is_the_library_s(rng: np.random.Generator) -> None:
    for corners in rng.normal(size=(200, 3, 3)):
        query = rng.normal(size=3) * 2
        *weights, squared = nearest(query, corners, 0, 1, 2)
        expected = igl.point_mesh_squared_distance(query[None], corners, np.array([[0, 1, 2]]))[0]
        assert min(weights) >= 0
        assert sum(weights) == pytest.approx(1)
        assert squared == pytest.approx(np.ravel(expected)[0], abs=1e-12)
        assert ((np.array(weights) @ corners - query) ** 2).sum() == pytest.approx(squared, abs=1e-12)


def test_a_triangle_without_area_has_a_closest_point() -> None:
    for corners in (np.zeros((3, 3)), np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.eye(3)[[0, 0, 1]]):
        *weights, squared = nearest(np.array([0.3, 1.0, 2.0]), corners, 0, 1, 2)
        assert np.isfinite(squared)
        assert sum(weights) == pytest.approx(1)


@pytest.mark.real
def test_a_stranger_with_the_same_vertices_is_found_vertex_by_vertex(data: Path) -> None:
    rig = read_rig(data / "rigs" / "ict_face.glb")
    path = data / "rigs" / "ict_face.landmarks.json"
    landmarks = landmarks_on_mesh(read_landmarks(path), rig.neutral, path)
    mesh = rig.neutral
    change = np.load(data / "rigs" / "ict_identities.npz")["deltas"][3, : len(mesh.vertices)].astype(float)
    other = changed(mesh, mesh.vertices + 2 * change)
    upper, lower = ([landmarks[f"ibug_{n}"] for n in numbers] for numbers in (range(61, 64), range(65, 68)))
    to_upper, to_lower = (distances_along(mesh, join(lip).corners[:, 0]).min(axis=0) for lip in (upper, lower))
    lips = np.minimum(to_upper, to_lower) < 0.012
    sides = np.where(lips & (np.abs(to_upper - to_lower) > 0.004), np.sign(to_lower - to_upper), 0).astype(np.int64)
    for names in (TEN, sorted(landmarks)):
        marks = join([landmarks[name] for name in names])
        fit = lay(mesh, marks, other, marks)
        away = np.linalg.norm(fit.stuck - other.vertices, axis=1)
        assert np.median(away) < 0.001
        assert np.percentile(away, 95) < 0.005
        assert wrong_sides(fit.points, sides, sides) == 0
        assert wrong_sides(fit.back, sides, sides) == 0
