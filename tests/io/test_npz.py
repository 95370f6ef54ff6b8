"""NumPy clips: exact, and safe to read from anywhere."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from mien.core import Clip, FileError
from mien.io import npz
from tests.io.hostile import survives


def clip(rng: np.random.Generator) -> Clip:
    values = rng.random((7, 3))
    values[2] = np.nan
    motion = np.tile(np.eye(4), (7, 1, 1))
    return Clip(("jawOpen", "smile_L", "口"), values, 29.97, motion, rng.random((7, 2, 3)), None, 12.25)


def test_a_clip_survives_a_round_trip_exactly(tmp_path: Path, rng: np.random.Generator) -> None:
    first = clip(rng)
    npz.write_clip(tmp_path / "a.npz", first)
    again = npz.read_clip(tmp_path / "a.npz")
    assert (again.names, again.fps, again.start) == (first.names, first.fps, first.start)
    for name in ("values", "head", "eyes"):
        np.testing.assert_array_equal(getattr(again, name), getattr(first, name))
    assert again.joints is None


def test_a_clip_without_frames_or_channels_survives(tmp_path: Path) -> None:
    npz.write_clip(tmp_path / "a.npz", Clip((), np.zeros((0, 0)), 30))
    assert npz.read_clip(tmp_path / "a.npz").values.shape == (0, 0)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"fps": None}, "lacks fps"),
        ({"fps": np.array([1.0, 2.0])}, "fps must be one"),
        ({"fps": -1.0}, "positive"),
        ({"names": np.arange(2)}, "list of text"),
        ({"names": np.array(["a", "a"])}, "distinct"),
        ({"names": np.array(["a"])}, "channel values"),
        ({"values": np.full((3, 2), np.inf)}, "infinite"),
        ({"values": np.array([["a", "b"]])}, "must hold numbers"),
        ({"start": np.nan}, "start must be one"),
    ],
)
def test_arrays_that_are_no_clip_are_refused(tmp_path: Path, change: dict[str, object], said: str) -> None:
    arrays = {"names": np.array(["a", "b"]), "values": np.zeros((3, 2)), "fps": 30.0} | change
    np.savez(tmp_path / "a.npz", **{name: value for name, value in arrays.items() if value is not None})
    with pytest.raises(FileError, match=said):
        npz.read_clip(tmp_path / "a.npz")


def test_nothing_is_unpickled(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", names=np.array(["a"], dtype=object), values=np.zeros((1, 1)), fps=30)
    with pytest.raises(FileError, match="does not fit"):
        npz.read_clip(tmp_path / "a.npz")


def test_a_header_that_promises_more_than_is_there_takes_no_memory(tmp_path: Path) -> None:
    raw = io.BytesIO()
    np.lib.format.write_array_header_1_0(raw, {"descr": "<f8", "fortran_order": False, "shape": (10**12, 10**6)})
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("values.npy", raw.getvalue())
    with pytest.raises(FileError, match="does not fit"):
        npz.read_clip(tmp_path / "a.npz")


def test_an_archive_that_unpacks_to_gigabytes_is_not_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(npz, "_MOST_BYTES", 1000)
    np.savez_compressed(tmp_path / "a.npz", names=np.array(["a"]), values=np.zeros((10000, 1)), fps=30)
    with pytest.raises(FileError, match="are not read"):
        npz.read_clip(tmp_path / "a.npz")


def test_damaged_files_are_refused_in_words(tmp_path: Path, rng: np.random.Generator) -> None:
    npz.write_clip(tmp_path / "a.npz", clip(rng))
    survives(npz.read_clip, tmp_path / "a.npz", rng)
