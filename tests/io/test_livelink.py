"""Live Link Face: lost frames, timecode, angles, and the layout other importers expect."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.core import Clip, FileError, InputError
from mien.io import livelink
from mien.vocabularies import ARKIT_NAMES
from tests.io.hostile import survives

TAKES = ["alex_rom_3", "S07-001", "apfel"]
HEAD = ["HeadYaw", "HeadPitch", "HeadRoll"]


def recording(rng: np.random.Generator, frames: int = 90, fps: float = 30, start: float = 40000.5) -> Clip:
    turns = Rotation.from_euler("YXZ", rng.uniform(-1, 1, (frames, 3))).as_matrix()
    head = np.tile(np.eye(4), (frames, 1, 1))
    head[:, :3, :3] = turns
    eyes = rng.uniform(-0.5, 0.5, (frames, 2, 3))
    return Clip(ARKIT_NAMES, rng.random((frames, 52)).round(10), fps, head, eyes, start=start)


def codes(clip: Clip) -> list[str]:
    return [note.code for note in clip.notes]


def clip_of(tmp_path: Path, names: list[str], rows: list[str], count: str = "BlendShapeCount") -> Clip:
    (tmp_path / "a.csv").write_text("\n".join([",".join(["Timecode", count, *names]), *rows]) + "\n")
    return livelink.read_clip(tmp_path / "a.csv")


@pytest.mark.parametrize("fps", [24, 30, 60])
def test_a_recording_survives_a_round_trip(tmp_path: Path, rng: np.random.Generator, fps: float) -> None:
    clip = recording(rng, fps=fps)
    livelink.write_clip(tmp_path / "a.csv", clip)
    again = livelink.read_clip(tmp_path / "a.csv")
    assert again.names == clip.names
    assert (again.fps, codes(again)) == (fps, [])
    assert again.start == pytest.approx(clip.start, abs=1e-5)
    for name in ("values", "head", "eyes"):
        np.testing.assert_allclose(getattr(again, name), getattr(clip, name), atol=1e-9)


def test_lost_frames_are_gaps_with_the_head_held_and_are_written_as_lost(
    tmp_path: Path, rng: np.random.Generator
) -> None:
    clip = recording(rng)
    values = clip.values.copy()
    values[[0, 5, 6]] = np.nan
    livelink.write_clip(tmp_path / "a.csv", Clip(clip.names, values, 30, clip.head, clip.eyes, start=0.0))
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert lines[6] == "00:00:00:10.000,0"
    again = livelink.read_clip(tmp_path / "a.csv")
    assert codes(again) == ["tracking-lost"]
    assert "3 of 90 frames: 0, 5–6" in again.notes[0].message
    np.testing.assert_array_equal(np.isnan(again.values), np.isnan(values))
    assert again.head is not None
    assert clip.head is not None
    np.testing.assert_allclose(again.head[[0, 5, 6]], clip.head[[1, 4, 4]], atol=1e-9)


def test_columns_are_found_by_name_in_any_order_and_with_either_header(tmp_path: Path) -> None:
    rows = [f"00:00:00:{f:02d}.000,5,.1,.2,0,0,1.08,.3" for f in range(3)]
    names = ["JawRight", "JawLeft", *HEAD[:2], "EyeBlinkLeft", "Custom"]
    clip = clip_of(tmp_path, names, rows, "BlendshapeCount")
    assert clip.names == ("jawRight", "jawLeft", "HeadYaw", "HeadPitch", "eyeBlinkLeft", "Custom")
    assert clip.channels(["jawRight", "jawLeft", "eyeBlinkLeft"])[0].tolist() == [0.1, 0.2, 1.08]
    assert livelink.is_livelink(tmp_path / "a.csv")


def test_a_head_of_zeros_was_not_recorded(tmp_path: Path) -> None:
    rows = [f"00:00:{f // 60:02d}:{f % 60:02d}.000,4,.5,0,0,0" for f in range(90)]
    clip = clip_of(tmp_path, ["JawOpen", *HEAD], rows)
    assert clip.head is None
    assert codes(clip) == ["head-not-recorded"]
    assert clip.fps == 60


def test_the_head_turns_about_mien_s_axes(tmp_path: Path) -> None:
    rows = ["00:00:00:00.000,3,.3,0,0", "00:00:00:01.000,3,0,.3,0", "00:00:00:02.000,3,0,0,.3"]
    clip = clip_of(tmp_path, HEAD, rows)
    assert clip.head is not None
    forward, up = clip.head[:, :3, 2], clip.head[:, :3, 1]
    assert forward[0] == pytest.approx([np.sin(0.3), 0, np.cos(0.3)])  # yaw: towards the subject's left, +X
    assert forward[1] == pytest.approx([0, np.sin(0.3), np.cos(0.3)])  # pitch: upwards
    assert up[2] == pytest.approx([np.sin(0.3), np.cos(0.3), 0])  # roll: the crown towards the left


@pytest.mark.parametrize(
    ("codes_written", "fps"),
    [
        ([f"00:00:{f // 30:02d}:{f % 30 * 2:02d}.500" for f in range(90)], 30),
        ([f"00:00:{f // 60:02d}:{f % 60:02d}.25" for f in range(150)], 60),
        ([f"00:00:{f // 30:02d}:{f % 30:02d}.000" for f in range(90)], 30),
        ([f"23:59:{59 if f < 60 else 0:02d}:{f % 60:02d}.000".replace("23:59:00", "00:00:00") for f in range(120)], 60),
    ],
)
def test_the_rate_is_told_from_the_timecode(tmp_path: Path, codes_written: list[str], fps: float) -> None:
    clip = clip_of(tmp_path, ["JawOpen"], [f"{code},1,.5" for code in codes_written])
    assert clip.fps == fps
    assert codes(clip) == []


def test_frames_the_timecode_skips_are_counted(tmp_path: Path) -> None:
    frames = [f for f in range(150) if f not in {20, 21, 70}]
    clip = clip_of(tmp_path, ["JawOpen"], [f"01:00:{f // 60:02d}:{f % 60:02d}.0,1,.5" for f in frames])
    assert clip.fps == 60
    assert codes(clip) == ["frames-dropped"]
    assert "skips 3 frames" in clip.notes[0].message


def test_a_last_row_cut_off_is_left_out_and_said_so(tmp_path: Path, rng: np.random.Generator) -> None:
    livelink.write_clip(tmp_path / "a.csv", recording(rng))
    content = (tmp_path / "a.csv").read_text()
    (tmp_path / "a.csv").write_text(content[:-300])
    again = livelink.read_clip(tmp_path / "a.csv")
    assert len(again) == 89
    assert codes(again) == ["truncated-row"]


def test_any_spelling_is_written_and_halves_become_their_mean(tmp_path: Path) -> None:
    names = ("browInnerUp_L", "browInnerUp_R", "EyeBlink.L", "cheekRaiser_L", "jawLeft")
    values = np.tile([0.2, 0.6, 0.5, np.nan, 0.1], (3, 1))
    livelink.write_clip(tmp_path / "a.csv", Clip(names, values, 60))
    again = livelink.read_clip(tmp_path / "a.csv")
    wanted = ["browInnerUp", "eyeBlinkLeft", "jawLeft", "jawRight"]
    np.testing.assert_allclose(again.channels(wanted)[1], [0.4, 0.5, 0.1, 0])
    assert len(again.names) == 52


def test_channels_that_are_not_arkit_at_all_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="none of the clip's 2 channels"):
        livelink.write_clip(tmp_path / "a.csv", Clip(("lipPucker_L", "x"), np.zeros((2, 2)), 30))
    assert not (tmp_path / "a.csv").exists()


def test_a_frame_with_some_values_missing_is_refused(tmp_path: Path) -> None:
    values = np.array([[0.1, 0.2], [0.3, np.nan]])
    with pytest.raises(InputError, match="frame 1 lacks a value for 'eyeBlinkLeft'"):
        livelink.write_clip(tmp_path / "a.csv", Clip(("jawOpen", "eyeBlinkLeft"), values, 30))


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([], "no frame"),
        (["00:00:00:00.0,1,inf"], "infinity"),
        (["12:00,1,.5"], "not a timecode"),
        (["00:00:00:00.0,1,x"], "line 2, column 'JawOpen'"),
        (["00:00:00:00.0,1,.5,.6", "00:00:00:01.0,1,.5"], "line 2: 4 cells"),
    ],
)
def test_errors_say_what_and_where(tmp_path: Path, rows: list[str], said: str) -> None:
    with pytest.raises(FileError, match=said):
        clip_of(tmp_path, ["JawOpen"], rows)


def test_other_tables_are_not_taken_for_recordings(tmp_path: Path) -> None:
    for i, content in enumerate([b"frame,time,jawOpen\n0,0,1\n", b"", b"\0\1\2" * 50, b"Timecode,jawOpen\n"]):
        path = tmp_path / f"{i}.csv"
        path.write_bytes(content)
        assert not livelink.is_livelink(path)


def test_damaged_files_are_refused_in_words(tmp_path: Path, rng: np.random.Generator) -> None:
    livelink.write_clip(tmp_path / "a.csv", recording(rng, 5))
    survives(livelink.read_clip, tmp_path / "a.csv", rng)


@pytest.mark.real
@pytest.mark.parametrize("take", TAKES)
def test_real_takes_survive_a_round_trip(data: Path, tmp_path: Path, take: str) -> None:
    path = data / "clips" / "livelink" / f"{take}.csv"
    clip = livelink.read_clip(path)
    assert (clip.names, clip.fps) == (ARKIT_NAMES, 30)
    assert clip.head is None
    assert ("tracking-lost" in codes(clip)) == (take == "apfel")
    livelink.write_clip(tmp_path / "a.csv", clip)
    again = livelink.read_clip(tmp_path / "a.csv")
    assert again.start == pytest.approx(clip.start, abs=1e-6)
    np.testing.assert_allclose(again.values, clip.values, atol=1e-9)
    assert clip.eyes is not None
    np.testing.assert_allclose(again.eyes, clip.eyes, atol=1e-9)
    first, header = path.read_text().splitlines()[1].split(","), path.read_text().splitlines()[0]
    written = (tmp_path / "a.csv").read_text().splitlines()
    assert written[0] == header
    np.testing.assert_allclose([float(x) for x in written[1].split(",")[2:]], [float(x) for x in first[2:]])


@pytest.mark.real
@pytest.mark.parametrize("take", TAKES)
def test_the_eyes_turn_where_the_eye_weights_say(data: Path, take: str) -> None:
    clip = livelink.read_clip(data / "clips" / "livelink" / f"{take}.csv")
    assert clip.eyes is not None
    seen = ~np.isnan(clip.values[:, 0])
    names = ["eyeLookOutLeft", "eyeLookInLeft", "eyeLookDownLeft", "eyeLookUpLeft"]
    out, inward, down, up = clip.channels(names)[seen].T
    yaw, pitch = clip.eyes[seen, 0, 0], clip.eyes[seen, 0, 1]
    assert np.corrcoef(yaw, out - inward)[0, 1] > 0.9  # the left eye's outside is the subject's left, +X
    assert np.corrcoef(pitch, down - up)[0, 1] > 0.9
