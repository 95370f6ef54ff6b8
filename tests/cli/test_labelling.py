"""Labelling from the command line: label, fit, suggest, pose."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mien.core import Examples
from mien.io.examples import read_examples, write_examples
from tests.cli.running import mien
from tests.job.small_files import FRAMES, SmallFiles, write_small_files
from tests.retargeting.actors import SHAPES, weights


@pytest.fixture
def files(tmp_path: Path) -> SmallFiles:
    found = write_small_files(tmp_path)
    frames = np.arange(3, FRAMES, 9)
    write_examples(found["labels.csv"], Examples(frames, SHAPES, weights(FRAMES)[frames]))
    return found


def fitted(files: SmallFiles, method: str = "latent") -> Path:
    done = mien(
        *("fit", files["take.trc"], files["face.glb"], "--method", method, "--examples", files["labels.csv"]),
        *("-o", files["m.mien"], "-q"),
    )
    assert (done.code, done.out, done.err) == (0, "", "")
    return files["m.mien"]


def test_labelling_is_a_round(files: SmallFiles) -> None:
    done = mien("label", files["take.trc"], files["face.glb"], "-o", files["work"], "--count", 3)
    assert done.code == 0
    assert "3 frames to label" in done.out
    model = fitted(files)
    done = mien("suggest", files["take.trc"], model, "--count", 2, "--json")
    found = json.loads(done.out)["frames"]
    assert [set(row) for row in found] == [{"frame", "time", "gain"}] * 2
    done = mien("label", files["take.trc"], model, "-o", files["more"], "--count", 2, "--json")
    told = json.loads(done.out)
    assert told["predicted"] is True
    assert told["frames"] == [row["frame"] for row in found]
    assert set(told["frames"]) < set(read_examples(files["more"] / "labels.csv").frames.tolist())


def test_a_pose_is_printed_and_written(files: SmallFiles) -> None:
    model = fitted(files)
    done = mien("pose", files["face.glb"], model, "--set", "jawOpen=.6", "-o", files["pose.csv"])
    assert done.code == 0
    assert "jawOpen" in done.out
    assert files["pose.csv"].exists()
    done = mien("pose", files["face.glb"], model, "--set", "jawOpen=.6", "--json")
    assert json.loads(done.out)["parameters"]["jawOpen"] == 0.6


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("pose", "face.glb", "m.mien", "--set", "jawOpne=1"), "Did you mean 'jawOpen'"),
        (("pose", "face.glb", "m.mien", "--set", "jawOpen=1", "-o", "x.txt"), "a pose is written to"),
        (("suggest", "weights.csv", "m.mien"), "fitted to markers"),
        (("suggest", "take.trc", "m.mien", "--count", "900"), "ask for 1 …"),
        (("suggest", "take.trc", "cut.mien"), "not a readable mien-model"),
        (("retarget", "take.trc", "face.glb", "--method", "latent", "-o", "x.csv"), "--examples"),
        (("retarget", "take.trc", "face.glb", "--animation", "weights.csv", "-o", "x.csv"), "--method latent"),
    ],
)
def test_mistakes_are_explained(files: SmallFiles, words: tuple[str, ...], why: str) -> None:
    model = fitted(files, "ridge" if words[0] == "suggest" else "latent")
    files["cut.mien"].write_bytes(model.read_bytes()[:-900])
    placed = [files[word] if "." in word and "=" not in word else word for word in words]
    done = mien(*placed)
    assert done.code == 1
    assert why in " ".join(done.err.split())
