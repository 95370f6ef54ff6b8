"""Plain weights: what mien writes, and what others make of the same idea."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core import Clip, FileError
from mien.io import weights
from tests.io.hostile import survives


def clip_of(tmp_path: Path, text: str, fps: float | None = None) -> Clip:
    (tmp_path / "a.csv").write_bytes(text.encode())
    return weights.read_clip(tmp_path / "a.csv", fps)


def codes(clip: Clip) -> list[str]:
    return [note.code for note in clip.notes]


@pytest.mark.parametrize("fps", [24, 29.97, 30, 60, 120])
def test_weights_survive_a_round_trip_to_six_decimals(tmp_path: Path, rng: np.random.Generator, fps: float) -> None:
    values = rng.normal(0.3, 0.4, (200, 5))
    values[3], values[7, 2], values[8], values[9, 1] = np.nan, np.nan, 0, -1e-9
    clip = Clip(("jawOpen", "a, b", 'say "cheese"', "smile L", "0"), values, fps, start=3600.5)
    weights.write_clip(tmp_path / "a.csv", clip)
    again = weights.read_clip(tmp_path / "a.csv")
    assert again.names == clip.names
    assert again.fps == pytest.approx(fps, rel=1e-5)
    assert again.start == clip.start
    np.testing.assert_allclose(again.values, values, atol=5.1e-7)
    assert codes(again) == ["gaps"]
    assert "-0," not in (tmp_path / "a.csv").read_text()


def test_the_header_is_the_one_scripts_rely_on(tmp_path: Path) -> None:
    weights.write_clip(tmp_path / "a.csv", Clip(("jawOpen", "x"), np.array([[0.5, 1], [0, 0.25]]), 30))
    expected = "frame,time,jawOpen,x\n0,0,0.500000,1\n1,0.033333,0,0.250000\n"
    assert (tmp_path / "a.csv").read_text() == expected


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_separators_and_quotes_do_not_matter(tmp_path: Path, separator: str) -> None:
    text = '"frame","Time","jaw Open"\r\n0,0,.5\r\n"1","0.04",".75"\r\n\r\n'.replace(",", separator)
    clip = clip_of(tmp_path, text)
    assert clip.names == ("jaw Open",)
    assert clip.fps == 25
    assert clip.values.tolist() == [[0.5], [0.75]]
    assert not clip.notes


def test_decimal_commas_between_semicolons_are_read_and_noted(tmp_path: Path) -> None:
    clip = clip_of(tmp_path, "time;a;b\n0;0,5;1\n0,02;0,25;1\n")
    assert clip.values.tolist() == [[0.5, 1], [0.25, 1]]
    assert clip.fps == 50
    assert codes(clip) == ["decimal-comma"]


def test_without_times_the_rate_is_given_or_assumed(tmp_path: Path) -> None:
    text = "a,b\n1,2\n3,4\n"
    assert codes(clip_of(tmp_path, text)) == ["fps-assumed"]
    assert clip_of(tmp_path, text).fps == 30
    assert clip_of(tmp_path, text, fps=48).fps == 48
    assert codes(clip_of(tmp_path, text, fps=48)) == []


def test_blank_cells_and_nan_are_gaps(tmp_path: Path) -> None:
    clip = clip_of(tmp_path, "a,b\n1,\nNaN,4\n5,6\n", 30)
    assert np.isnan(clip.values).tolist() == [[False, True], [True, False], [False, False]]
    assert "2 frames have blank cells: 0–1" in clip.notes[0].message


def test_a_last_row_cut_off_is_left_out_and_said_so(tmp_path: Path) -> None:
    clip = clip_of(tmp_path, "a,b,c\n1,2,3\n4,5,6\n7,8", 30)
    assert len(clip) == 2
    assert codes(clip) == ["truncated-row"]


def test_uneven_times_are_noted(tmp_path: Path) -> None:
    times = [0.0, 0.1, 0.2, 0.5, 0.6, 0.7]
    clip = clip_of(tmp_path, "time,a\n" + "".join(f"{t},1\n" for t in times))
    assert clip.fps == pytest.approx(10)
    assert codes(clip) == ["uneven-times"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("\n \n", "no rows"),
        ("1,2\n3,4\n", "begins with numbers"),
        ("a,a\n1,2\n", "more than one column named 'a'"),
        ("a,,b\n1,2,3\n", "column 2 has no name"),
        ("a,b\n1,x\n2,3\n", "line 2, column 'b': 'x'"),
        ("a,b\n1\n2,3\n", "line 2: 1 cells"),
        ("a,b\n1,inf\n", "infinity"),
        ("frame,time\n0,0\n", "no channel"),
        ("time,a\n0,1\n0,1\n", "do not rise"),
        ("time,a\n0,1\n,1\n2,1\n", "time column are blank"),
    ],
)
def test_errors_say_what_and_where(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(FileError, match=said):
        clip_of(tmp_path, text)


def test_a_clip_without_frames_survives(tmp_path: Path) -> None:
    weights.write_clip(tmp_path / "a.csv", Clip(("a",), np.zeros((0, 1)), 30))
    assert weights.read_clip(tmp_path / "a.csv").values.shape == (0, 1)


def test_damaged_files_are_refused_in_words(tmp_path: Path, rng: np.random.Generator) -> None:
    weights.write_clip(tmp_path / "a.csv", Clip(("jawOpen", "smile"), rng.random((30, 2)), 30))
    survives(weights.read_clip, tmp_path / "a.csv", rng)


@pytest.mark.real
def test_controls_without_frame_and_time_are_read(data: Path) -> None:
    clip = weights.read_clip(data / "clips" / "aura_controls_first_half.csv")
    assert clip.values.shape == (1400, 72)
    assert clip.names[0] == "browDown_L"
    assert codes(clip) == ["fps-assumed"]
