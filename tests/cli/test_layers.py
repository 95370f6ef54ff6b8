"""The layers from the command line: extremes in, curves out, curves edited, character composed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mien.io.formats import read_clip, read_rig
from tests.cli.running import contents, mien
from tests.job.layered_files import MASKS, NAMES, write_layered_files


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_layered_files(tmp_path_factory.mktemp("layers"))


def test_a_performance_goes_out_as_curves_and_comes_back(files: Path, tmp_path: Path) -> None:
    out, curves, again = tmp_path / "out.glb", tmp_path / "curves.csv", tmp_path / "again.glb"
    done = mien(
        "retarget", files / "actor.glb", files / "hero.glb", "--method", "layers", "-o", out, "--layers", curves, "-q"
    )
    assert (done.code, done.err) == (0, "")
    words = [word for mask in MASKS for word in ("--mask", mask)]
    done = mien("compose", files / "hero.glb", curves, "-o", again, "-o", tmp_path / "again.csv", "-q")
    assert (done.code, done.err) == (0, "")
    assert np.abs(read_clip(again).channels(NAMES) - read_clip(out).channels(NAMES)).max() < 1e-5
    split = [name for name in read_rig(out).blendshapes.names if "@" in name]
    assert read_rig(out).blendshapes.names == (*NAMES, *split)
    assert read_clip(out).channels(split).max() > 0.5
    assert np.abs(read_clip(again).channels(split) - read_clip(out).channels(split)).max() < 1e-5
    assert read_clip(tmp_path / "again.csv").names == NAMES
    done = mien("compose", files / "hero.glb", curves, *words, "-o", again, "-q")
    assert (done.code, done.err) == (0, "")
    assert "speech.viseme_aa@hero/mouth" not in read_rig(again).blendshapes.names


def test_a_split_character_has_a_shape_for_each_extreme_and_region(files: Path, tmp_path: Path) -> None:
    curves, split = tmp_path / "curves.csv", tmp_path / "split.glb"
    mien(
        "retarget",
        files / "actor.glb",
        files / "hero.glb",
        "--method",
        "layers",
        "-o",
        tmp_path / "o.csv",
        "--layers",
        curves,
    )
    done = mien("compose", files / "hero.glb", curves, "-o", split, "--json")
    account = json.loads(done.out)
    whole = read_rig(split).blendshapes.names
    names = [name for name in whole if "@" in name]
    assert (account["shapes"], account["split_shapes"]) == (len(NAMES), len(names))
    assert whole == (*NAMES, *names)
    assert {name.partition("@")[0] for name in names} == {
        *("emotion.joy", "emotion.surprise", "speech.viseme_PP", "speech.viseme_aa", "blink.blink_closed")
    }
    again = mien("compose", split, curves, "-o", tmp_path / "again.csv", "--json")
    assert json.loads(again.out)["loss_mm"] < 0.01


def test_a_model_fitted_to_picked_frames_maps_takes(files: Path, tmp_path: Path) -> None:
    given = ("--method", "layers", "--extremes", files / "extremes.csv")
    model = tmp_path / "hero.mien"
    assert mien("fit", files / "rom.trc", files / "hero.glb", *given, "-o", model).code == 0
    done = mien(
        "retarget",
        files / "take.trc",
        model,
        "-o",
        tmp_path / "later.csv",
        "--layers",
        tmp_path / "later_curves.csv",
        "-q",
    )
    assert (done.code, done.err) == (0, "")
    whole = ("--training", files / "rom.trc", "-o", tmp_path / "now.csv", "--layers", tmp_path / "now_curves.csv")
    assert mien("retarget", files / "take.trc", files / "hero.glb", *given, *whole).code == 0
    for kind in ("", "_curves"):
        assert (tmp_path / f"later{kind}.csv").read_bytes() == (tmp_path / f"now{kind}.csv").read_bytes()


REFUSED: dict[str, tuple[tuple[str, ...], str]] = {
    "an unknown layer": (("--gain", "dance=0"), "unknown layer 'dance'"),
    "a gain that is no number": (("--gain", "blink=loud"), "does not end in a number"),
    "a gain below 0": (("--gain", "blink=-1"), "at least 0"),
    "no speed": (("--speed", "0"), "speed must be above 0"),
    "an unknown mask": (("--mask", "wings"), "wings"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_composed_is_refused_in_one_line(name: str, files: Path, tmp_path: Path) -> None:
    curves = files / "curves.csv"
    if not curves.exists():
        mien(
            "retarget",
            files / "actor.glb",
            files / "hero.glb",
            "--method",
            "layers",
            "-o",
            files / "o.csv",
            "--layers",
            curves,
        )
    words, said = REFUSED[name]
    done = mien("compose", files / "hero.glb", curves, "-o", tmp_path / "no.glb", *words)
    assert done.code != 0
    assert said in " ".join(done.err.split())
    assert "Traceback" not in done.err
    assert contents(tmp_path) == {}
