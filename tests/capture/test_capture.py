from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.capture import fill_gaps, find_neutral, learn_stabiliser, trace
from mien.capture.neutral import neutral_at
from mien.core import Clip, InputError, Markers, SurfacePoints
from mien.io.formats import read_markers
from tests.conftest import grid_rig

NAMES = tuple(f"m{i}" for i in range(12))


def take(rng: np.random.Generator, frames: int = 200) -> Markers:
    """A face at rest in the middle of the take, moving in a few points before and after, the head turning."""
    face = rng.normal(size=(12, 3)) * 0.06
    moving = np.zeros((frames, 12, 3))
    beat = np.abs(np.cos(np.linspace(0, 9, frames)))
    moving[:, :4, 1] = -0.02 * beat[:, None]
    moving[60:140] = 0
    turns = Rotation.from_euler("y", np.linspace(-0.2, 0.2, frames)[:, None]).as_matrix()
    points = (face + moving) @ np.swapaxes(turns, 1, 2) + rng.normal(0, 1e-4, (frames, 12, 3))
    return Markers(NAMES, points, 60.0)


def test_the_neutral_is_where_the_take_dwells(rng: np.random.Generator) -> None:
    markers = take(rng)
    found = find_neutral(markers)
    still, _ = learn_stabiliser(found.points, markers.points[60:140])(markers.points[60:140])
    assert np.abs(still[:, 4:] - found.points[4:]).max() < 0.002
    assert found.dwell > 0.3


def test_a_neutral_with_missing_markers_is_refused_by_name(rng: np.random.Generator) -> None:
    markers = take(rng)
    points = markers.points.copy()
    points[7, 2] = np.nan
    with pytest.raises(InputError, match="frame 7 misses m2"):
        neutral_at(replace(markers, points=points), 7)
    with pytest.raises(InputError, match="frames 0 … 199"):
        neutral_at(markers, 200)


def test_a_take_that_never_sees_a_marker_names_it(rng: np.random.Generator) -> None:
    markers = take(rng)
    points = markers.points.copy()
    points[:, 5] = np.nan
    with pytest.raises(InputError, match="m5"):
        find_neutral(replace(markers, points=points))


def test_head_motion_is_taken_out_and_returned(rng: np.random.Generator) -> None:
    markers = take(rng)
    neutral = neutral_at(markers, 100).points
    stabiliser = learn_stabiliser(neutral, markers.points)
    still, motion = stabiliser(markers.points)
    assert np.abs(still[:, 4:] - neutral[4:]).max() < 1e-3
    back = np.einsum("fab,fmb->fma", motion[:, :3, :3], still) + motion[:, None, :3, 3]
    assert np.allclose(back, markers.points)
    assert stabiliser.stability[:4].max() < stabiliser.stability[4:].min()


def test_named_rigid_markers_alone_decide(rng: np.random.Generator) -> None:
    markers = take(rng)
    stabiliser = learn_stabiliser(markers.points[100], markers.points, [6, 7, 8, 9])
    assert np.flatnonzero(stabiliser.stability).tolist() == [6, 7, 8, 9]
    with pytest.raises(InputError, match="at least 3"):
        learn_stabiliser(markers.points[100], markers.points, [6, 7])


@pytest.mark.real
def test_a_take_that_moves_the_whole_face_is_held_still_by_forehead_and_brows(data: Path) -> None:
    markers = read_markers(data / "clips" / "markers" / "cheeks.c3d")
    quiet = ("ForeHead_R", "ForeHead_M", "ForeHead_L", "NoseTop", "Reye_Inside", "Leye_Inside")
    neutral = neutral_at(markers, 0).points
    found = learn_stabiliser(neutral, markers.points)
    named = learn_stabiliser(neutral, markers.points, [markers.names.index(name) for name in quiet])
    off = np.linalg.norm(found(markers.points[::10])[0] - named(markers.points[::10])[0], axis=2)
    assert np.sqrt((off**2).mean()) < 0.002
    assert found.stability.sum() ** 2 / (found.stability**2).sum() > 6  # points that share the say


def test_short_gaps_are_bridged_and_long_ones_left_and_both_counted(rng: np.random.Generator) -> None:
    markers = take(rng)
    points = markers.points.copy()
    points[50:55, 0] = np.nan
    points[80:140, 1] = np.nan
    points[:4, 2] = np.nan
    filled = fill_gaps(replace(markers, points=points))
    assert np.abs(filled.points[50:55, 0] - markers.points[50:55, 0]).max() < 5e-4
    assert np.isnan(filled.points[80:140, 1]).all()
    assert np.isnan(filled.points[:4, 2]).all()
    notes = {note.code: note.message for note in filled.notes}
    assert notes["gaps-filled"].startswith("5 ")
    assert notes["gaps-left"].startswith("64 ")


def test_nothing_changes_without_gaps(rng: np.random.Generator) -> None:
    markers = take(rng)
    filled = fill_gaps(markers)
    assert np.array_equal(filled.points, markers.points)
    assert not filled.notes


def test_tracing_follows_the_posed_surface(rng: np.random.Generator) -> None:
    rig = grid_rig()
    values = rng.uniform(0, 1, (300, 3))
    values[17] = np.nan
    points = SurfacePoints(rig.neutral.triangles[[3, 8, 20]], rng.dirichlet(np.ones(3), 3))
    traced = trace(rig, Clip(rig.blendshapes.names, values, 30), points, ("a", "b", "c"))
    for frame in (0, 100, 299):
        assert np.allclose(traced.points[frame], points.of(rig.pose(values[frame])))
    assert np.isnan(traced.points[17]).all()


@pytest.mark.real
@pytest.mark.parametrize("name", ["jaw", "cheeks", "eyebrows"])
def test_the_neutral_of_the_real_takes_looks_like_their_beginning(data: Path, name: str) -> None:
    markers = read_markers(data / "clips" / "markers" / f"{name}.c3d")
    found = find_neutral(markers)
    still, _ = learn_stabiliser(found.points, markers.points)(markers.points)
    beginning = np.sqrt(((still[:10] - found.points) ** 2).sum(axis=2).mean())
    strongest = np.sqrt(((still - found.points) ** 2).sum(axis=2).mean(axis=1)).max()
    assert beginning < 0.002
    assert strongest > 3 * beginning
