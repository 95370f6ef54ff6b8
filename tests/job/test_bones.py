"""Bones driven through files: what is driven, what is written, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core import Clip, FileError, InputError, Markers
from mien.io import gltf, trc
from mien.io.formats import read_clip, read_rig
from mien.io.gltf import read_poses, write_rig, write_rigged
from mien.job.bones import with_head
from mien.job.model import replay, save_model
from mien.job.outputs import write_outputs
from mien.job.request import Request, Result
from mien.job.retarget import fit, run
from tests.io.gltf_samples import matrix, turn
from tests.io.test_gltf_write import faults  # noqa: F401
from tests.job.small_files import SmallFiles, marker_pairs
from tests.retargeting.actors import points_on
from tests.retargeting.bone_face import POINTS, POSES, bone_face, bones, curves, performed, poses

STIFF = bone_face().skin.weights[points_on(bone_face(), POINTS).corners[:, 0], 1] > 0.999
RIGID = tuple(f"m{i}" for i in np.flatnonzero(STIFF))
"""Markers that only the head carries."""


@pytest.fixture
def files(tmp_path: Path) -> SmallFiles:
    """A face of bones, its poses as animations of another file, and a take of it with pairs."""
    made, rig = SmallFiles(tmp_path), bone_face()
    write_rig(made["bones.glb"], rig)
    assert rig.skeleton is not None
    clips = {name: held(pose) for name, pose in poses(rig.skeleton).items()}
    write_rigged(made["poses.glb"], rig, clips)
    made.take(performed(curves(90)))
    points = points_on(rig, POINTS)
    made.pairs(marker_pairs(points, [f"m{i}" for i in range(POINTS)]), "bones.pairs.json")
    return made


def held(pose: np.ndarray) -> Clip:
    """A clip that ends in a pose."""
    rest = bone_face().skeleton.rest
    return Clip((), np.zeros((2, 0)), 30.0, joints=np.stack([rest, pose]))


def asked(files: SmallFiles, **more: object) -> Request:
    given = {"method": "rbf", "pairs": files["bones.pairs.json"], "neutral": "0", "rigid": RIGID, **more}
    return Request(files["take.trc"], files["bones.glb"], **given)  # type: ignore[arg-type]


def posed(result: Result, path: Path) -> Clip:
    write_outputs(result, [path])
    return read_clip(path)


def test_poses_are_read_as_each_animation_ends(files):
    skeleton, found = read_poses(files["poses.glb"])
    assert tuple(found) == POSES
    expected = poses(skeleton)
    assert all(np.allclose(found[name], expected[name], atol=1e-6) for name in POSES)
    with pytest.raises(FileError, match="no animation that moves a joint"):
        read_poses(files["bones.glb"])


def test_bones_follow_the_take_by_named_poses_and_are_written_as_joints(files):
    exact = {"sparsity": 0.0, "damping": 0.0, "smooth": 0.0, "prior": 0.0, "unseen": False}
    result = run(asked(files, poses=files["poses.glb"], settings=exact, head=False))
    assert result.clip.names == POSES
    assert np.abs(result.clip.values - curves(90)).max() < 0.01
    clip = posed(result, files["out.glb"])
    assert np.allclose(clip.joints, result.clip.joints, atol=1e-5)
    expected = bones().world(result.clip.values)
    assert np.allclose(result.clip.joints, expected, atol=1e-5)


def test_the_written_file_is_valid_and_keeps_the_face(files, faults):  # noqa: F811
    result = run(asked(files, poses=files["poses.glb"]))
    posed(result, files["out.glb"])
    assert faults(files["out.glb"]) == []
    kept, own = read_rig(files["out.glb"]), read_rig(files["bones.glb"])
    assert np.array_equal(kept.neutral.vertices, own.neutral.vertices)
    assert kept.skeleton.names == own.skeleton.names


def test_without_poses_each_bone_of_the_face_turns_for_itself(files):
    result = run(asked(files))
    assert {name.split(".")[0] for name in result.clip.names} >= {"jaw", "cheek_L", "brow"}
    rig, right = bone_face(), bones().world(curves(90))
    found = rig.pose(np.zeros((90, 0)), np.linalg.inv(result.clip.head)[:, None] @ result.clip.joints)
    error = np.linalg.norm(found - rig.pose(np.zeros((90, 0)), right), axis=2)
    moved = np.linalg.norm(rig.pose(np.zeros((90, 0)), right) - rig.neutral.vertices, axis=2)
    assert error.mean() < 0.4 * moved.mean()


def test_shapes_are_driven_where_there_are_any_unless_bones_are_asked_for(files):
    from mien.job.bones import driven

    rig = bone_face()
    both = replace(rig, blendshapes=replace(rig.blendshapes, names=("a",), deltas=rig.neutral.vertices[None] * 0.01))
    assert driven(both, None, None).shown is both
    assert driven(both, "bones", None).free
    assert driven(both, None, files["poses.glb"]).bones.names == POSES
    assert driven(both, "bones", files["poses.glb"]).shown.blendshapes.names == POSES
    assert driven(rig, None, None).free
    assert driven(rig, "shapes", None).shown is rig


def test_what_cannot_be_driven_is_refused(files):
    rig = read_rig(files["bones.glb"])
    bare = replace(rig, skeleton=None, skin=None)
    write_rig(files["bare.glb"], bare)
    request = asked(files)
    with pytest.raises(InputError, match="bones"):
        run(replace(request, targets="bone"))
    with pytest.raises(InputError, match="has no bones"):
        run(replace(request, character=files["bare.glb"], targets="bones"))
    with pytest.raises(InputError, match="targets are shapes"):
        run(replace(request, targets="shapes", poses=files["poses.glb"]))
    with pytest.raises(InputError, match="no blendshapes"):
        run(replace(request, targets="shapes"))
    with pytest.raises(FileError, match="poses are read from"):
        run(replace(request, poses=files["take.trc"]))
    with pytest.raises(InputError, match="leave --targets"):
        run(replace(request, method="ridge", targets="bones"))


def test_a_saved_model_of_bones_plays_the_same(files, tmp_path):
    for poses_file in (files["poses.glb"], None):
        request = asked(files, poses=poses_file)
        save_model(tmp_path / "a.mien", fit(request))
        again = replay(Request(request.performance, tmp_path / "a.mien"))
        at_once = run(request)
        assert np.array_equal(again.clip.values, at_once.clip.values)
        assert np.array_equal(again.clip.joints, at_once.clip.joints)
    other = replace(bone_face(), skeleton=replace(bone_face().skeleton, names=tuple("abcdefghi")))
    write_rig(files["other.glb"], other)
    with pytest.raises(FileError, match="not those of other"):
        replay(Request(request.performance, tmp_path / "a.mien"), files["other.glb"])


def test_the_heads_motion_carries_the_head_and_what_hangs_on_it():
    skeleton = bone_face().skeleton
    nod = np.stack([matrix((0, 0.1, 0), turn(0, 0.3))])
    below = with_head(skeleton.rest[None], nod, skeleton)
    assert np.allclose(below[0], nod[0] @ skeleton.rest)  # the head is the root here
    neck = replace(skeleton, parents=np.array([2, 8, 1, 1, 1, 1, 1, 1, -1]))
    under = with_head(neck.rest[None], nod, neck)
    assert np.array_equal(under[0, 8], neck.rest[8])
    assert np.allclose(under[0, :8], nod[0] @ neck.rest[:8])
    nameless = replace(neck, names=tuple("abcdefghi"))
    assert np.allclose(with_head(nameless.rest[None], nod, nameless)[0], nod[0] @ neck.rest)


@pytest.mark.real
def test_makehumans_bones_open_the_jaw_as_the_actor_does(data, tmp_path, faults):  # noqa: F811
    from mien.io import makehuman
    from mien.io.c3d import read_markers

    rig = makehuman.read_rig(data / "bones", below="neck01")
    gltf.write_rig(tmp_path / "face.glb", replace(rig, name="face"))
    adult = read_rig(data / "rigs" / "makehuman_adult.glb")
    spots = landmarks_of(data / "rigs" / "makehuman_adult.landmarks.json", adult, rig)
    SmallFiles(tmp_path).landmarks(spots, "face.landmarks.json")
    take = read_markers(data / "clips" / "markers" / "jaw.c3d")
    few = Markers(take.names, take.points[::20], take.fps / 20)
    trc.write_markers(tmp_path / "jaw.trc", few)
    poses_file = data / "bones" / "face-poseunits.json"
    result = run(Request(tmp_path / "jaw.trc", tmp_path / "face.glb", method="rbf", poses=poses_file))
    chin = few.points[:, few.names.index("Chin")] - few.points[:, few.names.index("NoseHead")]
    open_by = np.linalg.norm(chin, axis=1)
    jaw = sum(result.clip.channels([name])[:, 0] for name in ("JawDrop", "JawDropStretched", "ChinDown"))
    assert np.corrcoef(open_by, jaw)[0, 1] > 0.9
    assert result.report.gain > 0.75
    write_outputs(result, [tmp_path / "out.glb"])
    assert faults(tmp_path / "out.glb") == []


def landmarks_of(path: Path, adult, rig) -> dict[str, dict[str, int]]:
    """The adult's landmarks on the bone rig, whose head is the same to rounding."""
    from mien.io.documents import read_landmarks

    found = {}
    for name, spot in read_landmarks(path).items():
        near = np.linalg.norm(rig.neutral.vertices - adult.neutral.vertices[spot["vertex"]], axis=1)
        assert near.min() < 1e-6
        found[name] = {"vertex": int(near.argmin())}
    return found
