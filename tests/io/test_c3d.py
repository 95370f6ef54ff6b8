"""C3D: gaps, labels, units, number formats, and files that lie about themselves."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from mien.core import FileError, InputError, Markers
from mien.io import c3d
from tests.io.hostile import survives

ezc3d = pytest.importorskip("ezc3d")


def capture(rng: np.random.Generator, names: tuple[str, ...] = ("Chin", "Nose", "Brow"), frames: int = 12) -> Markers:
    return Markers(names, rng.normal(0.5, 0.1, (frames, len(names), 3)), 120.0)


def by_ezc3d(path: Path, labels: tuple[str, ...], points: np.ndarray, unit: str) -> None:
    """Write points `(F, M, 3)` with any labels and unit."""
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [60.0]
    file["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    file["parameters"]["POINT"]["LABELS"]["value"] = labels
    samples = np.ones((4, points.shape[1], len(points)))
    samples[:3] = points.transpose(2, 1, 0)
    file["data"]["points"] = samples
    file.write(str(path))


def by_hand(points: np.ndarray, labels: list[str], processor: int, scale: float) -> bytes:
    """Build a file as another processor, or with scaled integers, would write it."""
    order = ">" if processor == 86 else "<"

    def real(value: float) -> bytes:
        if processor != 85:
            return struct.pack(order + "f", value)
        low, high = struct.unpack("<2H", struct.pack("<f", value * 4))
        return struct.pack("<2H", high, low)

    width = max(map(len, labels))
    text = "".join(label.ljust(width) for label in labels).encode()
    entries = [
        (1, b"LABELS", b"\xff\x02" + bytes([width, len(labels)]) + text),
        (1, b"UNITS", b"\xff\x01\x02mm"),
    ]
    block = bytes([1, 80, 1, processor])
    block += struct.pack("bb", 5, -1) + b"POINT" + struct.pack(order + "H", 3) + b"\x00"
    for group, name, body in entries:
        block += struct.pack("bb", len(name), group) + name + struct.pack(order + "H", len(body) + 3) + body + b"\x00"
    block = block.ljust(512, b"\0")
    head = bytes([2, 80]) + struct.pack(order + "5H", len(labels), 0, 1, len(points), 0) + real(scale)
    head += struct.pack(order + "2H", 3, 0) + real(50.0)
    rows = np.concatenate([points, np.zeros((*points.shape[:2], 1))], axis=2).ravel()
    if scale > 0:
        data = np.rint(rows / scale).astype(order + "i2").tobytes()
    else:
        data = b"".join(real(float(value)) for value in rows)
    return head.ljust(512, b"\0") + block + data


def test_markers_survive_a_round_trip_with_their_gaps(tmp_path: Path, rng: np.random.Generator) -> None:
    markers = capture(rng)
    points = markers.points.copy()
    points[3:6, 1] = np.nan
    markers = Markers(markers.names, points, markers.fps)
    c3d.write_markers(tmp_path / "a.c3d", markers)
    again = c3d.read_markers(tmp_path / "a.c3d")
    assert again.names == markers.names
    assert again.fps == 120
    np.testing.assert_allclose(again.points, markers.points, atol=1e-7)
    assert [note.code for note in again.notes] == ["gaps"]
    assert "3 samples of 1 markers" in again.notes[0].message


def test_zeros_and_negative_residuals_are_gaps(tmp_path: Path, rng: np.random.Generator) -> None:
    points = rng.normal(100, 10, (8, 3, 3))
    points[2, 0] = 0
    points[4, 1] = np.nan
    content = by_hand(points, ["a", "b", "c"], 84, -1.0)
    (tmp_path / "a.c3d").write_bytes(content[:-4] + struct.pack("<f", -1.0))
    assert np.argwhere(~c3d.read_markers(tmp_path / "a.c3d").seen).tolist() == [[2, 0], [4, 1], [7, 2]]


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254)])
def test_units_become_metres(tmp_path: Path, unit: str, metres: float) -> None:
    by_ezc3d(tmp_path / "a.c3d", ("a",), np.full((3, 1, 3), 2.0), unit)
    markers = c3d.read_markers(tmp_path / "a.c3d")
    np.testing.assert_allclose(markers.points, 2 * metres)
    assert not markers.notes


def test_an_unknown_unit_is_taken_for_millimetres_and_said_so(tmp_path: Path) -> None:
    by_ezc3d(tmp_path / "a.c3d", ("a",), np.full((3, 1, 3), 2.0), "furlong")
    markers = c3d.read_markers(tmp_path / "a.c3d")
    np.testing.assert_allclose(markers.points, 2e-3)
    assert [note.code for note in markers.notes] == ["unit-assumed"]


@pytest.mark.parametrize(
    ("labels", "names", "codes"),
    [
        (("Actor:Chin", "Actor:Nose"), ("Chin", "Nose"), []),
        (("A:Chin", "B:Chin"), ("A:Chin", "B:Chin"), []),
        (("A:Chin", "Nose"), ("A:Chin", "Nose"), []),
        (("Chin", "Chin"), ("Chin", "Chin_2"), ["repeated-label"]),
        (("Chin", "Chin", "Chin_2"), ("Chin", "Chin_3", "Chin_2"), ["repeated-label"]),
        (("Chin", "*12", "U_3", ""), ("Chin",), ["unlabelled-markers"]),
        (("Actor:Chin", "*1"), ("Chin",), ["unlabelled-markers"]),
    ],
)
def test_labels_become_distinct_names(
    tmp_path: Path, labels: tuple[str, ...], names: tuple[str, ...], codes: list[str]
) -> None:
    points = np.arange(1.0, 1 + 2 * len(labels) * 3).reshape(2, len(labels), 3)
    (tmp_path / "a.c3d").write_bytes(by_hand(points, list(labels), 84, -1.0))
    markers = c3d.read_markers(tmp_path / "a.c3d")
    assert markers.names == names
    assert [note.code for note in markers.notes] == codes
    np.testing.assert_allclose(markers.points[0, 0], points[0, 0] / 1000)


def test_a_file_without_any_label_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.c3d").write_bytes(by_hand(np.ones((2, 2, 3)), ["*1", "*2"], 84, -1.0))
    with pytest.raises(FileError, match="none of its 2 markers has a label"):
        c3d.read_markers(tmp_path / "a.c3d")


@pytest.mark.parametrize("processor", [84, 85, 86])
@pytest.mark.parametrize("scale", [-1.0, 0.05])
def test_every_processor_and_both_number_formats_read_alike(
    tmp_path: Path, rng: np.random.Generator, processor: int, scale: float
) -> None:
    points = rng.normal(0, 300, (5, 2, 3))
    (tmp_path / "a.c3d").write_bytes(by_hand(points, ["a", "b"], processor, scale))
    markers = c3d.read_markers(tmp_path / "a.c3d")
    assert markers.fps == 50
    np.testing.assert_allclose(markers.points, points / 1000, atol=3e-5 if scale > 0 else 1e-7)


def test_labels_continue_in_a_second_parameter(tmp_path: Path, rng: np.random.Generator) -> None:
    names = tuple(f"m{i}" for i in range(300))
    c3d.write_markers(tmp_path / "a.c3d", capture(rng, names, 3))
    assert c3d.read_markers(tmp_path / "a.c3d").names == names


def test_more_frames_than_the_header_can_count_are_read(tmp_path: Path, rng: np.random.Generator) -> None:
    markers = capture(rng, ("Chin",), 70_000)
    c3d.write_markers(tmp_path / "a.c3d", markers)
    again = c3d.read_markers(tmp_path / "a.c3d")
    assert len(again) == 70_000
    assert not again.notes


def test_a_capture_of_nothing_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="at least one"):
        c3d.write_markers(tmp_path / "a.c3d", Markers(("Chin",), np.zeros((0, 1, 3)), 60))


def test_names_outside_ascii_survive(tmp_path: Path, rng: np.random.Generator) -> None:
    c3d.write_markers(tmp_path / "a.c3d", capture(rng, ("Kinn ü", "口")))
    assert c3d.read_markers(tmp_path / "a.c3d").names == ("Kinn ü", "口")


def test_a_cut_off_file_gives_its_whole_frames_and_says_so(tmp_path: Path, rng: np.random.Generator) -> None:
    content = by_hand(rng.normal(0, 300, (12, 3, 3)), ["a", "b", "c"], 84, -1.0)
    (tmp_path / "a.c3d").write_bytes(content[:-100])
    again = c3d.read_markers(tmp_path / "a.c3d")
    assert len(again) == 12 - 3
    assert [note.code for note in again.notes] == ["truncated-file"]


def test_damaged_files_are_refused_in_words(tmp_path: Path, rng: np.random.Generator) -> None:
    c3d.write_markers(tmp_path / "a.c3d", capture(rng))
    survives(c3d.read_markers, tmp_path / "a.c3d", rng)


@pytest.mark.real
@pytest.mark.parametrize("take", ["jaw", "cheeks", "eyebrows"])
def test_real_takes_read_as_an_independent_reader_reads_them(data: Path, take: str) -> None:
    path = data / "clips" / "markers" / f"{take}.c3d"
    markers = c3d.read_markers(path)
    other = ezc3d.c3d(str(path))
    assert list(markers.names) == list(other["parameters"]["POINT"]["LABELS"]["value"])
    assert markers.fps == 60
    assert not markers.notes
    np.testing.assert_allclose(markers.points, other["data"]["points"][:3].transpose(2, 1, 0) / 1000, atol=1e-12)
