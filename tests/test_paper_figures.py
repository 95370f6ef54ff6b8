"""The figures of the rig-transfer paper can be made from nothing but what comes with the product."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.paper_figures.rig_transfer.attributes import attributes
from benchmarks.paper_figures.rig_transfer.correspondence import measure
from benchmarks.paper_figures.rig_transfer.drawing import distinct, heat, line
from benchmarks.paper_figures.rig_transfer.faces import Settings


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    return Settings(tmp_path, None, True, tmp_path)


def test_the_attributes_are_pictured_and_their_weights_sum_to_one(
    settings: Settings, capsys: pytest.CaptureFixture[str]
) -> None:
    attributes(settings)
    assert "cartoon" in capsys.readouterr().out
    assert (settings.out / "attributes.png").stat().st_size > 10_000
    rows = json.loads((settings.results / "rig_transfer_attributes.json").read_text(encoding="utf-8"))["rows"]
    assert {row["face"] for row in rows} == {"actor", "cartoon", "goat"}
    assert all(row["sums off by"] < 1e-12 for row in rows)


@pytest.mark.parametrize("landmarks", ["10", "all"])
def test_landmarks_are_met_and_stuck_vertices_lie_on_the_face(settings: Settings, landmarks: str) -> None:
    row = measure("cartoon", landmarks, settings)
    assert row["warp misses"] <= 1e-9
    assert row["stuck misses"] <= 1e-9
    assert row["off the surface"] <= 1e-9
    assert row["landmarks"] == (10 if landmarks == "10" else 44)


def test_a_line_has_no_gaps_wider_than_its_step_and_ends_where_it_should() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0.35, 0]])
    points = line(corners, 0.1)
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() <= 0.1 + 1e-12
    np.testing.assert_array_equal(points[[0, -1]], corners[[0, -1]])


def test_heat_runs_from_red_to_blue_and_labels_get_colours_of_their_own() -> None:
    ends = heat(np.array([0.0, 1.0]))
    assert ends[0, 0] > ends[0, 2]
    assert ends[1, 0] < ends[1, 2]
    colours = distinct(24)
    apart = np.linalg.norm(colours[:, None] - colours[None], axis=2) + np.eye(24)
    assert apart.min() > 0.05
    assert colours.min() >= 0
    assert colours.max() <= 1
