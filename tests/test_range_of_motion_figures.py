"""The figures of the range-of-motion paper can be made from nothing but what comes with the product."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks.paper_figures.range_of_motion.mouths import SUBTLE, subtle
from benchmarks.paper_figures.range_of_motion.performers import acted, cases, frames_of, name_of, unlikeness
from benchmarks.paper_figures.range_of_motion.similarity import likeness
from benchmarks.paper_figures.rig_transfer.faces import Settings
from mien.evaluate import Case


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> Settings:
    folder = tmp_path_factory.mktemp("figures")
    return Settings(folder, None, True, folder)


@pytest.fixture(scope="module")
def case(settings: Settings) -> Case:
    (only,) = cases(settings)
    return only


def test_without_real_heads_the_cartoon_takes_the_stage(case: Case) -> None:
    assert name_of(case) == "cartoon"
    assert 0.05 < unlikeness(case) < 0.5
    assert acted(case).shape == (len(case.test), len(case.actor.blendshapes))


def test_the_frames_that_are_shown_are_strong_and_differ(case: Case) -> None:
    frames = frames_of(case, 3)
    values = np.asarray(case.truth_range.values)
    assert len(set(frames.tolist())) == 3
    assert np.linalg.norm(values[frames], axis=1).min() > np.median(np.linalg.norm(values, axis=1))


def test_subtle_frames_have_a_mouth_shape_that_is_a_little_active(case: Case) -> None:
    frames = subtle(case)
    assert 0 < len(frames) < len(case.test)
    mouth = [k for k, name in enumerate(case.character.blendshapes.names) if name.startswith(("mouth", "jaw"))]
    strongest = np.asarray(case.truth_range.values)[frames][:, mouth].max(axis=1)
    assert strongest.min() > SUBTLE[0]


def test_contrast_decides_and_key_expressions_are_pictured(
    settings: Settings, capsys: pytest.CaptureFixture[str]
) -> None:
    likeness(settings)
    assert "cartoon" in capsys.readouterr().out
    (row,) = json.loads((settings.results / "range_of_motion_similarity.json").read_text(encoding="utf-8"))["rows"]
    assert row["undecided, enhanced"] < row["undecided, raw"]
    assert 0 < row["keys"] < row["frames"]
    for name in ("figure7-cartoon-raw", "figure7-cartoon-enhanced", "figure8-cartoon"):
        assert (settings.out / f"{name}.png").stat().st_size > 5_000
