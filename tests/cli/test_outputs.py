"""Outputs are refused before the work, never replace what is read, and are written together or not at all."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from mien.core import Blendshapes, FileError
from mien.io import gltf
from tests.cli.running import contents, mien
from tests.job.small_files import FEW_SHAPES, SmallFiles, write_small_files
from tests.retargeting.actors import face


@pytest.fixture
def files(tmp_path: Path) -> SmallFiles:
    (tmp_path / "folder.glb").mkdir()
    return write_small_files(tmp_path)


def words(files: SmallFiles, outputs: Sequence[str], *more: object) -> list[object]:
    placed = [word for name in outputs for word in ("-o", files[name])]
    pairs = ("--pairs", files["face.pairs.json"], "--set", FEW_SHAPES)
    return ["retarget", files["take.trc"], files["face.glb"], *pairs, *placed, *more]


REFUSED: dict[str, tuple[list[str], list[str], str]] = {
    "a folder that is missing": (["nowhere/o.glb"], [], "does not exist; create it"),
    "an output that is a folder": (["folder.glb"], [], "it is a folder"),
    "an unknown suffix": (["o.xyz"], [], "written to .glb"),
    "a suffix that is only read": (["o.trc"], [], "written to .glb"),
    "the character itself": (["face.glb"], [], "files that are read"),
    "the character by another way": (["folder.glb/../face.glb"], [], "files that are read"),
    "the same file twice": (["o.glb", "o.glb"], [], "written twice"),
    "a report over an output": (["o.csv"], ["--report", "o.csv"], "a report is written to"),
    "a report of another suffix": (["o.glb"], ["--report", "r.pdf"], "a report is written to .html"),
    "a report over the pairs": (["o.glb"], ["--report", "face.pairs.json"], "files that are read"),
    "a report in a missing folder": (["o.glb"], ["--report", "nowhere/r.json"], "does not exist; create it"),
    "an unknown layout": (["o.csv"], ["--csv-format", "excel"], "'excel'. Known: livelink, weights"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_an_output_that_cannot_be_is_refused_before_the_work(
    name: str, files: SmallFiles, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outputs, more, said = REFUSED[name]
    monkeypatch.setattr("mien.job.retarget.run", lambda *_: pytest.fail("the work was begun"))
    before = contents(tmp_path)
    placed = [files[word] if "." in word else word for word in more]
    done = mien(*words(files, outputs, *placed))
    assert (done.code, done.out) == (1, "")
    assert said in done.err
    assert done.err.count("\n") == 1
    assert contents(tmp_path) == before


def test_every_file_that_is_read_is_safe(files: SmallFiles) -> None:
    for option in ("--actor", "--training", "--neutral", "--examples"):
        done = mien(*words(files, ["anim.glb"], option, files["anim.glb"]))
        assert done.code == 1
        assert "files that are read" in done.err


def test_a_failure_while_writing_leaves_nothing(
    files: SmallFiles, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise FileError("the disk is full.")

    files["o.csv"].write_text("stood here before")
    before = contents(tmp_path)
    monkeypatch.setattr("mien.job.account.write_report", full)
    done = mien(*words(files, ["o.glb", "o.csv", "o.gltf"], "--report", files["r.json"]))
    assert (done.code, done.err) == (1, "mien: the disk is full.\n")
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("first", "layout", "said"),
    [
        ("control", "livelink", "ARKit"),
        ("time", "weights", "'time'"),
        ("", "weights", "''"),
        ("two\nlines", "weights", "lines"),
    ],
)
def test_a_layout_that_cannot_hold_the_shapes_leaves_nothing(
    first: str, layout: str, said: str, files: SmallFiles, tmp_path: Path
) -> None:
    rig = face()
    names = (first, *(f"control{i}" for i in range(5)))
    gltf.write_rig(files["face.glb"], replace(rig, blendshapes=Blendshapes(names, rig.blendshapes.deltas)))
    before = contents(tmp_path)
    done = mien(*words(files, ["o.glb", "o.npz", "o.csv"], "--csv-format", layout))
    assert done.code == 1
    assert said in done.err
    assert contents(tmp_path) == before


def test_channels_that_livelink_cannot_hold_are_told(files: SmallFiles) -> None:
    done = mien(*words(files, ["o.csv"], "--csv-format", "livelink", "--json"))
    codes = {note["code"]: note["message"] for note in json.loads(done.out)["warnings"]}
    assert "browUp" in codes["channels-left-out"]
    done = mien("convert", files["weights.csv"], files["c.csv"], "--csv-format", "livelink", "--json")
    assert "channels-left-out" in {note["code"] for note in json.loads(done.out)["warnings"]}
    done = mien("convert", files["weights.csv"], files["d.csv"], "--json")
    assert json.loads(done.out)["warnings"] == []


def test_convert_pairs_and_render_keep_their_inputs_too(files: SmallFiles, tmp_path: Path) -> None:
    before = contents(tmp_path)
    landmarks = files["mesh.landmarks.json"]
    for args in (
        ("convert", files["weights.csv"], files["weights.csv"]),
        ("pairs", files["face.glb"], files["face.glb"], "--landmarks", landmarks, landmarks, "-o", landmarks),
        ("render", files["anim.glb"], "-o", files["anim.glb"]),
        ("convert", files["weights.csv"], files["nowhere/o.npz"]),
        ("pairs", files["face.glb"], files["face.glb"], "-o", files["pairs.txt"]),
        ("render", files["anim.glb"], "-o", files["nowhere/o.png"]),
    ):
        done = mien(*args)
        assert done.code == 1
        assert "cannot write" in done.err
    assert contents(tmp_path) == before


def test_an_output_may_replace_an_earlier_one(files: SmallFiles) -> None:
    files["o.csv"].write_bytes(b"")
    assert mien(*words(files, ["o.csv", "o.glb"])).code == 0
    first = files["o.csv"].read_bytes()
    assert mien(*words(files, ["o.csv", "o.glb"])).code == 0
    assert files["o.csv"].read_bytes() == first != b""
