"""The benchmark and its gate, on one small case."""

from __future__ import annotations

import copy
import json
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from mien.cli.app import app
from mien.core import FileError, InputError
from mien.evaluate.bench import table
from mien.evaluate.bench.cell import STRONGEST, Witness, measure
from mien.evaluate.bench.document import begun, extended, lacking, read, write
from mien.evaluate.bench.figures import BY_KEY, FIGURES, spread_of
from mien.evaluate.bench.gate import gate
from mien.evaluate.bench.memory import STATUS, Peak
from mien.evaluate.bench.run import REFERENCE, run
from mien.evaluate.bench.table import SCENES, Entrant, Scene, entrants, rows, scenes
from mien.evaluate.embedded import LibraryRecipe, library_case
from mien.retargeting import METHODS
from mien.retargeting.method import Method

TINY = Scene((LibraryRecipe(1),), quick=True)
FEW = ("rbf", "direct", "ridge")
Document = dict[str, Any]


def ran(methods: tuple[str, ...]) -> Document:
    """What a run of methods on the one case writes."""
    document = begun("test")
    for scened in run([TINY], entrants(methods)):
        document = extended(document, scened, 1.0)
    return json.loads(json.dumps(document))


@pytest.fixture(scope="module", autouse=True)
def one_case() -> Iterator[None]:
    """Make the case once: it is the same for every run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(table, "library_case", cache(library_case))
        yield


@pytest.fixture(scope="module")
def found(one_case: None) -> Document:
    """What a run of a few methods on one case writes."""
    return ran(FEW)


@pytest.fixture
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table, "SCENES", (TINY,))


def test_every_method_has_a_row_in_every_scene() -> None:
    every = rows(SCENES, entrants())
    assert len(set(every)) == len(every)
    assert {row.method for row in every} >= set(METHODS)
    assert len(every) == len(SCENES) * len(entrants())


def test_the_quick_suite_is_part_of_the_full_one_and_needs_no_data() -> None:
    quick = scenes(full=False, real=False)
    assert quick
    assert not any(scene.real for scene in quick)
    assert set(quick) < set(scenes(full=True, real=False)) < set(scenes(full=True, real=True))
    assert all(len(scene.identities) >= 3 for scene in quick)


def test_unknown_methods_and_cases_are_errors_that_list_what_there_is() -> None:
    with pytest.raises(InputError, match="rbf"):
        entrants(["rfb"])
    with pytest.raises(InputError, match="cartoon"):
        scenes(full=False, real=False, words=["nobody"])


def test_each_figure_of_a_cell_is_a_number_and_labels_are_named(found: Document) -> None:
    by_method = {row["method"]: row for row in found["rows"]}
    assert set(by_method) == set(FEW)
    for row in found["rows"]:
        assert set(row["figures"]) >= {f.key for f in FIGURES} - {"fit_mm", "memory_mb"}
        assert row["figures"]["frame_ms"]["mean"] > 0
    assert by_method["ridge"]["given"] == "20 labels"
    assert by_method["rbf"]["time_ratio"] == 1
    assert found["reference"] == REFERENCE


def test_the_spread_over_identities_has_the_worst_on_the_bad_side() -> None:
    assert spread_of(BY_KEY["vertex_mm"], [1.0, 3.0, float("nan"), None]) == (2.0, 1.0, 3.0)
    assert spread_of(BY_KEY["correlation"], [0.5, 0.9]).worst == 0.5
    assert spread_of(BY_KEY["gain"], [0.8, 1.1]).worst == 0.8
    assert np.isnan(spread_of(BY_KEY["gain"], [None]).mean)


def test_a_run_repeats_exactly_and_passes_its_own_gate(found: Document) -> None:
    again = ran(("rbf", "ridge"))
    before = {row["method"]: row for row in found["rows"]}
    for row in again["rows"]:
        assert row["absolute"] == before[row["method"]]["absolute"]
    verdict = gate(found, found)
    assert not verdict.regressions
    assert verdict.rows == len(FEW)
    assert verdict.timed


@pytest.mark.parametrize(
    ("key", "factor"), [("rmse", 0.97), ("correlation", 1.02), ("vertex_mm", 0.9), ("crossings", 0.9)]
)
def test_the_gate_fails_where_a_figure_was_better(found: Document, key: str, factor: float) -> None:
    better = copy.deepcopy(found)
    better["rows"][0]["figures"][key]["mean"] *= factor
    (worse,) = gate(found, better).regressions
    assert (worse.method, worse.figure) == (FEW[0], f"{BY_KEY[key].title}, mean")
    assert worse.was is not None
    assert worse.now is not None
    assert not gate(better, found).regressions


def test_the_gate_forgives_half_a_percent(found: Document) -> None:
    better = copy.deepcopy(found)
    for row in better["rows"]:
        row["figures"]["vertex_mm"]["mean"] *= 0.995
    assert not gate(found, better).regressions


def test_the_gate_sees_a_gain_that_left_one_on_either_side(found: Document) -> None:
    right = copy.deepcopy(found)
    for row in right["rows"]:
        row["figures"]["gain"]["mean"] = 1.0
    for gain in (0.97, 1.03):
        now = copy.deepcopy(right)
        now["rows"][1]["figures"]["gain"]["mean"] = gain
        assert [bad.figure for bad in gate(now, right).regressions] == ["gain, mean"]


def test_the_gate_sees_times_only_beyond_the_factor(found: Document) -> None:
    for slower, fails in ((1.8, False), (4.0, True)):
        now = copy.deepcopy(found)
        now["rows"][1]["time_ratio"] = slower * found["rows"][1]["time_ratio"]
        assert bool(gate(now, found).regressions) is fails


def test_a_row_that_is_gone_or_fails_is_a_regression_unless_the_run_was_filtered(found: Document) -> None:
    short = copy.deepcopy(found)
    gone = short["rows"].pop()
    assert [bad.method for bad in gate(short, found).regressions] == [gone["method"]]
    assert not gate(short, found, whole=False).regressions
    failing = copy.deepcopy(found)
    failing["rows"][0] |= {"failed": "no lips", "figures": {}, "absolute": {}}
    assert "no lips" in gate(failing, found).regressions[0].figure
    assert not gate(found, failing).regressions


def test_a_document_is_read_back_and_another_file_is_refused(found: Document, tmp_path: Path) -> None:
    write(tmp_path / "bench.json", found)
    assert read(tmp_path / "bench.json") == found
    for text in ("not json", "{}", '{"format": "mien-bench", "version": 1, "rows": [{}]}'):
        (tmp_path / "other.json").write_text(text, encoding="utf-8")
        with pytest.raises(FileError, match="mien bench"):
            read(tmp_path / "other.json")


@pytest.mark.usefixtures("tiny")
def test_the_command_writes_both_files_and_fails_against_a_perturbed_baseline(tmp_path: Path) -> None:
    figures, page = tmp_path / "bench.json", tmp_path / "bench.html"
    options = ["bench", "--embedded", "--methods", "rbf,direct"]
    done = CliRunner().invoke(app, [*options, "--json", str(figures), "--html", str(page)])
    assert done.exit_code == 0, done.output
    assert "acting > cartoon" in done.output
    text = page.read_text(encoding="utf-8")
    assert text.count("data:image/png") == 1
    assert not re.search(r"""(src|href|url)\s*[=(]\s*["']?https?:""", text)
    baseline = read(figures)
    baseline["rows"][1]["figures"]["vertex_mm"]["mean"] *= 0.9
    write(figures, baseline)
    failed = CliRunner().invoke(app, [*options, "--gate", str(figures), "-q"])
    assert failed.exit_code == 1
    assert "direct" in failed.output
    assert "mm, mean" in failed.output


def test_a_run_that_was_stopped_goes_on_where_it_was(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    other = Scene((LibraryRecipe(2),), quick=True)
    monkeypatch.setattr(table, "SCENES", (TINY, other))
    path, options = tmp_path / "bench.json", ["bench", "--embedded", "--methods", "rbf,direct", "-q"]
    scene = iter(run([TINY, other], entrants(("rbf", "direct"))))
    name = "quick suite, embedded data"
    stopped = extended(begun(name), next(scene), 5.0)
    write(path, stopped)
    assert lacking(stopped, [TINY, other], entrants(("rbf", "direct"))) == (other,)
    assert lacking(stopped, [TINY, other], entrants(("rbf", "ridge"))) == (TINY, other)
    done = CliRunner().invoke(app, [*options, "--json", str(path), "--resume"])
    assert done.exit_code == 0, done.output
    whole = read(path)
    assert [row["identities"] for row in whole["rows"]] == [
        [r.actor] for r in (*TINY.recipes, *other.recipes) for _ in "ab"
    ]
    assert whole["rows"][:2] == stopped["rows"]
    assert whole["seconds"] > 5
    write(path, stopped | {"suite": "another"})
    assert isinstance(CliRunner().invoke(app, [*options, "--json", str(path), "--resume"]).exception, InputError)
    assert isinstance(CliRunner().invoke(app, [*options, "--resume"]).exception, InputError)


@pytest.mark.usefixtures("tiny")
def test_a_place_that_cannot_be_written_is_refused_before_anything_runs(tmp_path: Path) -> None:
    for option, name in (("--json", "bench.txt"), ("--html", "nowhere/bench.html")):
        done = CliRunner().invoke(app, ["bench", "--embedded", option, str(tmp_path / name)])
        assert isinstance(done.exception, FileError | InputError)


def test_a_method_that_cannot_play_says_why_and_does_not_stop_the_others() -> None:
    class Refuses:
        name = "refuses"

        def fit(self, *_: object, **__: object) -> None:
            raise InputError("no such lips")

    refuses: Method = Refuses()  # type: ignore[assignment]
    (scened,) = run([TINY], [Entrant("refuses", refuses), Entrant("rbf", "rbf")])
    assert [line.failed for line in scened.lines] == ["no such lips", ""]
    assert set(scened.poses) == {"rbf"}


def test_strongest_frames_lie_apart_and_the_truth_has_its_own_crossings_there() -> None:
    ((_, case),) = TINY.cases(None)
    witness = Witness.of(case)
    assert len(witness.frames) == STRONGEST
    assert np.diff(witness.frames).min() >= 0.4 * case.test.fps
    played = measure(witness, Entrant("true", lambda _: case.shapes("range")), "a1")  # type: ignore[arg-type]
    assert not played.failed
    assert witness.crossings >= 0


@pytest.mark.skipif(not STATUS.exists(), reason="only Linux tells")
def test_the_peak_of_memory_is_what_was_taken_and_given_back() -> None:
    peak = Peak()
    taken = np.ones(6_000_000)
    size = taken.nbytes / 2**20
    del taken
    assert sys.platform == "linux"
    assert peak.above() == pytest.approx(size, rel=0.25)
