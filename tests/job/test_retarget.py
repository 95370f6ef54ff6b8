"""The main job on files: what comes out is what was asked for, in every format."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mien.core import Clip, InputError
from mien.io import npz, weights
from mien.io.formats import read_clip, read_markers, read_rig
from mien.job.account import write_report
from mien.job.outputs import write_outputs
from mien.job.request import Request, Result
from mien.job.retarget import run
from mien.vocabularies import ARKIT_NAMES, match
from tests.job.small_files import FRAMES, SmallFiles, capture_of
from tests.retargeting.actors import SHAPES, clip_of
from tests.retargeting.actors import weights as played

SETTINGS = {"sparsity": "0.001", "smooth": "0"}
REPORT_KEYS = {"format", "version", "method", "fit", "gain", "evidence", "settings", "warnings", "timing_s"}


def small_job(files: SmallFiles, **changes: object) -> Request:
    """Markers onto the small face."""
    given: dict[str, object] = {"pairs": files["face.pairs.json"], "settings": SETTINGS, **changes}
    return Request(files["take.trc"], files["face.glb"], **given)  # type: ignore[arg-type]


def mesh_job(files: SmallFiles, **changes: object) -> Request:
    """The animated face onto the small face."""
    given: dict[str, object] = {"pairs": files["mesh.pairs.json"], "settings": SETTINGS, **changes}
    return Request(files["anim.glb"], files["face.glb"], **given)  # type: ignore[arg-type]


def agreement(found: np.ndarray, truth: np.ndarray) -> float:
    return float(np.corrcoef(found.ravel(), truth.ravel())[0, 1])


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".npz", ".csv"])
def test_the_built_in_job_reads_back_equal(
    suffix: str, demo_result: Result, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("out") / f"out{suffix}"
    write_outputs(demo_result, [path])
    clip, found = demo_result.clip, read_clip(path)
    assert found.fps == pytest.approx(clip.fps)
    assert len(found) == len(clip)
    assert set(found.names) == set(clip.names)
    np.testing.assert_allclose(found.channels(clip.names), clip.values, atol=1e-6)
    if suffix in (".glb", ".gltf"):
        rig = read_rig(path)
        np.testing.assert_array_equal(rig.neutral.triangles, demo_result.character.neutral.triangles)
        np.testing.assert_allclose(rig.neutral.vertices, demo_result.character.neutral.vertices, atol=1e-6)
    if suffix == ".npz":
        np.testing.assert_array_equal(found.values, clip.values)
        assert clip.head is not None
        np.testing.assert_array_equal(found.head, clip.head)


def test_landmarks_given_for_pairing_also_let_the_generic_rig_be_heard(demo_result: Result) -> None:
    assert "mouth" in demo_result.retargeter.alignment.opinion


def test_the_phone_layout_reads_back_under_arkit_names(files: SmallFiles) -> None:
    result = run(mesh_job(files))
    write_outputs(result, [files["phone.csv"]], "livelink")
    found = read_clip(files["phone.csv"])
    assert found.names == ARKIT_NAMES
    known = match(SHAPES, ARKIT_NAMES)
    np.testing.assert_allclose(found.values, known.apply(result.clip.values), atol=1e-6)
    assert found.values[:, ARKIT_NAMES.index("jawOpen")].max() > 0.5


def test_the_built_in_job_gives_a_report_in_the_promised_form(
    demo_result: Result, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("report") / "r.json"
    write_report(path, demo_result)
    report = json.loads(path.read_text())
    assert set(report) >= REPORT_KEYS
    assert (report["format"], report["version"], report["method"]) == ("mien-report", 1, "range-of-motion")
    assert set(report["fit"]) == {"rms_mm", "max_mm", "per_frame_mm"}
    assert len(report["fit"]["per_frame_mm"]) == len(demo_result.clip)
    assert 0 < report["fit"]["rms_mm"] <= report["fit"]["max_mm"]
    assert all(set(note) == {"code", "message", "where"} for note in report["warnings"])
    assert set(report["timing_s"]) == {"read", "pair", "fit", "solve"}


def test_the_page_of_a_job_names_both_sides(files: SmallFiles) -> None:
    result = run(mesh_job(files))
    write_report(files["r.html"], result)
    page = files["r.html"].read_text(encoding="utf-8")
    assert page.lower().startswith("<!doctype html>")
    assert str(result.performance.path) in page
    assert "face.glb" in page


def test_the_built_in_job_loses_no_frame_and_makes_no_nan(demo: Request, demo_result: Result) -> None:
    take = read_markers(demo.performance)
    assert (len(demo_result.clip), demo_result.clip.fps) == (len(take), take.fps)
    assert np.isfinite(demo_result.clip.values).all()
    assert 0.6 < demo_result.report.gain < 1.2


@pytest.mark.parametrize("job", [small_job, mesh_job])
def test_a_face_that_acts_on_itself_gets_its_own_weights(job: object, files: SmallFiles) -> None:
    result = run(job(files))  # type: ignore[operator]
    assert agreement(result.clip.channels(SHAPES), played(FRAMES)) > 0.9
    assert result.clip.fps == 60


def test_weights_on_the_actors_rig_are_the_animated_actor(files: SmallFiles) -> None:
    asked = mesh_job(files)
    spoken = replace(asked, performance=files["weights.csv"], actor=files["face.glb"])
    np.testing.assert_allclose(
        run(spoken).clip.values, run(asked).clip.values, atol=2e-3
    )  # the file's rate is of its own


def test_weights_without_an_actor_are_copied_by_name_and_it_is_said(files: SmallFiles) -> None:
    result = run(Request(files["weights.csv"], files["face.glb"]))
    np.testing.assert_allclose(result.clip.channels(SHAPES), played(FRAMES), atol=1e-6)
    assert "copied-by-name" in {note.code for note in result.report.notes}
    asked = run(Request(files["weights.csv"], files["face.glb"], method="copy"))
    assert "copied-by-name" not in {note.code for note in asked.report.notes}
    np.testing.assert_array_equal(asked.clip.values, result.clip.values)


def with_head(files: SmallFiles) -> np.ndarray:
    angles = 0.3 * np.sin(np.linspace(0, 6, FRAMES))
    head = np.tile(np.eye(4), (FRAMES, 1, 1))
    head[:, 0, 0] = head[:, 2, 2] = np.cos(angles)
    head[:, 0, 2], head[:, 2, 0] = np.sin(angles), -np.sin(angles)
    clip = clip_of(played(FRAMES))
    npz.write_clip(
        files["phone.npz"], Clip(clip.names, clip.values, clip.fps, head, np.zeros((FRAMES, 2, 3)), start=7.5)
    )
    return head


@pytest.mark.parametrize("actor", [True, False])
def test_a_recorded_head_is_carried_unless_it_is_not_wanted(actor: bool, files: SmallFiles) -> None:
    head = with_head(files)
    request = mesh_job(files, actor=files["face.glb"] if actor else None)
    request = replace(request, performance=files["phone.npz"])
    carried = run(request).clip
    np.testing.assert_allclose(carried.head, head, atol=1e-6)
    assert carried.eyes is not None
    assert carried.start == 7.5
    assert run(replace(request, head=False)).clip.head is None


def test_head_motion_in_markers_is_found_unless_it_is_not_wanted(files: SmallFiles) -> None:
    found = run(small_job(files)).clip.head
    assert found is not None
    assert found.shape == (FRAMES, 4, 4)
    assert run(small_job(files, head=False)).clip.head is None


def test_the_training_take_may_be_another_file(files: SmallFiles) -> None:
    request = replace(small_job(files), training=files["take.trc"], settings={"smooth": 0})
    whole = run(request)
    take = read_markers(files["take.trc"])
    some = files.take(replace(take, points=take.points[40:60]), "some.trc")
    result = run(replace(request, performance=some))
    assert len(result.clip) == 20
    np.testing.assert_allclose(result.clip.values, whole.clip.values[40:60], atol=1e-6)


def test_a_performance_at_rest_is_no_mistake_when_the_training_take_is_another(files: SmallFiles) -> None:
    still = files.take(capture_of(np.zeros((10, 6))), "still.trc")
    result = run(replace(small_job(files), performance=still, training=files["take.trc"]))
    assert np.abs(result.clip.values).max() < 0.02
    with pytest.raises(InputError, match="no movement"):
        run(replace(small_job(files), performance=still))


def test_the_neutral_may_be_a_frame_or_the_first_frame_of_a_file(files: SmallFiles) -> None:
    frame = 60
    take = read_markers(files["take.trc"])
    rest = files.take(replace(take, points=take.points[frame : frame + 1]), "rest.trc")
    by_file = run(small_job(files, neutral=str(rest)))
    by_frame = run(small_job(files, neutral=str(frame)))
    assert by_frame.report.figures["neutral_frame"] == frame
    assert by_file.report.figures["neutral_frame"] is None
    assert by_file.retargeter.neutral == pytest.approx(take.points[frame])
    assert by_frame.retargeter.neutral == pytest.approx(take.points[frame], abs=2e-3)


def test_the_neutral_of_a_mesh_may_be_a_frame_a_mesh_or_weights(files: SmallFiles) -> None:
    own = run(mesh_job(files)).retargeter.neutral
    np.testing.assert_allclose(run(mesh_job(files, neutral=str(files["face.glb"]))).retargeter.neutral, own, atol=1e-7)
    values = played(FRAMES)[30:]
    weights.write_clip(files["rest.csv"], clip_of(values))
    other = run(mesh_job(files, neutral=str(files["rest.csv"]))).retargeter.neutral
    by_frame = run(mesh_job(files, neutral="30")).retargeter.neutral
    assert np.abs(other - own).max() > 5e-4  # frame 30 is not at rest
    np.testing.assert_allclose(other, by_frame, atol=4e-4)


def test_examples_replace_what_the_method_would_have_thought(files: SmallFiles) -> None:
    peak = int(np.argmax(played(FRAMES)[:, 0]))
    files["e.csv"].write_text(f"frame,jawOpen\n{peak},1\n")
    plain, taught = run(small_job(files)), run(small_job(files, examples=files["e.csv"]))
    label = taught.retargeter.alignment.similarity.enhanced[SHAPES.index("jawOpen")]
    assert (int(np.argmax(label)), np.count_nonzero(label)) == (peak, 1)
    assert not np.array_equal(plain.clip.values, taught.clip.values)


def test_a_lost_frame_of_weights_is_held_and_counted(files: SmallFiles) -> None:
    lines = files["weights.csv"].read_text().splitlines()
    lines[31] = ",".join([*lines[31].split(",")[:2], *[""] * 6])
    files["weights.csv"].write_text("\n".join(lines) + "\n")
    for request in (Request(files["weights.csv"], files["face.glb"]), mesh_job(files, actor=files["face.glb"])):
        result = run(replace(request, performance=files["weights.csv"]))
        assert len(result.clip) == FRAMES
        assert np.isfinite(result.clip.values).all()
        assert {"gaps", "frames-held", "gaps-filled"} & {note.code for note in result.report.notes}


def test_the_actors_file_may_spell_its_shapes_otherwise(files: SmallFiles) -> None:
    text = files["weights.csv"].read_text().replace("smile_L", "mouthSmileLeft").replace("blink_R", "eyeBlinkRight")
    files["weights.csv"].write_text(text.replace("jawOpen", "JawOpen"))
    result = run(Request(files["weights.csv"], files["face.glb"]))
    assert agreement(result.clip.channels(("jawOpen",)), played(FRAMES)[:, :1]) > 0.999


def test_progress_names_the_stages_in_order(files: SmallFiles) -> None:
    seen: list[str] = []
    run(small_job(files), seen.append)
    assert seen == ["read", "pair", "fit", "solve"]
