"""Learning from labelled frames, from files to files: any parameters, any character, label and label again."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mien.core import Clip, Examples, InputError, Markers, Mesh, Rig, Skeleton, Skin
from mien.io import gltf
from mien.io.examples import read_examples, write_examples
from mien.io.formats import read_clip, read_rig
from mien.io.weights import write_clip
from mien.job import label, pose
from mien.job.model import replay, save_model
from mien.job.request import Request
from mien.job.retarget import fit, run
from mien.job.suggest import ask, suggest_frames
from tests.job.small_files import FRAMES, SmallFiles, capture_of
from tests.retargeting.actors import SHAPES, face, weights

SLIDERS = ("jaw_ctl.open", "mood", "lids")


def sliders(values: np.ndarray) -> np.ndarray:
    """A studio rig's sliders, which are not the shapes: one is eased, one drives two shapes."""
    return np.column_stack([np.sqrt(np.abs(values[:, 0])), values[:, 1] - values[:, 2], 50 * values[:, 3]])


def labels(files: SmallFiles, names: tuple[str, ...] = SHAPES, count: int = 16, name: str = "labels.csv") -> np.ndarray:
    played = weights(FRAMES)
    values = played if names is SHAPES else sliders(played)
    frames = np.linspace(2, FRAMES - 3, count).astype(int)
    write_examples(files[name], Examples(frames, names, values[frames]))
    return values


def request(files: SmallFiles, **changes: object) -> Request:
    plain = Request(
        files["take.trc"], files["face.glb"], "latent", examples=files["labels.csv"], settings={"count": 40}
    )
    return replace(plain, **changes)  # type: ignore[arg-type]


def error(found: Clip, right: np.ndarray) -> float:
    return float(np.sqrt(((found.values - right) ** 2).mean()))


def test_labels_alone_drive_a_character_with_no_pair_and_no_landmark(files: SmallFiles) -> None:
    right = labels(files)
    result = run(request(files))
    assert error(result.clip, right) < 0.05
    assert result.clip.head is not None
    assert result.report.as_json()["labels"] == 16


def test_existing_animation_of_the_character_helps(files: SmallFiles) -> None:
    right = labels(files, count=6)
    write_clip(files["old.csv"], Clip(SHAPES, right[::-1], 60.0))
    alone, helped = run(request(files)), run(request(files, animations=(files["old.csv"],)))
    assert helped.report.figures["unlabelled"][1] == 40
    assert error(helped.clip, right) < 0.9 * error(alone.clip, right)


def test_a_character_may_be_nothing_but_parameters(files: SmallFiles) -> None:
    right = labels(files, SLIDERS)
    write_clip(files["rig.csv"], Clip(SLIDERS, right, 60.0))
    for character in ("labels.csv", "rig.csv"):
        result = run(request(files, character=files[character]))
        assert result.character is None
        assert result.clip.names == SLIDERS
        assert np.corrcoef(result.clip.values[:, 2], right[:, 2])[0, 1] > 0.97
    with pytest.raises(InputError, match="leave --pairs out"):
        run(request(files, character=files["labels.csv"], pairs=files["face.pairs.json"]))


@pytest.mark.parametrize("take", ["anim.glb", "weights.csv"])
def test_meshes_and_weights_are_sources_as_markers_are(files: SmallFiles, take: str) -> None:
    right = labels(files)
    assert error(run(request(files, performance=files[take])).clip, right) < 0.05


def test_a_model_of_labels_is_kept_in_a_file_with_or_without_a_mesh(files: SmallFiles) -> None:
    labels(files, SLIDERS)
    for character in ("labels.csv", "face.glb"):
        if character == "face.glb":
            labels(files)
        fresh = request(files, character=files[character])
        save_model(files["m.mien"], fit(fresh))
        again = replay(Request(files["take.trc"], files["m.mien"]))
        assert np.abs(again.clip.values - run(fresh).clip.values).max() < 1e-12


