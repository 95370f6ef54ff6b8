"""`mien rig` as a user types it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.io import gltf
from mien.io.formats import read_clip, read_rig
from mien.library.heads import HEADS
from tests.cli.running import mien


@pytest.fixture(scope="module")
def goat(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("goat") / "goat.glb"
    gltf.write_rig(path, HEADS["goat"]())
    return path


def test_a_bare_face_becomes_a_rigged_one(goat: Path, tmp_path: Path) -> None:
    out, account = tmp_path / "rigged.glb", tmp_path / "account.json"
    done = mien("rig", "builtin", goat, "-o", out, "--report", account, "--json")
    assert done.code == 0, done.err
    told = json.loads(done.out)
    assert told == json.loads(account.read_text())
    rig, face = read_rig(out), read_rig(goat)
    assert np.allclose(
        rig.neutral.vertices[: len(face.neutral.vertices)], face.neutral.vertices, atol=1e-7
    )  # through float32 bind matrices
    assert {"jawOpen", "eyeBlinkLeft", "ecstasy", "viseme_PP", "blink_closed"} <= set(rig.blendshapes.names)
    assert rig.skeleton is not None
    assert {"head", "jaw", "eye_left", "eye_right"} <= set(rig.skeleton.names)
    assert rig.anatomy is not None
    assert len(rig.anatomy.muscles) > 11
    assert read_clip(out).values.max() > 0.5
    assert told["animations"] == ["sentence", "range_of_motion"]


def test_only_the_shapes_asked_for_are_made(goat: Path, tmp_path: Path) -> None:
    out = tmp_path / "rigged.glb"
    assert mien("rig", "builtin", goat, "-o", out, "--shapes", "blinks", "-q").code == 0
    assert read_rig(out).blendshapes.names == ("blink_open", "blink_half", "blink_closed")


def test_what_is_missing_is_named(goat: Path, tmp_path: Path) -> None:
    blank = tmp_path / "blank.glb"
    gltf.write_rig(blank, replace(HEADS["goat"](), landmarks={}))
    for words, expected in (
        (("builtin", blank, "-o", tmp_path / "x.glb"), "has no landmarks"),
        (("builtin", goat, "-o", goat), "one of the files that are read"),
        (("builtin", goat, "-o", tmp_path / "x.csv"), ".glb"),
        (("builtin", goat, "-o", tmp_path / "x.glb", "--shapes", "smiles"), "arkit"),
        (("builtin", goat, "-o", tmp_path / "x.glb", "--method", "magic"), "warp-and-stick"),
    ):
        done = mien("rig", *words)
        assert (done.code, "Traceback" in done.err) == (1, False)
        assert expected in done.err
    assert not (tmp_path / "x.glb").exists()
