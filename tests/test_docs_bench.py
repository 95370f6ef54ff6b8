"""The commands of the benchmark's page run, on one small case; and its peers say so when they are absent."""

from __future__ import annotations

import re
import shlex
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.peers.__main__ import PEERS, field
from benchmarks.peers.adapter import Absent
from benchmarks.peers.refined_inverse_rigging import VARIABLE, refined
from benchmarks.peers.solvers import bounded, nonnegative
from benchmarks.peers.squared_l1 import SquaredL1
from mien.cli.app import app
from mien.evaluate.bench import gate, table
from mien.evaluate.bench.figures import FIGURES
from mien.evaluate.embedded import LibraryRecipe, library_case
from mien.retargeting import METHODS
from tests.conftest import ROOT

PAGE = (ROOT / "docs" / "bench.md").read_text(encoding="utf-8")
SHORT = ("rbf", "direct")


def test_the_commands_of_the_page_run_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MIEN_DATA", raising=False)
    monkeypatch.setattr(table, "SCENES", (table.Scene((LibraryRecipe(1),), quick=True),))
    monkeypatch.setattr(table, "library_case", cache(library_case))
    monkeypatch.setattr(table, "METHODS", {name: METHODS[name] for name in SHORT})
    monkeypatch.setattr(table, "VARIANTS", {})
    monkeypatch.setattr(gate, "TRIFLE", 100.0)  # other tests run at the same time: a ratio of times says nothing here
    (tmp_path / "benchmarks" / "results").mkdir(parents=True)
    (tmp_path / "real" / "rigs").mkdir(parents=True)
    blocks = re.findall(r"^```(?:sh)?\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    lines = [line for block in blocks for line in block.splitlines() if line.startswith("mien ")]
    assert len(lines) >= 5
    lines.sort(key=lambda line: "--gate" in line)
    for line in lines:
        here = line.replace("/path/to/real/data", "real")
        done = CliRunner().invoke(app, shlex.split(here)[1:])
        assert done.exit_code == 0, f"{line}\n{done.output}\n{done.exception}"
    assert (tmp_path / "bench.html").stat().st_size > 10_000


def test_the_page_explains_every_figure_and_names_every_method_that_is_given_something() -> None:
    for figure in FIGURES:
        assert re.search(rf"\| [^|]*\b{re.escape(figure.title)}\b[^|]* \|", PAGE), figure.title
    labelled = [name for name, method in METHODS.items() if getattr(method, "by_example", False)]
    for name in (*labelled, "copy", "layers"):
        assert f"`{name}`" in PAGE


def test_absent_peers_are_skipped_with_a_word(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for variable in (VARIABLE, "MIEN_PEER_FACIAL_RETARGETING"):
        monkeypatch.delenv(variable, raising=False)
    with pytest.raises(Absent, match=VARIABLE):
        refined()
    names = [entrant.name for entrant in field([])]
    said = capsys.readouterr().out
    for peer in PEERS:
        assert (peer.name in names) is not (f"{peer.name} (" in said)
    assert VARIABLE in said


def test_peers_that_solve_the_same_problem_agree_where_no_bound_is_reached(rng: np.random.Generator) -> None:
    matrix = rng.normal(size=(40, 5))
    weights = rng.uniform(0.2, 0.8, 5)
    for solve in (nonnegative, bounded):
        np.testing.assert_allclose(solve(matrix, matrix @ weights), weights, atol=1e-6)


def test_a_held_pose_is_held_by_the_consistent_solver_and_sags_in_the_other(rng: np.random.Generator) -> None:
    shapes = rng.normal(size=(4, 30, 3))
    take = np.repeat(np.tensordot([[0.7, 0.0, 0.3, 0.0]], shapes, axes=1), 60, axis=0)
    held, sagging = (SquaredL1(returned)(shapes, take, 30.0) for returned in (100.0, 1.0))
    assert held[-1, 0] == pytest.approx(held[-2, 0], abs=1e-6)
    assert held[-1, 0] > 1.001 * sagging[-1, 0]
    assert (held >= 0).all()
    assert (held <= 1).all()
