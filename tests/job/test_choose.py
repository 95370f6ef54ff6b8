"""`--method auto`."""

from __future__ import annotations

from pathlib import Path

import pytest

from mien.core import FileError
from mien.io.formats import read_rig
from mien.job.choose import AUTO, OTHERWISE, RULES, chosen
from mien.job.request import Request
from mien.job.retarget import run
from mien.retargeting import METHODS
from tests.job.layered_files import write_layered_files

NOWHERE = Path("nowhere.glb")


def test_a_named_method_is_left_alone(files):
    request = Request(files["weights.csv"], NOWHERE, "rbf")
    assert chosen(request) == (request, ())


@pytest.mark.parametrize(
    ("given", "method"),
    [
        ({"extremes": Path("rom.csv")}, "layers"),
        ({"examples": Path("labels.csv")}, "latent"),
        ({"animations": (Path("idle.csv"),)}, "latent"),
        ({}, "copy"),
    ],
)
def test_what_is_given_decides_before_the_character_is_read(files, given, method):
    request, notes = chosen(Request(files["weights.csv"], NOWHERE, AUTO, **given))
    assert request.method == method
    assert [(note.code, note.where) for note in notes] == [("method-chosen", method)]


@pytest.mark.parametrize("performance", ["take.trc", "anim.glb"])
def test_a_character_with_shapes_of_its_own_gets_range_of_motion(files, performance):
    assert chosen(Request(files[performance], files["face.glb"], AUTO))[0].method == "range-of-motion"


def test_weights_with_the_actor_s_face_are_points(files):
    request = Request(files["weights.csv"], files["face.glb"], AUTO, actor=files["face.glb"])
    assert chosen(request)[0].method == "range-of-motion"


@pytest.mark.parametrize(
    ("column", "paired", "method"),
    [("jawOpen", True, "range-of-motion"), ("jawOpen", False, "latent"), ("slider", True, "latent")],
)
def test_labelled_blendshapes_get_range_of_motion_where_points_are_paired(files, tmp_path, column, paired, method):
    labels = tmp_path / "labels.csv"
    labels.write_text(f"frame,{column}\n3,1\n", encoding="utf-8")
    pairs = files["face.pairs.json"] if paired else None
    request = Request(files["take.trc"], files["face.glb"], AUTO, examples=labels, pairs=pairs)
    assert chosen(request)[0].method == method


def test_a_character_made_of_expressions_gets_layers(tmp_path):
    folder = write_layered_files(tmp_path)
    assert chosen(Request(folder / "take.trc", folder / "hero.glb", AUTO))[0].method == "layers"


def test_a_missing_character_is_named(files):
    with pytest.raises(FileError, match="nowhere"):
        chosen(Request(files["take.trc"], NOWHERE, AUTO))


def test_the_reason_reaches_the_report(files):
    request = Request(files["take.trc"], files["face.glb"], AUTO, pairs=files["face.pairs.json"])
    notes = run(request).report.notes
    assert [note.where for note in notes if note.code == "method-chosen"] == ["range-of-motion"]


def test_every_rule_names_a_method():
    assert {OTHERWISE[0], *(name for _, name, _ in RULES)} <= set(METHODS)


def test_the_character_is_read_once_even_if_choosing_looks_at_it(files, monkeypatch):
    seen = []
    monkeypatch.setattr("mien.job.learn.read_rig", lambda path: seen.append(path) or read_rig(path))
    run(Request(files["take.trc"], files["face.glb"], AUTO, pairs=files["face.pairs.json"]))
    assert seen == [files["face.glb"]]
