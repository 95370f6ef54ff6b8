"""Sheets, chosen frames, and films read back."""

from __future__ import annotations

import os
import re
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core import Clip, FileError, InputError
from mien.look.movie import _made_ahead, render_clip, sampled, write_movie
from mien.look.portrait import Portrait, frame_clip, portrait
from mien.look.sheet import Labelled, Row, contact_sheet, save_png, sheet, telling_frames
from tests.conftest import grid_rig
from tests.io.rigged_samples import fitted, played


@pytest.fixture
def clip() -> Clip:
    t = np.linspace(0, 2 * np.pi, 31)
    values = np.stack([np.clip(np.sin(t), 0, 1), np.clip(-np.sin(t), 0, 1), np.zeros(31)], axis=1)
    return Clip(("jawOpen", "smile_L", "smile_R"), values, 30.0)


def test_a_pose_changes_the_picture_and_the_neutral_is_the_default() -> None:
    rig = grid_rig()
    assert np.array_equal(portrait(rig, size=(64, 64)), portrait(rig, np.zeros(3), size=(64, 64)))
    assert (portrait(rig, np.array([1.0, 0, 0]), size=(64, 64)) != portrait(rig, size=(64, 64))).any()


def test_weights_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="3 finite weights"):
        portrait(grid_rig(), np.array([1.0, np.nan, 0]))


def test_telling_frames_hold_the_calmest_and_the_strongest(rng: np.random.Generator) -> None:
    values = rng.random((200, 5))
    values[17] = 0
    values[91] = 2
    values[3] = np.nan
    frames = telling_frames(values, 8)
    assert {17, 91} <= set(frames)
    assert 3 not in frames
    assert len(set(frames)) == 8
    assert (np.diff(frames) > 0).all()


def test_telling_frames_stop_when_the_rest_repeats() -> None:
    assert list(telling_frames(np.repeat(np.eye(3), 10, axis=0), 12)) == [0, 10, 20]


def test_a_clip_that_was_never_tracked_has_no_telling_frames() -> None:
    with pytest.raises(InputError, match="no tracked frame"):
        telling_frames(np.full((4, 2), np.nan))


def test_a_sheet_holds_each_picture_unchanged() -> None:
    red, blue = np.zeros((20, 30, 3), np.uint8), np.zeros((10, 30, 3), np.uint8)
    red[..., 0], blue[..., 2] = 200, 200
    paper = sheet([Row("actor", (Labelled(red, "one"), Labelled(blue, "<two>")))], "title")
    assert (paper == [200, 0, 0]).all(axis=2).sum() == 600
    assert (paper == [0, 0, 200]).all(axis=2).sum() == 300


def test_a_sheet_without_pictures_is_refused() -> None:
    with pytest.raises(InputError, match="at least one"):
        sheet([Row("actor", ())])


def test_a_contact_sheet_shows_the_frames_asked_for(clip: Clip) -> None:
    assert (
        contact_sheet(grid_rig(), clip, [0, 5], size=48).shape[1]
        < contact_sheet(grid_rig(), clip, count=4, size=48).shape[1]
    )
    with pytest.raises(InputError, match="frame 31 does not exist"):
        contact_sheet(grid_rig(), clip, [31])


def test_a_clip_for_another_character_is_refused(clip: Clip) -> None:
    with pytest.raises(InputError, match="retarget"):
        contact_sheet(grid_rig(shapes=("A", "B", "C")), clip)


def test_a_saved_picture_reads_back(tmp_path: Path, rng: np.random.Generator) -> None:
    from PIL import Image

    picture = rng.integers(0, 256, (7, 9, 3), dtype=np.uint8)
    save_png(tmp_path / "a.png", picture)
    with Image.open(tmp_path / "a.png") as image:
        assert np.array_equal(np.asarray(image), picture)
    with pytest.raises(FileError, match=r"\.png"):
        save_png(tmp_path / "a.jpg", picture)


