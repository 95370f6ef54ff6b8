"""What a take shows of a character is said as it is, from points and from weights."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from mien.core import Clip, InputError
from mien.io import trc, weights
from mien.io.formats import read_clip, read_markers, read_rig
from mien.job.coverage import Coverage, coverage
from mien.job.request import Request
from tests.cli.running import mien
from tests.job.small_files import FRAMES, SmallFiles, capture_of, marker_pairs
from tests.retargeting.actors import SHAPES
from tests.retargeting.actors import weights as played


def verdicts(found: Coverage) -> dict[str, str]:
    return {shape.name: shape.verdict for shape in found.shapes}


def test_a_shape_left_out_is_not_shown_and_one_that_only_accompanies_another_weakly(files: SmallFiles) -> None:
    values = played(FRAMES)
    values[:, 0] = 0
    values[:, 1] = 0.3 * values[:, 2] / values[:, 2].max()
    files.take(capture_of(values))
    found = verdicts(coverage(files["take.trc"], files["face.glb"], pairs=files["face.pairs.json"]))
    assert found[SHAPES[0]] == "not shown"
    assert found[SHAPES[1]] == "shown weakly"
    assert sum(verdict == "shown well" for verdict in found.values()) == len(SHAPES) - 2


def test_what_the_take_lacks_comes_first(files: SmallFiles) -> None:
    values = played(FRAMES)
    values[:, 3] = 0
    files.take(capture_of(values))
    shapes = coverage(files["take.trc"], files["face.glb"], pairs=files["face.pairs.json"]).shapes
    assert shapes[0].name == SHAPES[3]
    assert all(a.reached <= b.reached for a, b in pairwise(shapes) if a.verdict == b.verdict)


def test_a_shape_beside_all_points_cannot_be_seen(files: SmallFiles) -> None:
    reach = np.linalg.norm(read_rig(files["face.glb"]).blendshapes.deltas[0], axis=1)
    far = [row for row in marker_pairs() if reach[row["target"]] < 0.4 * reach.max()]
    assert len(far) >= 12
    found = verdicts(coverage(files["take.trc"], files["face.glb"], pairs=files.pairs(far)))
    assert found[SHAPES[0]] == "cannot be seen"


def test_bare_weights_are_judged_channel_by_channel_without_their_lost_rows(tmp_path: Path) -> None:
    values = np.zeros((200, 3))
    values[:, 0], values[50:, 1], values[:1, 2] = 0.3, 0.9, 1.0
    values[10:20] = np.nan
    path = tmp_path / "take.csv"
    weights.write_clip(path, Clip(("jawOpen", "eyeBlinkLeft", "tongueOut"), values, 30.0))
    found = coverage(path)
    assert verdicts(found) == {"tongueOut": "not shown", "jawOpen": "shown weakly", "eyeBlinkLeft": "shown well"}
    assert all(shape.correlation is None for shape in found.shapes)
    assert found.shapes[-1].second == pytest.approx(50 / 30, abs=0.01)


def test_weights_beside_a_character_are_judged_by_its_shapes(files: SmallFiles) -> None:
    clip = read_clip(files["weights.csv"])
    weights.write_clip(files["few.csv"], replace(clip, names=clip.names[1:], values=clip.values[:, 1:]))
    found = verdicts(coverage(files["few.csv"], files["face.glb"]))
    assert set(found) == set(SHAPES)
    assert [name for name, verdict in found.items() if verdict == "cannot be seen"] == [SHAPES[0]]


def test_markers_without_a_character_are_refused(files: SmallFiles) -> None:
    with pytest.raises(InputError, match="depends on the character"):
        coverage(files["take.trc"])


def test_the_built_in_take_shows_nearly_all_that_its_markers_see(demo: Request) -> None:
    found = coverage(demo.performance, demo.character)
    told = Counter(verdicts(found).values())
    assert told["not shown"] == 0
    assert told["shown well"] > 10 * told["shown weakly"]
    unseen = {name for name, verdict in verdicts(found).items() if verdict == "cannot be seen"}
    assert (
        {"Look_L", "Look_R"} <= unseen <= {"Look_L", "Look_R", "Look_Up", "Look_Down"}
    )  # no marker rides on an eyeball


def test_the_command_prints_the_same_as_a_table_and_as_json(files: SmallFiles) -> None:
    words = ("inspect", files["take.trc"], "--coverage", files["face.glb"], "--pairs", files["face.pairs.json"])
    told, table = mien(*words, "--json"), mien(*words)
    assert (told.code, table.code) == (0, 0)
    document = json.loads(told.out)
    assert {shape["name"] for shape in document["shapes"]} == set(SHAPES)
    assert sum(document["verdicts"].values()) == len(SHAPES)
    for shape in document["shapes"]:
        line = next(line for line in table.out.splitlines() if line.split()[:1] == [shape["name"]])
        assert shape["verdict"] in line
        assert f"{shape['reached']:.2f}" in line


def test_a_character_without_coverage_is_wrong_usage(files: SmallFiles) -> None:
    done = mien("inspect", files["take.trc"], files["face.glb"])
    assert (done.code, done.out) == (2, "")


@pytest.mark.real
def test_the_real_range_of_motion_take_hardly_moves_the_jaw_sideways(data: Path) -> None:
    found = verdicts(coverage(data / "clips/livelink/alex_rom_3.csv"))
    assert [name for name, verdict in found.items() if verdict == "not shown"] == ["jawLeft", "jawRight"]
    assert found["jawOpen"] == found["eyeBlinkLeft"] == "shown well"


@pytest.mark.real
def test_the_jaw_capture_shows_the_jaw_and_sees_no_eyes(data: Path, tmp_path: Path) -> None:
    take = read_markers(data / "clips/markers/jaw.c3d")
    trc.write_markers(tmp_path / "jaw.trc", replace(take, points=take.points[::6], fps=take.fps / 6))
    found = verdicts(coverage(tmp_path / "jaw.trc", data / "rigs" / "makehuman_adult.glb"))
    assert all(found[name] == "shown well" for name in ("jawOpen", "jawLeft", "jawRight", "jawForward"))
    assert found["eyeBlinkLeft"] == found["eyeLookInLeft"] == "cannot be seen"
    assert found["viseme_aa"] == "kept at rest"
    assert found["cheekSquintLeft"] == "not shown"
