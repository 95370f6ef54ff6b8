"""Real captures and real rigs through the main job, cut short to keep it quick."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.core import Clip, Markers, Rig
from mien.io.formats import read_clip, read_markers, read_rig
from mien.io.trc import write_markers
from mien.job.outputs import write_outputs
from mien.job.pairs import rig_landmarks
from mien.job.request import Request, Result
from mien.job.retarget import run
from tests.cli.running import mien

pytestmark = pytest.mark.real

STEP = 6
"""Every sixth frame of the 60 fps capture: ten a second show the jaw well enough."""
CHARACTERS = ("makehuman_adult", "makehuman_child", "toon")


@cache
def rig(data: Path, name: str) -> Rig:
    return read_rig(data / "rigs" / f"{name}.glb")


@pytest.fixture(scope="module")
def jaw(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The capture of the jaw, thinned."""
    take = read_markers(data / "clips/markers/jaw.c3d")
    path = tmp_path_factory.mktemp("jaw") / "jaw.trc"
    write_markers(path, replace(take, points=take.points[::STEP], fps=take.fps / STEP))
    return path


@pytest.fixture(scope="module")
def on_character(data: Path, jaw: Path) -> dict[str, Result]:
    """The jaw on every character, by the characters' own landmark files."""
    return {name: run(Request(jaw, data / "rigs" / f"{name}.glb")) for name in CHARACTERS}


STILL = ("Reye_Outside", "Leye_Outside", "ForeHead_R", "ForeHead_M", "ForeHead_L")
"""Markers that hardly leave the skull."""


def in_head(markers: Markers, name: str) -> np.ndarray:
    """A marker over time `(F, 2)` with the head held still: to the actor's left and up."""
    still, moved = markers.only(STILL).points, markers.only((name,)).points[:, 0]
    first = still[0] - still[0].mean(axis=0)
    left = first[1] - first[0]
    left = left / np.linalg.norm(left)
    up = first[2:].mean(axis=0) - first[:2].mean(axis=0)
    up = up - (up @ left) * left
    up = up / np.linalg.norm(up)
    result = []
    for corners, point in zip(still, moved, strict=True):
        turn, _ = Rotation.align_vectors(first, corners - corners.mean(axis=0))
        at = turn.apply(point - corners.mean(axis=0))
        result.append([at @ left, at @ up])
    return np.array(result) - result[0]


def landmark_path(face: Rig, clip: Clip, name: str) -> np.ndarray:
    """A landmark over a clip `(F, 3)` from where it rests: to the face's left, up and forward, without head motion."""
    point = rig_landmarks(face, None)[name]
    posed = face.only(point.corners[0]).pose(clip.channels(face.blendshapes.names))
    return np.einsum("i,fic->fc", point.weights[0], posed) - point.of(face.neutral.vertices)[0]


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.corrcoef(a, b)[0, 1])


@pytest.mark.parametrize("name", CHARACTERS)
def test_the_jaw_of_a_real_capture_opens_the_characters(name: str, jaw: Path, on_character: dict[str, Result]) -> None:
    result, take = on_character[name], read_markers(jaw)
    assert (len(result.clip), result.clip.fps) == (len(take), take.fps)
    assert np.isfinite(result.clip.values).all()
    assert result.clip.head is not None
    drop = -in_head(take, "Chin")[:, 1]
    opened = -landmark_path(result.character, result.clip, "chin_tip")[:, 1]
    assert correlation(drop, opened) > 0.9
    assert opened.max() > 0.01


@pytest.mark.parametrize("name", CHARACTERS)
def test_left_stays_left(name: str, jaw: Path, on_character: dict[str, Result]) -> None:
    result, take = on_character[name], read_markers(jaw)
    aside = in_head(take, "Chin")[:, 0]
    clear = np.abs(aside) > 0.4 * np.abs(aside).max()
    theirs = landmark_path(result.character, result.clip, "chin_tip")[:, 0]
    assert correlation(aside, theirs) > 0.7
    assert (np.sign(aside[clear]) == np.sign(theirs[clear])).mean() > 0.9


def test_the_same_take_as_c3d_and_trc_moves_the_face_alike(data: Path, tmp_path: Path) -> None:
    """The text keeps 5e-8 m; shapes that the markers hardly tell apart may trade weight over that, the face may not."""
    results = []
    for suffix in (".c3d", ".trc"):
        take = read_markers(data / f"clips/markers/jaw{suffix}")
        path = tmp_path / f"from{suffix[1:]}.trc"
        write_markers(path, replace(take, points=take.points[::STEP], fps=take.fps / STEP))
        results.append(run(Request(path, data / "rigs/makehuman_adult.glb")))
    one, other = (result.character.pose(result.clip.values) for result in results)
    assert np.abs(one - other).max() < 2e-5
    np.testing.assert_allclose(results[0].clip.values, results[1].clip.values, atol=5e-3)


