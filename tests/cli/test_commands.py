"""Every command explains itself, works on small files, and keeps its promises about output and exit codes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from mien.cli.app import app
from mien.io.formats import read_clip
from mien.retargeting import METHODS
from tests.cli.running import contents, mien
from tests.job.small_files import FRAMES, NAMES, SmallFiles, write_small_files
from tests.retargeting.actors import SHAPES

COMMANDS = sorted(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
DOCUMENTED = {"retarget", "rig", "pairs", "inspect", "convert", "render", "methods", "demo"}


@pytest.fixture
def files(tmp_path: Path) -> SmallFiles:
    return write_small_files(tmp_path)


def job(files: SmallFiles, *outputs: str) -> list[object]:
    placed = [word for name in outputs for word in ("-o", files[name])]
    return ["retarget", files["take.trc"], files["face.glb"], "--pairs", files["face.pairs.json"], *placed]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_explains_itself_with_examples(command: str) -> None:
    done = CliRunner().invoke(app, [command, "--help"], env={"COLUMNS": "200", "TERM": "dumb"})
    assert done.exit_code == 0
    assert "Examples:" in done.output
    assert f"mien {command}" in done.output.split("Examples:")[1]
    assert "--json" in done.output


def test_the_promised_commands_are_there() -> None:
    assert set(COMMANDS) >= DOCUMENTED


@pytest.mark.parametrize(
    "args",
    [
        ["retargt"],
        ["retarget"],
        ["retarget", "a.trc", "b.glb"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--no-such-option"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--count", "three"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--count", "3"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--set", "smooth"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--set", "=1"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--prior", "nope=1"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--exclusive", "a"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--symmetric", "a,,b"],
        ["retarget", "a.trc", "b.glb", "-o", "c.glb", "--bounds", "0"],
        ["pairs", "a.trc", "b.glb", "-o", "c.json", "--neutral", "first"],
        ["render", "a.glb", "-o", "b.png", "--frames", "one,two"],
        ["render", "a.glb", "-o", "b.png", "--size", "5"],
    ],
    ids=" ".join,
)
def test_wrong_usage_is_exit_code_2(args: list[str]) -> None:
    done = mien(*args)
    assert (done.code, done.out) == (2, "")
    assert "Traceback" not in done.err


def test_retarget_writes_every_output_and_says_so(files: SmallFiles) -> None:
    outputs = ("o.glb", "o.gltf", "o.csv", "o.npz")
    done = mien(*job(files, *outputs), "--report", files["r.json"])
    assert done.code == 0
    assert "range-as-performed" in done.err
    for name in (*outputs, "r.json"):
        assert f"wrote {files[name]}" in done.out
    clips = [read_clip(files[name]) for name in outputs]
    for clip in clips:
        assert len(clip) == FRAMES
        np.testing.assert_allclose(clip.channels(SHAPES), clips[-1].channels(SHAPES), atol=1e-6)
    assert json.loads(files["r.json"].read_text())["format"] == "mien-report"


def test_retarget_hears_every_knob(files: SmallFiles) -> None:
    knobs: list[object] = [
        "--method",
        "rbf",
        "--bounds",
        0,
        0.5,
        "--smooth",
        0,
        "--prior",
        "geometric=0.1",
        "--prior",
        "sparsity=0.001",
    ]
    knobs += ["--exclusive", "smile_L,smile_R", "--symmetric", "blink_L, blink_R", "--set", "symmetry=5", "--no-head"]
    done = mien(*job(files, "o.npz"), *knobs, "--json")
    assert done.code == 0
    report, clip = json.loads(done.out), read_clip(files["o.npz"])
    assert report["method"] == "rbf"
    used = {key: report["settings"][key] for key in ("bounds", "smooth", "prior", "sparsity", "symmetry")}
    assert used == {"bounds": [0, 0.5], "smooth": 0, "prior": 0.1, "sparsity": 0.001, "symmetry": 5}
    assert clip.values.min() >= 0
    assert clip.values.max() <= 0.5
    assert clip.head is None
    left, right = clip.channels(("smile_L", "smile_R")).T
    assert not (left * right).any()


@pytest.mark.parametrize("word", ["--quiet", "-q"])
def test_quiet_is_silent_and_does_the_same(word: str, files: SmallFiles) -> None:
    loud = mien(*job(files, "a.csv"))
    done = mien(*job(files, "b.csv"), word)
    assert (done.code, done.out, done.err) == (0, "", "")
    assert files["a.csv"].read_bytes() == files["b.csv"].read_bytes()
    assert loud.out


def test_json_is_one_document_on_stdout(files: SmallFiles) -> None:
    for args in (
        [*job(files, "o.csv"), "--json"],
        ["inspect", files["take.trc"], "--json"],
        ["inspect", files["anim.glb"], "--json"],
        ["inspect", files["mesh.landmarks.json"], "--json"],
        ["convert", files["weights.csv"], files["c.npz"], "--json"],
        ["render", files["anim.glb"], "-o", files["p.png"], "--size", 48, "--count", 2, "--json"],
        ["evaluate", files["weights.csv"], files["weights.csv"], "--json"],
        ["methods", "--json"],
        ["methods", "rbf", "--json"],
        [*pairing(files), "--json"],
    ):
        done = mien(*args)
        assert (done.code, done.err) == (0, ""), args
        json.loads(done.out)


def pairing(files: SmallFiles) -> list[object]:
    landmarks = files["mesh.landmarks.json"]
    return [
        "pairs",
        files["anim.glb"],
        files["face.glb"],
        "--landmarks",
        landmarks,
        landmarks,
        "-o",
        files["made.pairs.json"],
    ]


def test_pairs_that_are_made_can_be_used(files: SmallFiles) -> None:
    made = mien(*pairing(files), "--count", 30)
    assert made.code == 0
    assert " pairs" in made.out
    done = mien(
        "retarget", files["anim.glb"], files["face.glb"], "--pairs", files["made.pairs.json"], "-o", files["o.csv"]
    )
    assert done.code == 0
    clip, truth = read_clip(files["o.csv"]), read_clip(files["weights.csv"])
    assert np.corrcoef(clip.channels(SHAPES).ravel(), truth.channels(SHAPES).ravel())[0, 1] > 0.8


def test_inspect_tells_what_files_hold(files: SmallFiles) -> None:
    take = mien("inspect", files["take.trc"]).out
    assert f"{len(NAMES)} markers, {FRAMES} frames at 60 fps" in take
    assert "no gaps" in take
    face = mien("inspect", files["anim.glb"]).out
    assert "576 vertices" in face
    assert all(shape in face for shape in SHAPES)
    assert f"{FRAMES} frames" in face
    assert "8 landmarks" in mien("inspect", files["mesh.landmarks.json"]).out


def test_inspect_survives_clips_that_are_lost_and_names_that_look_like_markup(files: SmallFiles) -> None:
    path = files["lost.csv"]
    path.write_text("frame,time,[/dim]\n0,0,\n1,0.1,\n")
    done = mien("inspect", path)
    assert done.code == 0
    assert "[/dim] lost" in done.out
    found = json.loads(mien("inspect", path, "--json").out, parse_constant=lambda word: pytest.fail(f"{word} in JSON"))
    assert found["clip"]["channels"] == {"[/dim]": [None, None]}


def test_names_that_look_like_markup_are_printed_as_they_are(files: SmallFiles) -> None:
    files["["].mkdir()
    done = mien("convert", files["weights.csv"], files["[/red].npz"])
    assert done.code == 0
    assert "[/red].npz" in done.out


def test_convert_changes_the_file_and_the_vocabulary(files: SmallFiles) -> None:
    done = mien("convert", files["weights.csv"], files["c.npz"])
    assert done.code == 0
    np.testing.assert_allclose(read_clip(files["c.npz"]).values, read_clip(files["weights.csv"]).values)
    done = mien("convert", files["weights.csv"], files["arkit.csv"], "--to", "arkit")
    assert "no counterpart" in done.err
    arkit = read_clip(files["arkit.csv"])
    assert len(arkit.names) == 52
    np.testing.assert_allclose(arkit.channels(["jawOpen"]), read_clip(files["weights.csv"]).channels(["jawOpen"]))
    assert mien("convert", files["weights.csv"], files["x.csv"], "--to", "klingon").code == 1


@pytest.mark.parametrize("more", [[], ["--frames", "0,50", "--view", "side"]], ids=["telling frames", "named frames"])
def test_render_pictures_an_animated_and_a_still_face(more: list[str], files: SmallFiles) -> None:
    for name in ("anim.glb", "face.glb"):
        done = mien("render", files[name], "-o", files["p.png"], "--size", 48, "--count", 3, *more)
        assert (done.code, done.out) == (0, f"wrote {files['p.png']}\n")
        assert files["p.png"].read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_methods_lists_all_and_the_parameters_of_one(files: SmallFiles) -> None:
    assert [row["name"] for row in json.loads(mien("methods", "--json").out)] == list(METHODS)
    assert all(name in mien("methods").out for name in METHODS)
    assert "steepness" in mien("methods", "range-of-motion").out
    done = mien("methods", "range-of-motoin")
    assert done.code == 1
    assert "Did you mean 'range-of-motion'" in done.err


def test_the_demonstration_writes_what_it_names(tmp_path: Path) -> None:
    out = tmp_path / "new" / "demo"
    done = mien("demo", "--out", out, "--no-film")
    assert (done.code, "Traceback" in done.err) == (0, False)
    named = {line.strip() for line in done.out.split("Look at:")[1].splitlines() if line.strip()}
    main_job = {"report.html", "sheet.png", "animated.glb", "weights.csv"}
    rigged = {"goat_rigged.glb", "goat_rigged.png"}
    spoken = {"sentence.png", "globe_speaks.glb", "radio_speaks.glb"}
    assert named == {str(out / name) for name in main_job | rigged | spoken}
    assert all(Path(name).stat().st_size > 1000 for name in named)
    assert mien("demo", "--out", out / "weights.csv").code == 1


def test_a_process_of_its_own_keeps_the_exit_codes(files: SmallFiles, tmp_path: Path) -> None:
    def process(*words: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "mien", *map(str, words)]
        return subprocess.run(command, capture_output=True, text=True, encoding="utf-8", timeout=120, check=False)

    done = process("inspect", files["take.trc"], "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["markers"]["frames"] == FRAMES
    before = contents(tmp_path)
    failed = process(*job(files, "nowhere/o.glb"))
    assert (failed.returncode, failed.stdout) == (1, "")
    assert failed.stderr.startswith("mien: cannot write")
    assert failed.stderr.count("\n") == 1
    assert contents(tmp_path) == before
    assert process("retarget").returncode == 2
