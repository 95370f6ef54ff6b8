"""Folds are counted, turned back, and what must not move does not."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import Mesh, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.geometry.surface import closest_points
from mien.rigging.warp_and_stick.folds import LEASH, folded, smooth_out
from mien.rigging.warp_and_stick.sheet import Sheet

NOBODY, NONE = np.empty((0, 2), np.int64), np.empty(0, np.int64)
RADIUS = 3.0


def grid(n: int, height: float = 0.2) -> Mesh:
    """A bulging square, 2 wide."""
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    vertices = np.stack([x, y, height * (1 - x**2) * (1 - y**2)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n - 1), np.arange(n - 1), indexing="ij")
    a = (i * n + j).ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)]))


def sheet(mesh: Mesh, twins: Ints = NOBODY) -> Sheet:
    return Sheet.of(mesh.vertices, mesh.triangles, twins)


def crumpled(film: Mesh, ground: Mesh, rng: np.random.Generator) -> SurfacePoints:
    """The film on the ground, its inner vertices pushed about by up to an edge and a half."""
    inner = (np.abs(film.vertices[:, :2]) < 0.6).all(axis=1)
    edge = np.linalg.norm(film.vertices[1] - film.vertices[0])
    push = rng.uniform(-1.5 * edge, 1.5 * edge, (len(film.vertices), 3)) * inner[:, None]
    return closest_points(ground.vertices, ground.triangles, film.vertices + push)[0]


def folds(film: Mesh, ground: Mesh, points: SurfacePoints) -> int:
    return int(folded(film.vertices, points.of(ground.vertices), film.triangles).sum())


@pytest.mark.parametrize("fineness", [9, 21, 61])
def test_a_crumpled_film_is_smoothed_on_coarse_and_fine_ground(fineness: int, rng: np.random.Generator) -> None:
    film, ground = grid(21), grid(fineness)
    points = crumpled(film, ground, rng)
    repaired = smooth_out(sheet(film), NOBODY, sheet(ground), points, NONE, RADIUS)
    assert folds(film, ground, points) > 50
    assert folds(film, ground, repaired) == 0


def test_what_is_repaired_stays_on_the_ground(rng: np.random.Generator) -> None:
    film, ground = grid(21), grid(13)
    repaired = smooth_out(sheet(film), NOBODY, sheet(ground), crumpled(film, ground, rng), NONE, RADIUS)
    away = closest_points(ground.vertices, ground.triangles, repaired.of(ground.vertices))[1]
    assert away.max() < 1e-12
    assert repaired.weights.min() >= 0


def test_landmarks_and_what_lies_well_are_not_moved(rng: np.random.Generator) -> None:
    film, ground = grid(21), grid(21)
    points = crumpled(film, ground, rng)
    held = np.arange(0, len(film.vertices), 17)
    repaired = smooth_out(sheet(film), NOBODY, sheet(ground), points, held, RADIUS)
    border = (np.abs(film.vertices[:, :2]) > 0.99).any(axis=1)
    for rows in (held, np.flatnonzero(border)):
        np.testing.assert_array_equal(repaired.of(ground.vertices)[rows], points.of(ground.vertices)[rows])
    assert folds(film, ground, repaired) < folds(film, ground, points)


def test_vertices_of_one_point_move_together(rng: np.random.Generator) -> None:
    film, ground = grid(21), grid(21)
    left = film.vertices[film.triangles].mean(axis=1)[:, 0] < 0
    seam = np.intersect1d(film.triangles[left], film.triangles[~left])
    number = np.arange(len(film.vertices))
    number[seam] = len(film.vertices) + np.arange(len(seam))
    split = Mesh(
        np.vstack([film.vertices, film.vertices[seam]]), np.where(left[:, None], number[film.triangles], film.triangles)
    )
    whole = crumpled(film, ground, rng)
    both = np.concatenate([np.arange(len(film.vertices)), seam])
    points = SurfacePoints(whole.corners[both], whole.weights[both])
    twins = np.stack([seam, number[seam]], axis=1)
    repaired = smooth_out(sheet(split, twins), twins, sheet(ground), points, NONE, RADIUS)
    places: Floats = repaired.of(ground.vertices)
    np.testing.assert_array_equal(places[seam], places[number[seam]])
    assert folds(split, ground, repaired) == 0


def test_no_point_slides_farther_than_its_leash(rng: np.random.Generator) -> None:
    film, ground = grid(21), grid(21)
    points, radius = crumpled(film, ground, rng), 0.8
    slid = [
        np.linalg.norm((repaired.of(ground.vertices) - points.of(ground.vertices)), axis=1).max()
        for repaired in (smooth_out(sheet(film), NOBODY, sheet(ground), points, NONE, r) for r in (radius, RADIUS))
    ]
    assert slid[0] <= LEASH * radius < slid[1]


def test_without_folds_nothing_changes() -> None:
    film = grid(11)
    points = SurfacePoints.at_vertices(np.arange(len(film.vertices)))
    repaired = smooth_out(sheet(film), NOBODY, sheet(film), points, NONE, RADIUS)
    np.testing.assert_array_equal(repaired.of(film.vertices), film.vertices)