def test_a_c3d_goes_through_the_command_line(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.csv"
    done = mien("retarget", data / "clips/markers/eyebrows.c3d", data / "rigs/makehuman_child.glb", "-o", out, "-q")
    assert (done.code, done.err) == (0, "")
    clip = read_clip(out)
    assert (len(clip), clip.fps) == (902, 60)
    take = read_markers(data / "clips/markers/eyebrows.c3d")
    raised = take.only(("NoseTop", "Eyebrow_Center")).points
    distance = np.linalg.norm(raised[:, 1] - raised[:, 0], axis=1)
    child = rig(data, "makehuman_child")
    brow = landmark_path(child, clip, "glabella")[:, 1] - landmark_path(child, clip, "ibug_27")[:, 1]
    assert correlation(distance, brow) > 0.7


@pytest.fixture(scope="module")
def speech(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two hundred rows of a Live Link Face recording, in the middle of a sentence."""
    path = tmp_path_factory.mktemp("speech") / "S07.csv"
    lines = (data / "clips/livelink/S07-001.csv").read_text(encoding="utf-8-sig").splitlines()
    path.write_text("\n".join([lines[0], *lines[401:601]]) + "\n", encoding="utf-8")
    return path


def test_a_phone_recording_on_the_actors_rig_acts_on_a_toon(data: Path, speech: Path, tmp_path: Path) -> None:
    result = run(Request(speech, data / "rigs/toon.glb", actor=data / "rigs/ict_face.glb"))
    recorded = read_clip(speech)
    assert (len(result.clip), result.clip.fps) == (len(recorded), recorded.fps)
    assert np.isfinite(result.clip.values).all()
    assert same_shape(result.clip, recorded, "jawOpen") > 0.9
    write_outputs(result, [tmp_path / "o.glb"])
    back = read_clip(tmp_path / "o.glb")
    np.testing.assert_allclose(back.channels(result.clip.names), result.clip.values, atol=1e-6)


def same_shape(clip: Clip, truth: Clip, name: str) -> float:
    return correlation(clip.channels([name])[:, 0], truth.channels([name])[:, 0])


def lid_gap(face: Rig, clip: Clip, side: str) -> np.ndarray:
    """How far the lids close, over a clip."""
    upper, lower = ("ibug_43", "ibug_47") if side == "left" else ("ibug_37", "ibug_41")
    return landmark_path(face, clip, lower)[:, 1] - landmark_path(face, clip, upper)[:, 1]


@pytest.mark.parametrize("name", ["toon", "makehuman_child"])
def test_an_animated_mesh_acts_on_other_faces(name: str, data: Path) -> None:
    sides = (data / "rigs/makehuman_adult.landmarks.json", data / "rigs" / f"{name}.landmarks.json")
    result = run(Request(data / "clips/adult_plays_S07.glb", data / "rigs" / f"{name}.glb", landmarks=sides))
    truth = read_clip(data / "clips/adult_plays_S07.glb")
    assert (len(result.clip), result.clip.fps) == (len(truth), pytest.approx(truth.fps))
    assert np.isfinite(result.clip.values).all()
    actor = rig(data, "makehuman_adult")
    assert (
        correlation(
            *(landmark_path(f, c, "chin_tip")[:, 1] for f, c in ((actor, truth), (result.character, result.clip)))
        )
        > 0.9
    )
    for side in ("left", "right"):
        closing = [lid_gap(f, c, side) for f, c in ((actor, truth), (result.character, result.clip))]
        assert correlation(*closing) > 0.8
    assert result.report.gain > 0.6


def test_rows_that_the_phone_lost_are_held_and_counted(data: Path) -> None:
    recorded = read_clip(data / "clips/livelink/apfel.csv")
    lost = np.isnan(recorded.values).any(axis=1)
    assert lost.sum() == 35
    result = run(Request(data / "clips/livelink/apfel.csv", data / "rigs/makehuman_adult.glb"))
    assert np.isfinite(result.clip.values).all()
    first = int(np.argmax(lost))
    run_end = first + int(np.argmin(lost[first:]))
    assert (result.clip.values[first:run_end] == result.clip.values[first - 1]).all()
    assert any("35" in note.message for note in result.report.notes if note.code == "frames-held")
