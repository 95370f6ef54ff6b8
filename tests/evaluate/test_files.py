"""`mien evaluate`: one file against another."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mien.core import Clip
from mien.io.formats import write_clip
from tests.cli.running import mien
from tests.job.small_files import write_small_files
from tests.retargeting.actors import SHAPES, weights


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_small_files(tmp_path)
    values = weights(60)
    write_clip(tmp_path / "truth.csv", Clip(SHAPES, values, 30.0))
    write_clip(tmp_path / "weak.csv", Clip(SHAPES, 0.5 * values, 30.0))
    return tmp_path


def figures(*words: object) -> dict[str, object]:
    outcome = mien("evaluate", *words, "--json")
    assert outcome.code == 0, outcome.err
    return json.loads(outcome.out)  # type: ignore[no-any-return]


def test_a_result_of_half_strength_has_a_gain_of_a_half(folder: Path) -> None:
    found = figures(folder / "weak.csv", folder / "truth.csv")
    assert found["gain"] == pytest.approx(0.5, abs=1e-3)
    assert found["correlation"] == pytest.approx(1, abs=1e-3)
    assert "vertex_mm" not in found


def test_with_the_character_errors_are_in_millimetres(folder: Path) -> None:
    weak = figures(folder / "weak.csv", folder / "truth.csv", "--character", folder / "face.glb")
    right = figures(folder / "truth.csv", folder / "truth.csv", "--character", folder / "face.glb")
    assert weak["vertex_mm"] > 0.1
    assert right["vertex_mm"] == 0


def test_without_json_it_prints_a_table(folder: Path) -> None:
    outcome = mien("evaluate", folder / "weak.csv", folder / "truth.csv")
    assert outcome.code == 0
    assert "gain" in outcome.out
    assert "0.500" in outcome.out


def test_lost_frames_are_left_out_and_counted(folder: Path) -> None:
    values = weights(60)
    values[5:9] = np.nan
    write_clip(folder / "lost.npz", Clip(SHAPES, values, 30.0))
    found = figures(folder / "truth.csv", folder / "lost.npz")
    assert found["frames"] == 56
    assert [note["code"] for note in found["warnings"]] == ["frames-left-out"]


def test_absent_shapes_count_as_nothing_and_are_named(folder: Path) -> None:
    write_clip(folder / "few.csv", Clip(SHAPES[:3], weights(60)[:, :3], 30.0))
    found = figures(folder / "few.csv", folder / "truth.csv")
    assert found["rmse"] > 0
    assert SHAPES[3] in found["warnings"][0]["message"]


def test_takes_of_different_length_are_refused(folder: Path) -> None:
    write_clip(folder / "short.csv", Clip(SHAPES, weights(60)[:40], 30.0))
    outcome = mien("evaluate", folder / "short.csv", folder / "truth.csv")
    assert outcome.code == 1
    assert "40 frames" in outcome.err


def test_clips_that_share_no_name_are_refused(folder: Path) -> None:
    write_clip(folder / "other.csv", Clip(("wag",), np.ones((60, 1)), 30.0))
    outcome = mien("evaluate", folder / "other.csv", folder / "truth.csv")
    assert outcome.code == 1
    assert "wag" in outcome.err