def test_bones_are_parameters_too(files: SmallFiles) -> None:
    rig = boned()
    gltf.write_rig(files["boned.glb"], rig)
    played = weights(FRAMES)
    frames = np.linspace(2, FRAMES - 3, 16).astype(int)
    write_examples(files["labels.csv"], Examples(frames, ("jaw.rx",), 0.5 * played[frames, :1]))
    result = run(request(files, character=files["boned.glb"]))
    gltf.write_clip(files["out.glb"], result.clip, result.character)
    moved = read_clip(files["out.glb"])
    assert moved.joints is not None
    rest = read_rig(files["out.glb"]).skeleton
    assert rest is not None
    at = rest.names.index("jaw")
    turn = (
        np.linalg.inv(np.linalg.inv(rest.rest[0]) @ rest.rest[at])
        @ np.linalg.inv(moved.joints[:, 0])
        @ moved.joints[:, at]
    )
    assert np.arctan2(turn[:, 2, 1], turn[:, 1, 1]) == pytest.approx(result.clip.values[:, 0], abs=1e-4)


def boned() -> Rig:
    """The small face with a head and a jaw below it."""
    rig = face()
    rest = np.tile(np.eye(4), (2, 1, 1))
    rest[1, :3, 3] = [0, -0.02, 0]
    share = (rig.neutral.vertices[:, 1] < -0.03).astype(float)
    skin = Skin(np.tile([0, 1], (len(share), 1)), np.column_stack([1 - share, share]), np.linalg.inv(rest))
    mesh = Mesh(rig.neutral.vertices, rig.neutral.triangles)
    return Rig(mesh, rig.blendshapes, Skeleton(("head", "jaw"), np.array([-1, 0]), rest), skin)


def test_a_pose_is_completed_from_a_few_values(files: SmallFiles) -> None:
    right = labels(files, count=24)
    tied = right.copy()
    tied[:, 2] = tied[:, 1]
    write_examples(files["labels.csv"], Examples(np.arange(FRAMES), SHAPES, tied))
    save_model(files["m.mien"], fit(request(files)))
    posed = pose.pose(files["face.glb"], files["m.mien"], {"smile_L": 0.9})
    assert posed.values()["smile_L"] == 0.9
    assert posed.values()["smile_R"] > 0.3
    for name in ("pose.csv", "pose.glb", "pose.png"):
        pose.write(posed, files[name])
    assert read_clip(files["pose.csv"]).values[0] == pytest.approx(posed.clip.values[0], abs=1e-6)
    for given, why in (({}, "no entry"), ({"smileL": 1.0}, "smile_L")):
        with pytest.raises(InputError, match=why):
            pose.pose(files["face.glb"], files["m.mien"], given)
    save_model(files["r.mien"], fit(request(files, method="ridge")))
    with pytest.raises(InputError, match="--method latent"):
        pose.pose(files["face.glb"], files["r.mien"], {"smile_L": 0.9})


def test_label_fit_suggest_and_label_again(files: SmallFiles) -> None:
    right, folder = weights(FRAMES), files["work"]
    first = label.choose(files["take.trc"], files["face.glb"], folder, count=5)
    written = label.write(first, folder)
    assert {path.name for path in written} >= {"labels.csv", "frames.png", f"frame_{first.frames[0]:05d}.png"}
    assert np.abs(right[first.frames[0]]).max() < 0.1
    blank = read_examples(folder / "labels.csv")
    assert not blank.values[0].any()
    assert np.isnan(blank.values[1:]).all()
    write_examples(folder / "labels.csv", Examples(blank.frames, SHAPES, right[blank.frames]))
    save_model(files["m.mien"], fit(request(files, examples=folder / "labels.csv")))
    asked = ask(files["take.trc"], files["m.mien"])
    found = suggest_frames(asked, 3)
    assert not set(found.frames) & set(first.frames)
    assert (np.diff(found.gain) <= 0).all()
    assert 0 < found.gain.sum() < 1
    second = label.choose(files["take.trc"], files["m.mien"], folder, count=3)
    assert second.frames.tolist() == found.frames.tolist()
    assert second.filled
    table = second.table
    assert table.frames.tolist() == [*blank.frames, *second.frames]
    assert table.values[:5] == pytest.approx(right[blank.frames], abs=1e-5)
    assert not np.isnan(table.values).any()
    elsewhere = label.choose(files["take.trc"], files["m.mien"], files["new"], count=3)
    assert elsewhere.table.frames.tolist() == sorted(blank.frames) + elsewhere.frames.tolist()