def read_film(path: Path) -> tuple[str, np.ndarray]:
    """What ffmpeg says about a film, and its frames."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    about = next(line for line in done.stderr.decode().splitlines() if "Video: h264" in line)
    size = re.search(r", (\d+)x(\d+)", about)
    assert size is not None
    width, height = map(int, size.groups())
    return about, np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)


def test_a_film_reads_back_with_its_frames_size_and_rate(tmp_path: Path) -> None:
    levels = [40, 90, 140, 190, 240]
    write_movie(tmp_path / "a.mp4", (np.full((49, 65, 3), level, np.uint8) for level in levels), 25.0)
    about, frames = read_film(tmp_path / "a.mp4")
    assert "yuv420p" in about
    assert " 25 fps" in about
    assert frames.shape == (5, 48, 64, 3)
    assert np.abs(frames.mean(axis=(1, 2, 3)) - levels).max() < 4


def test_a_film_that_fails_leaves_what_stood_there(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    path.write_bytes(b"before")
    with pytest.raises(InputError, match="all must agree"):
        write_movie(path, iter([np.zeros((8, 8, 3), np.uint8), np.zeros((8, 10, 3), np.uint8)]), 30)
    with pytest.raises(InputError, match="no frames"):
        write_movie(path, iter([]), 30)
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


def test_a_filmed_clip_lasts_as_long_and_reports_its_progress(tmp_path: Path, clip: Clip) -> None:
    fast = Clip(clip.names, clip.values[:20], 60.0)
    calls: list[tuple[int, int]] = []
    render_clip(
        tmp_path / "a.mp4", grid_rig(), fast, size=(48, 48), progress=lambda done, whole: calls.append((done, whole))
    )
    about, frames = read_film(tmp_path / "a.mp4")
    assert " 30 fps" in about
    assert len(frames) == 10
    assert calls == [(i + 1, 10) for i in range(10)]


def test_pictures_made_ahead_keep_their_order_and_only_a_few_wait() -> None:
    made: list[int] = []

    def picture(frame: int) -> np.ndarray:
        time.sleep(0.002 * (frame % 3))
        made.append(frame)
        return np.full((1, 1, 3), frame, np.uint8)

    pictures = _made_ahead(picture, range(200))
    assert [int(next(pictures)[0, 0, 0]) for _ in range(5)] == list(range(5))
    assert len(made) < 5 + 4 * (os.cpu_count() or 1)
    assert [int(p[0, 0, 0]) for p in pictures] == list(range(5, 200))


def test_frames_not_tracked_are_grey_in_the_film(tmp_path: Path, clip: Clip) -> None:
    values = clip.values[:6].copy()
    values[3] = np.nan
    render_clip(tmp_path / "a.mp4", grid_rig(), Clip(clip.names, values, 30.0), size=(64, 64))
    _, frames = read_film(tmp_path / "a.mp4")
    colour = np.ptp(frames.astype(int), axis=3).mean(axis=(1, 2))
    assert colour[3] < 0.3 * colour[2]


@pytest.mark.parametrize(
    ("count", "fps", "wanted"), [(90, 60.0, 30.0), (10, 24.0, 30.0), (7, 59.94, 30.0), (1, 120.0, 30.0)]
)
def test_resampling_keeps_time(count: int, fps: float, wanted: float) -> None:
    frames = sampled(count, fps, wanted)
    moments = np.arange(len(frames)) / wanted
    assert np.abs(frames / fps - np.minimum(moments, (count - 1) / fps)).max() <= 0.5 / fps + 1e-9
    assert abs(len(frames) / wanted - count / fps) <= max(0.5 / wanted, 1 / wanted)


def test_a_moving_head_stays_in_the_picture(clip: Clip) -> None:
    rig = grid_rig()
    head = np.tile(np.eye(4), (31, 1, 1))
    head[:, 0, 3] = np.linspace(-0.2, 0.2, 31)
    moving = Clip(clip.names, clip.values, clip.fps, head=head)
    camera = frame_clip(rig, moving)
    ends = np.concatenate([rig.neutral.vertices + np.array([x, 0, 0]) for x in (-0.2, 0.2)])
    moved = rig.blendshapes.deltas.any(axis=(0, 2))
    x = camera.project(ends, 100, 100)[np.tile(moved, 2), 0]
    assert x.min() > -10
    assert x.max() < 110
    first = Portrait.of(rig, size=(64, 64), camera=camera).picture(head=head[0])
    last = Portrait.of(rig, size=(64, 64), camera=camera).picture(head=head[-1])
    assert (first != last).any()


def test_no_frame_that_is_shown_is_cropped_however_shapes_and_joints_add_up(rng: np.random.Generator) -> None:
    rig = fitted(grid_rig(8))
    clip = played(rig, 6)
    loud = replace(clip, values=5 * clip.values, head=None)
    for frames in (None, [3]):
        camera = frame_clip(rig, loud, frames=frames)
        shown = np.arange(6) if frames is None else np.array(frames)
        points = rig.pose(loud.values[shown], loud.joints[shown])
        x, y, _ = np.moveaxis(camera.project(points, 100, 100), -1, 0)
        assert min(x.min(), y.min()) > 0
        assert max(x.max(), y.max()) < 100


def test_frames_that_are_not_shown_do_not_make_the_face_small(clip: Clip) -> None:
    rig = grid_rig()
    loud = Clip(clip.names, clip.values * np.linspace(1, 40, 31)[:, None], clip.fps)
    near, far = frame_clip(rig, loud, frames=[0]), frame_clip(rig, loud)
    assert np.linalg.norm(near.position - near.target) < 0.8 * np.linalg.norm(far.position - far.target)
