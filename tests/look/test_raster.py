"""The rasteriser against geometry that can be worked out by hand."""

from __future__ import annotations

import time

import numpy as np
import pytest

from mien.core import InputError
from mien.look.camera import Camera
from mien.look.raster import Dots, render, vertex_normals
from mien.look.shade import encoding, heat
from tests.look.solids import ball

AHEAD = Camera(np.array([0.0, 0.0, 10.0]), np.zeros(3), 2 * np.arctan(0.1))
"""Sees a square of 2 m at the origin's distance."""


def square(half: float, z: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return corners, np.array([[0, 1, 2], [0, 2, 3]])


def covered(picture: np.ndarray, empty: np.ndarray) -> np.ndarray:
    return (picture != empty).any(axis=2)


def nothing(size: tuple[int, int]) -> np.ndarray:
    return render(np.zeros((1, 3)), np.empty((0, 3), np.int64), AHEAD, size=size)


def test_a_square_covers_exactly_the_pixels_it_should() -> None:
    vertices, triangles = square(0.5)
    seen = covered(render(vertices, triangles, AHEAD, size=(40, 40), edges="hard"), nothing((40, 40)))
    expected = np.zeros((40, 40), bool)
    expected[10:30, 10:30] = True
    assert np.array_equal(seen, expected)


def test_triangles_that_share_an_edge_leave_no_gap(rng: np.random.Generator) -> None:
    n = 12
    x, y = np.meshgrid(np.linspace(-0.9, 0.9, n), np.linspace(-0.9, 0.9, n), indexing="ij")
    inner = (abs(x) < 0.85) & (abs(y) < 0.85)
    x, y = x + inner * rng.uniform(-0.03, 0.03, x.shape), y + inner * rng.uniform(-0.03, 0.03, x.shape)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate([np.stack([a, a + n, a + 1], 1), np.stack([a + 1, a + n, a + n + 1], 1)])
    red = np.tile([1.0, 0.0, 0.0], (len(vertices), 1))
    picture = render(vertices, triangles, AHEAD, size=(100, 100), colours=red, crevices=0, edges="hard")
    assert np.ptp(picture[6:94, 6:94, 0].astype(int)) <= 25


def test_the_nearer_surface_hides_the_farther_one_in_any_order() -> None:
    near, triangles = square(0.5, 1.0)
    far, _ = square(0.9, -1.0)
    vertices = np.concatenate([near, far])
    colours = np.repeat([[1.0, 0, 0], [0, 0, 1.0]], 4, axis=0)
    for faces in (np.concatenate([triangles, triangles + 4]), np.concatenate([triangles + 4, triangles])):
        middle = render(vertices, faces, AHEAD, size=(50, 50), colours=colours)[25, 25].astype(int)
        assert middle[0] > middle[2] + 80


def test_quick_edges_are_smooth_and_near_the_fine_ones() -> None:
    vertices, triangles = ball(60)
    fine, quick, hard = (
        render(vertices, triangles, AHEAD, size=(90, 90), edges=edges).astype(int)
        for edges in ("fine", "quick", "hard")
    )
    rim = np.abs(fine - hard).max(axis=2) > 20
    assert rim.sum() > 50
    assert np.abs(quick - fine)[rim].mean() < 0.7 * np.abs(hard - fine)[rim].mean()
    assert np.abs(quick - fine)[~rim].mean() < 2


def test_samples_that_see_neighbouring_triangles_share_light_without_changing_it() -> None:
    vertices, triangles = ball(60)
    sewn = render(vertices, triangles, AHEAD, size=(90, 90)).astype(int)
    normals = vertex_normals(vertices, triangles)[triangles].reshape(-1, 3)
    loose = np.arange(3 * len(triangles)).reshape(-1, 3)
    apart = render(vertices[triangles].reshape(-1, 3), loose, AHEAD, size=(90, 90), normals=normals)
    assert np.abs(sewn - apart).max() < 12


def test_a_hole_that_winds_its_way_out_is_background_and_a_closed_one_is_not() -> None:
    from mien.look.kernels import EMPTY, HOLE, flood

    snake = np.array(
        [[0, 0, 0, 0, 0, 0], [0, 2, 2, 2, 2, 0], [0, 0, 0, 0, 2, 0], [0, 2, 0, 2, 2, 0], [0, 2, 0, 0, 0, 0]]
    )
    owner = np.where(snake == 2, HOLE, 0).astype(np.int32)
    owner[3, 3] = 0
    flood(owner)
    assert (owner[1:4, 4] == HOLE).all()
    assert (owner[3:5, 1] == EMPTY).all()
    owner[3, 5] = HOLE
    flood(owner)
    assert (owner[1, 1:5] == EMPTY).all()


def test_a_surface_seen_from_inside_is_much_darker_than_from_outside() -> None:
    vertices, triangles = square(0.9)
    outside = render(vertices, triangles, AHEAD, size=(30, 30))[15, 15].mean()
    inside = render(vertices, triangles[:, ::-1], AHEAD, size=(30, 30))[15, 15].mean()
    assert inside < 0.5 * outside


def test_what_shows_through_a_hole_is_dark_and_what_lies_around_is_not() -> None:
    outer, _ = square(0.8)
    inner, _ = square(0.3)
    vertices = np.concatenate([outer, inner])
    ring = np.concatenate([[[i, (i + 1) % 4, 4 + i], [(i + 1) % 4, 4 + (i + 1) % 4, 4 + i]] for i in range(4)])
    picture = render(vertices, ring, AHEAD, size=(60, 60))
    assert picture[30, 30].max() < 70
    assert np.array_equal(picture[1, 1], nothing((60, 60))[1, 1])


def test_markers_are_hidden_behind_the_surface_unless_drawn_on_top() -> None:
    vertices, triangles = square(0.8)
    bare = render(vertices, triangles, AHEAD, size=(50, 50))

    def shown(z: float, on_top: bool) -> bool:
        dots = Dots(np.array([[0.0, 0.0, z], [np.nan] * 3]), (0.0, 0.2, 1.0), 0.1, on_top)
        return bool((render(vertices, triangles, AHEAD, size=(50, 50), dots=[dots]) != bare).any())

    assert shown(1.0, False)
    assert not shown(-1.0, False)
    assert shown(-1.0, True)


def test_a_marker_covers_the_disc_of_its_radius() -> None:
    dots = Dots(np.zeros((1, 3)), (0.0, 0.2, 1.0), 0.5)
    picture = render(np.zeros((1, 3)), np.empty((0, 3), np.int64), AHEAD, size=(200, 200), dots=[dots])
    area = covered(picture, nothing((200, 200))).sum()
    assert area == pytest.approx(np.pi * 50**2, rel=0.03)


def test_rotating_face_and_camera_together_changes_nothing() -> None:
    vertices, triangles = ball(30)
    turn = np.array([[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]])
    still = render(vertices, triangles, AHEAD, size=(80, 80))
    turned = render(
        vertices @ turn.T, triangles, Camera(turn @ AHEAD.position, np.zeros(3), AHEAD.angle), size=(80, 80)
    )
    assert np.abs(still.astype(int) - turned).mean() < 0.2


def test_normals_of_a_ball_point_away_from_its_centre_also_across_the_seam() -> None:
    vertices, triangles = ball(60)
    _, first, inverse = np.unique(np.round(vertices, 9), axis=0, return_index=True, return_inverse=True)
    out = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    along = (vertex_normals(vertices, triangles, first[inverse.ravel()]) * out).sum(axis=1)
    assert along.min() > 0.995


def test_geometry_around_and_behind_the_camera_is_left_out_without_complaint() -> None:
    vertices = np.array([[0.0, 0, 20], [1, 0, 5], [0, 1, 5], [0, 0, 10], [1e9, 0, 0], [0, 1e9, -5]])
    picture = render(vertices, np.array([[0, 1, 2], [3, 1, 2], [4, 5, 1]]), AHEAD, size=(30, 30))
    assert picture.shape == (30, 30, 3)


@pytest.mark.parametrize("size", [(0, 10), (10, -1), (10**6, 10**6)])
def test_a_size_that_cannot_be_is_refused(size: tuple[int, int]) -> None:
    with pytest.raises(InputError, match="pixels"):
        render(np.zeros((1, 3)), np.empty((0, 3), np.int64), AHEAD, size=size)


def test_triangles_beyond_the_vertices_are_refused() -> None:
    with pytest.raises(InputError, match="beyond"):
        render(np.zeros((2, 3)), np.array([[0, 1, 2]]), AHEAD)


def test_brighter_light_never_gives_a_darker_byte() -> None:
    table = encoding().astype(int)
    assert (np.diff(table) >= 0).all()
    assert table[0] == 0
    assert table[-1] == 255


def test_heat_grows_darker_once_it_has_left_the_grey_of_zero() -> None:
    colours = heat(np.linspace(0, 2, 9), 2.0)
    assert (np.diff(colours[2:] @ [0.2126, 0.7152, 0.0722]) < 0).all()
    assert np.allclose(heat(np.zeros(3), 0.0), heat(np.zeros(3), 1.0))


def test_twenty_thousand_triangles_are_pictured_in_a_fraction_of_a_second() -> None:
    vertices, triangles = ball(101)
    render(vertices, triangles, AHEAD)
    best = min(_seconds(lambda: render(vertices, triangles, AHEAD, edges="hard")) for _ in range(3))
    assert best < 0.5  # far above what it takes, so that a busy machine passes and a loop in Python does not


def _seconds(work) -> float:  # type: ignore[no-untyped-def]
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
