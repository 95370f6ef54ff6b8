from __future__ import annotations

import numpy as np

from mien.solve.layered_projection import Layout, lay_out, project_frames

EXTREMES, REGIONS = 6, 3


def projected(layout: Layout, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    data = np.full((len(moved), REGIONS, EXTREMES), np.nan)
    energy, whole = np.full(len(moved), np.nan), np.zeros(len(moved), bool)
    project_frames(layout, moved, data, energy, whole)
    return data, energy, whole


def dense(points: int, frames: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A face of more points than a window, its regions anyhow among them."""
    rng = np.random.default_rng(8)
    regions = rng.integers(0, REGIONS, points)
    importance = rng.uniform(0.5, 1.5, points)
    return rng.normal(size=(EXTREMES, points, 3)), regions, importance, rng.normal(size=(frames, points, 3))


def test_sums_over_many_windows_are_the_written_ones() -> None:
    for points in (1, 40, 511, 512, 1500):
        basis, regions, importance, moved = dense(points, 19)
        data, energy, whole = projected(lay_out(basis, regions, importance), moved)
        masks = (regions == np.arange(REGIONS)[:, None]) * importance / points
        assert np.abs(data - np.einsum("mp,npx,fpx->fmn", masks, basis, moved)).max() < 1e-12
        assert np.abs(energy - np.einsum("p,fpx->f", importance / points, moved**2)).max() < 1e-12
        assert whole.all()


def test_points_not_seen_say_nothing_and_are_told() -> None:
    basis, regions, importance, moved = dense(1100, 20)
    moved[3, 600:] = np.nan
    moved[7, 5] = np.nan
    moved[9] = np.nan
    data, energy, whole = projected(lay_out(basis, regions, importance), moved)
    filled = projected(lay_out(basis, regions, importance), np.nan_to_num(moved))
    assert np.array_equal(data, filled[0])
    assert np.array_equal(energy, filled[1])
    assert np.flatnonzero(~whole).tolist() == [3, 7, 9]


def test_a_frame_alone_gives_what_it_gives_among_others_to_the_bit() -> None:
    basis, regions, importance, moved = dense(1100, 300)
    layout = lay_out(basis, regions, importance)
    data, energy, _ = projected(layout, moved)
    for f in (0, 5, 17, 255, 256, 299):
        one, power, _ = projected(layout, moved[f : f + 1])
        assert np.array_equal(one[0], data[f])
        assert power[0] == energy[f]
