"""Looking into a head and looking past it are different things."""

from __future__ import annotations

import numpy as np
import pytest

from mien.look.camera import Camera
from mien.look.openings import Openings
from mien.look.raster import render
from tests.look.solids import ball

AHEAD = Camera(np.array([0.0, 0.0, 10.0]), np.zeros(3), 2 * np.arctan(0.1))
"""Sees a square of 2 m at the origin's distance."""

EMPTY = render(np.zeros((1, 3)), np.empty((0, 3), np.int64), AHEAD, size=(60, 60))


def ring(around: int = 24, across: int = 12, thick: float = 0.2, turns: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A tube around the middle of the picture: a handle; less than a whole turn leaves its ends open."""
    u = np.linspace(0, 2 * np.pi * turns, around, endpoint=turns < 1)
    v = np.linspace(0, 2 * np.pi, across, endpoint=False)
    reach = 0.6 + thick * np.cos(v)
    points = np.stack(
        [np.outer(np.sin(u), reach), np.outer(np.cos(u), reach), np.tile(thick * np.sin(v), (around, 1))], axis=-1
    )
    i, j = np.meshgrid(np.arange(around if turns == 1 else around - 1), np.arange(across), indexing="ij")
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = i * across + (j + 1) % across, (i + 1) % around * across + (j + 1) % across
    triangles = np.concatenate([np.stack([a, c, b], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)])
    return points.reshape(-1, 3), triangles


def test_a_handle_shows_the_background() -> None:
    picture = render(*ring(), AHEAD, size=(60, 60))
    assert (picture[30, 12] != EMPTY[30, 12]).any()
    assert np.array_equal(picture[30, 30], EMPTY[30, 30])


def test_so_does_a_handle_stuck_on_a_case_with_its_ends_open() -> None:
    points, triangles = ring(turns=0.7)
    case, faces = ball(24, 0.4)
    both = np.concatenate([points, case + np.array([-0.45, 0.2, 0])])
    picture = render(both, np.concatenate([triangles, faces + len(points)]), AHEAD, size=(60, 60))
    assert np.array_equal(picture[32, 31], EMPTY[32, 31])


def mask(fold: float) -> tuple[np.ndarray, np.ndarray]:
    """Half a ball with an eye cut out of it, whose rim is folded in by `fold`."""
    n = 33
    x, y = np.meshgrid(np.linspace(-0.8, 0.8, n), np.linspace(-0.8, 0.8, n), indexing="ij")
    near = np.hypot(x, y)
    vertices = np.stack([x, y, 0.5 - 0.4 * (x**2 + y**2) - fold * np.exp(-((near - 0.25) ** 2) / 0.002)], -1)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate([np.stack([a, a + n, a + 1], 1), np.stack([a + 1, a + n, a + n + 1], 1)])
    return vertices.reshape(-1, 3), triangles[(near.ravel()[triangles] > 0.25).all(axis=1)]


@pytest.mark.parametrize("fold", [0.0, 0.2])
@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_the_eye_of_a_mask_is_dark_from_wherever_one_looks(fold: float, turn: float) -> None:
    camera = Camera(10 * np.array([np.sin(turn), 0, np.cos(turn)]), np.zeros(3), AHEAD.angle)
    vertices, triangles = mask(fold)
    picture = render(vertices, triangles, camera, size=(60, 60))
    column, row, _ = camera.project(np.array([0, 0, 0.5 - 0.4 * 0.25**2 - fold]), 60, 60)
    assert picture[int(row), int(column)].max() < 70
    assert np.array_equal(picture[1, 1], EMPTY[1, 1])


def test_a_closed_surface_has_no_openings_and_a_seam_is_none() -> None:
    points, triangles = ring()
    assert len(Openings.of(triangles, np.arange(len(points))).edges) == 0
    sphere, faces = ball(20)
    _, first, inverse = np.unique(np.round(sphere, 9), axis=0, return_index=True, return_inverse=True)
    poles = Openings.of(faces, first[inverse.ravel()])
    assert poles.rim.max() == 1
    assert np.abs(sphere[poles.edges][..., 1]).min() > 0.79


def test_lids_close_every_rim_around_its_middle() -> None:
    sphere, faces = ball(20)
    _, first, inverse = np.unique(np.round(sphere, 9), axis=0, return_index=True, return_inverse=True)
    openings = Openings.of(faces, first[inverse.ravel()])
    points, lids = openings.lids(sphere)
    assert len(points) == len(sphere) + 2
    assert np.allclose(points[-2:], [[0, s, 0] for s in np.sign(points[-2:, 1]) * 0.8 * np.cos(0.01)], atol=1e-9)
    whole = Openings.of(np.concatenate([first[inverse.ravel()][faces], lids]), np.arange(len(points)))
    assert len(whole.edges) == 0