def test_a_model_of_shapes_has_its_predictions_corrected(files: SmallFiles) -> None:
    """Fit, label what it predicts, correct, fit again."""
    right, folder = weights(FRAMES), files["work"]
    plain = Request(files["take.trc"], files["face.glb"], pairs=files["face.pairs.json"])
    save_model(files["m.mien"], fit(plain))
    found = label.choose(files["take.trc"], files["m.mien"], folder, count=3)
    assert found.filled
    assert found.table.names == SHAPES
    assert found.table.values == pytest.approx(right[found.frames], abs=0.25)
    actor, both = (
        label.choose(files["take.trc"], files["face.glb"], files["new"], count=3).pictures[0],
        found.pictures[0],
    )
    assert both.shape == (actor.shape[0], 2 * actor.shape[1], 3)
    suggested = suggest_frames(ask(files["take.trc"], files["m.mien"]), 3)
    assert suggested.frames.tolist() == found.frames.tolist()
    label.write(found, folder)
    write_examples(folder / "labels.csv", Examples(found.frames, SHAPES, 0.5 * right[found.frames]))
    before, after = (
        run(each).clip.values[found.frames] for each in (plain, replace(plain, examples=folder / "labels.csv"))
    )
    assert after.mean() < 0.75 * before.mean()


def test_frames_of_weights_have_no_picture_but_a_table(files: SmallFiles) -> None:
    found = label.choose(files["weights.csv"], files["face.glb"], files["work"], count=4)
    assert not found.pictures
    assert [note.code for note in found.notes] == ["no-pictures"]
    assert [path.name for path in label.write(found, files["work"])] == ["labels.csv"]


def write_rows(files: SmallFiles, *rows: str) -> None:
    files["labels.csv"].write_text("\n".join(rows) + "\n", encoding="utf-8")


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        (("frame,jawOpen",), "labels no frame"),
        (("frame,jawOpen", "5,"), "there are none"),
        (("frame,jawOpen", "5,1", "5,0"), r"more than once \(frame 5\)"),
        (("frame,jawOpen", "5,1", "500,0"), "500.*outside of the training take"),
        (("frame,jawOpen", "-5,1"), "whole numbers"),
        (("frame,jawOpne", "5,1"), "Did you mean 'jawOpen'"),
        (("frame,jawOpen", "5,inf"), "finite|infin"),
        (("time,jawOpen", "5,1"), "no column named 'frame'"),
    ],
)
def test_bad_labels_are_refused_in_words(files: SmallFiles, rows: tuple[str, ...], why: str) -> None:
    write_rows(files, *rows)
    with pytest.raises(Exception, match=why) as caught:
        run(request(files))
    assert "Mien" in str(type(caught.value).__mro__)


def test_poor_labels_are_used_and_said(files: SmallFiles) -> None:
    for rows, code in (
        (("frame,jawOpen", "5,1"), "one-label"),
        (("frame,jawOpen,browUp", "5,1,nan", "20,0,0", "30,.5,0"), "parameters-constant"),
    ):
        write_rows(files, *rows)
        result = run(request(files))
        assert np.isfinite(result.clip.values).all()
        assert code in {note.code for note in result.report.notes}


def test_labels_of_every_frame_leave_nothing_unlabelled(files: SmallFiles) -> None:
    right = weights(FRAMES)
    write_examples(files["labels.csv"], Examples(np.arange(FRAMES), SHAPES, right))
    result = run(request(files))
    assert result.report.figures["unlabelled"] == [0, 0]
    assert error(result.clip, right) < 0.02


def test_blind_frames_hold_and_markers_never_seen_are_left_out(files: SmallFiles) -> None:
    labels(files)
    take = capture_of()
    points = take.points.copy()
    points[:, 3] = np.nan
    points[40:60] = np.nan
    points[70:, 7] = np.nan
    files.take(Markers(take.names, points, take.fps))
    result = run(request(files))
    assert {"markers-never-seen", "frames-held"} <= {note.code for note in result.report.notes}
    assert np.array_equal(result.clip.values[59], result.clip.values[39])
    assert np.isfinite(result.clip.values).all()
    assert json.dumps(result.report.as_json())
