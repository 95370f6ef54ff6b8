"""TRC: the same markers under all the ways programs write the text."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core import FileError, Markers
from mien.io import c3d, trc
from tests.io.hostile import survives

HEADER = (
    "PathFileType\t4\t(X/Y/Z)\ta.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "100\t100\t2\t2\tmm\t100\t1\t2\nFrame#\tTime\tChin\t\t\tNose\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
)
ROWS = "1\t0.0\t1\t2\t3\t4\t5\t6\n2\t0.01\t7\t8\t9\t10\t11\t12\n"


def markers_of(tmp_path: Path, text: str) -> Markers:
    (tmp_path / "a.trc").write_bytes(text.encode())
    return trc.read_markers(tmp_path / "a.trc")


def test_markers_survive_a_round_trip_with_their_gaps(tmp_path: Path, rng: np.random.Generator) -> None:
    points = rng.normal(0, 0.2, (20, 3, 3))
    points[4:7, 1] = np.nan
    points[:, 2] = np.nan
    markers = Markers(("Chin", "Nose", "Brow"), points, 59.94)
    trc.write_markers(tmp_path / "a.trc", markers)
    again = trc.read_markers(tmp_path / "a.trc")
    assert (again.names, again.fps) == (markers.names, 59.94)
    np.testing.assert_allclose(again.points, points, atol=5.1e-9)
    assert [note.code for note in again.notes] == ["gaps"]


@pytest.mark.parametrize("blank", ["", "\n", "\n\n"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_blank_lines_and_line_ends_do_not_matter(tmp_path: Path, blank: str, end: str) -> None:
    markers = markers_of(tmp_path, (HEADER + blank + ROWS).replace("\n", end))
    np.testing.assert_allclose(markers.points * 1000, np.arange(1, 13).reshape(2, 2, 3))
    assert markers.fps == 100
    assert not markers.notes


def test_spaces_separate_as_tabs_do(tmp_path: Path) -> None:
    head, labels, axes = HEADER.rsplit("\n", 3)[0], "Frame#  Time  Chin   Nose", "X1 Y1 Z1 X2 Y2 Z2"
    text = "\n".join([*head.split("\n")[:3], labels, axes, "", *ROWS.replace("\t", "   ").split("\n")])
    np.testing.assert_allclose(markers_of(tmp_path, text).points * 1000, np.arange(1, 13).reshape(2, 2, 3))


@pytest.mark.parametrize("gap", ["\t\t", "NaN\tNaN\tNaN", "0\t0\t0", "0.000\t0.000\t0.000", "\tNaN\t3"])
def test_blanks_nan_and_zeros_are_gaps(tmp_path: Path, gap: str) -> None:
    markers = markers_of(tmp_path, HEADER + ROWS.replace("7\t8\t9", gap))
    assert markers.seen.tolist() == [[True, True], [False, True]]
    assert [note.code for note in markers.notes] == ["gaps"]


def test_a_short_row_is_a_gap_at_its_end(tmp_path: Path) -> None:
    markers = markers_of(tmp_path, HEADER + ROWS.replace("\t10\t11\t12", ""))
    assert markers.seen.tolist() == [[True, True], [True, False]]


def test_a_last_row_cut_off_is_left_out_and_said_so(tmp_path: Path) -> None:
    markers = markers_of(tmp_path, HEADER + ROWS + "3\t0.02\t7\t8")
    assert len(markers) == 2
    assert [note.code for note in markers.notes] == ["truncated-row"]


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)])
def test_units_become_metres(tmp_path: Path, unit: str, metres: float) -> None:
    markers = markers_of(tmp_path, HEADER.replace("\tmm\t", f"\t{unit}\t") + ROWS)
    assert markers.points[0, 0, 0] == metres


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("DataRate", "Data", "DataRate"),
        ("Frame#", "Time", "Frame#"),
        ("100\t100\t2", "fast\t100\t2", "not a number"),
        ("100\t100\t2", "0\t100\t2", "positive"),
        ("Chin\t\t\tNose", "\t\t\t", "no markers"),
        ("7\t8\t9", "7\tx\t9", "line 7, column 'Chin Y'"),
        ("7\t8\t9", "7\tinf\t9", "infinity"),
        (ROWS, "", "no frame"),
    ],
)
def test_errors_say_what_and_where(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(FileError, match=said):
        markers_of(tmp_path, (HEADER + ROWS).replace(old, new))


def test_a_count_that_is_not_there_is_noted(tmp_path: Path) -> None:
    markers = markers_of(tmp_path, HEADER.replace("\t2\t2\t", "\t999999999\t2\t") + ROWS)
    assert [note.code for note in markers.notes] == ["count-differs"]


def test_damaged_files_are_refused_in_words(tmp_path: Path, rng: np.random.Generator) -> None:
    trc.write_markers(tmp_path / "a.trc", Markers(("Chin", "Nose"), rng.normal(size=(12, 2, 3)), 60))
    survives(trc.read_markers, tmp_path / "a.trc", rng)


@pytest.mark.real
def test_a_real_take_is_the_same_as_text_and_as_c3d(data: Path) -> None:
    text = trc.read_markers(data / "clips" / "markers" / "jaw.trc")
    binary = c3d.read_markers(data / "clips" / "markers" / "jaw.c3d")
    assert (text.names, text.fps) == (binary.names, binary.fps)
    np.testing.assert_allclose(text.points, binary.points, atol=6e-8)
