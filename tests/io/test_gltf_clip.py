"""Reading glTF animations: sampling, interpolation, and poses that match the file exactly."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from mien.core import FileError
from mien.io.gltf import read_clip, read_rig
from tests.io.gltf_samples import SQUARE, Sample, contents, matrix, skinned, turn


def square(shapes=("a", "b"), **node):
    s = Sample()
    s.mesh(s.primitive(deltas=[SQUARE] * len(shapes)), shapes=shapes)
    s.node(mesh=0, **node)
    return s


def at_times(tmp_path, times, values, interpolation, **wanted):
    s = square()
    s.animate((0, "weights", times, values, interpolation))
    return read_clip(s.save(tmp_path / "a.glb"), **wanted)


def test_linear_weights_at_their_own_frames_are_exact(tmp_path, rng):
    values = np.float32(rng.random((100, 2)))
    clip = at_times(tmp_path, np.arange(100) / 24, values, "LINEAR")
    assert clip.fps == 24
    assert clip.names == ("a", "b")
    assert np.array_equal(clip.values, values)
    assert clip.joints is None


def test_linear_weights_between_keys_are_in_between(tmp_path):
    clip = at_times(tmp_path, [1, 2], np.array([[0, 1], [1, 0]]), "LINEAR", fps=10.0)
    assert len(clip) == 11
    assert clip.start == 1
    assert np.allclose(clip.values[:, 0], np.linspace(0, 1, 11), atol=1e-6)


def test_steps_hold_until_the_next_key_and_take_it_on_time(tmp_path):
    clip = at_times(tmp_path, np.array([0, 7, 9]) / 30, np.array([[0, 0], [1, 2], [3, 4]]), "STEP")
    assert clip.fps == 30
    assert np.array_equal(clip.values[:, 0], [0] * 7 + [1, 1, 3])


def test_cubic_splines_follow_their_polynomial(tmp_path):
    """A cubic given by its own values and slopes at the keys must come back everywhere."""
    times = np.array([0, 0.5, 2])
    curve = np.polynomial.Polynomial([0.1, -1, 0.7, 0.2])
    keys = np.stack([curve.deriv()(times), curve(times), curve.deriv()(times)], axis=1)
    clip = at_times(tmp_path, times, np.repeat(keys[..., None], 2, axis=2), "CUBICSPLINE")
    t = np.arange(len(clip)) / clip.fps
    assert np.abs(clip.values[:, 0] - curve(t)).max() < 1e-6


@pytest.mark.parametrize("fps", [24, 25, 29.97002997, 30, 59.94005994, 60, 120])
def test_the_frame_rate_is_that_of_the_keys(tmp_path, fps):
    clip = at_times(tmp_path, 3600 + np.arange(300) / fps, np.zeros((300, 2)), "LINEAR")
    assert clip.fps == pytest.approx(fps, rel=2e-4)
    assert len(clip) == pytest.approx(300, abs=1)


def test_sparse_keys_are_sampled_thirty_times_a_second(tmp_path):
    clip = at_times(tmp_path, [0, 1, 2.2345], np.zeros((3, 2)), "LINEAR")
    assert clip.fps == 30


def test_weights_that_no_key_drives_keep_the_default_of_their_node(tmp_path):
    s = square(weights=[0.25, 0.5])
    s.mesh(s.primitive(deltas=[SQUARE]), shapes=["c"])
    s.node(mesh=1)
    s.animate((1, "weights", [0, 1], np.array([[0.0], [1.0]]), "LINEAR"))
    clip = read_clip(s.save(tmp_path / "a.glb"))
    assert (clip.values[:, :2] == [0.25, 0.5]).all()
    assert clip.values[-1, 2] == 1


def test_meshes_that_disagree_about_a_shape_are_noted(tmp_path):
    s = square()
    s.node(mesh=0)
    s.animate((0, "weights", [0, 1], np.zeros((2, 2)), "LINEAR"), (1, "weights", [0, 1], np.ones((2, 2)), "LINEAR"))
    clip = read_clip(s.save(tmp_path / "a.glb"))
    assert not clip.values.any()
    assert [note.code for note in clip.notes] == ["weights-disagree"] * 2


def test_animations_are_chosen_by_name_or_number(tmp_path):
    s = square()
    s.animate((0, "weights", [0, 1], np.zeros((2, 2)), "LINEAR"), name="idle")
    s.animate((0, "weights", [0, 1], np.ones((2, 2)), "LINEAR"), name="talk")
    path = s.save(tmp_path / "a.glb")
    assert not read_clip(path).values.any()
    assert read_clip(path, "talk").values.all()
    assert read_clip(path, 1).values.all()
    with pytest.raises(FileError, match="talk"):
        read_clip(path, "tolk")
    with pytest.raises(FileError, match="not 2"):
        read_clip(path, 2)


def test_a_file_without_animation_says_so(tmp_path):
    with pytest.raises(FileError, match="no animation"):
        read_clip(square().save(tmp_path / "a.glb"))


def test_pointer_animations_are_left_out_with_a_note(tmp_path):
    s = square()
    s.animate((0, "weights", [0, 1], np.ones((2, 2)), "LINEAR"))
    s.root["animations"][0]["channels"].append({"sampler": 0, "target": {"path": "pointer"}})
    assert [note.code for note in read_clip(s.save(tmp_path / "a.glb")).notes] == ["animation-pointer"]


def test_rotations_take_the_shorter_arc_at_constant_speed(tmp_path):
    s = square()
    q = np.stack([turn(0, 0.3), -turn(1, 2.5), turn(2, 1)])
    s.animate((0, "rotation", [0, 1, 3], q, "LINEAR"))
    clip = read_clip(s.save(tmp_path / "a.glb"))
    expected = Slerp([0, 1, 3], Rotation.from_quat(q))(np.arange(len(clip)) / clip.fps).as_matrix()
    assert np.abs(clip.joints[:, 0, :3, :3] - expected).max() < 1e-6


def test_the_animated_skin_is_posed_exactly_as_the_file_says(tmp_path):
    """Every vertex of every frame against the definition in the glTF specification, computed one by one."""
    s = skinned()
    path = s.save(tmp_path / "a.glb")
    rig, clip = read_rig(path), read_clip(path)
    assert clip.fps == 24
    posed = rig.pose(clip.values, clip.joints)
    root, _ = contents(path)

    def stored(index, width):
        accessor = root["accessors"][index]
        view = root["bufferViews"][accessor["bufferView"]]
        dtype = {5126: "<f4", 5121: "u1"}[accessor["componentType"]]
        flat = np.frombuffer(s.binary, dtype, accessor["count"] * width, view["byteOffset"])
        return flat.reshape(-1, width).astype(float)

    face, eye = (mesh["primitives"][0] for mesh in root["meshes"])
    joints, weights = stored(face["attributes"]["JOINTS_0"], 4).astype(int), stored(face["attributes"]["WEIGHTS_0"], 4)
    inverse = stored(root["skins"][0]["inverseBindMatrices"], 16).reshape(-1, 4, 4).swapaxes(1, 2)
    samplers = root["animations"][0]["samplers"]
    turned, shifted = stored(samplers[0]["output"], 4), stored(samplers[1]["output"], 3)
    shapes = stored(samplers[2]["output"], 1).reshape(5, 2)
    nodes = root["nodes"]
    assert len(clip) == 5
    for f in range(5):
        hips = matrix(shifted[f], scale=nodes[0]["scale"])
        neck = hips @ matrix(nodes[1]["translation"], turned[f] / np.linalg.norm(turned[f]))
        head = neck @ np.reshape(nodes[2]["matrix"], (4, 4)).T
        for v in range(4):
            local = stored(face["attributes"]["POSITION"], 3)[v]
            local = local + sum(shapes[f, k] * stored(face["targets"][k]["POSITION"], 3)[v] for k in range(2))
            bones = [m @ i for m, i in zip((neck, head), inverse, strict=True)]
            total = sum(weights[v, i] * bones[joints[v, i]] for i in range(4)) / weights[v].sum()
            assert np.abs(posed[f, v] - (total @ [*local, 1])[:3]).max() < 1e-9
            local = (
                stored(eye["attributes"]["POSITION"], 3)[v] + shapes[f, 0] * stored(eye["targets"][0]["POSITION"], 3)[v]
            )
            expected = head @ matrix(nodes[4]["translation"]) @ [*local, 1]
            assert np.abs(posed[f, 4 + v] - expected[:3]).max() < 1e-9


def test_two_skins_that_bind_a_joint_differently_are_both_right_at_rest(tmp_path):
    s = skinned()
    inverse = np.stack([matrix((0.5, 0, 0)), matrix((0, 0.5, 0))])
    s.add(
        "skins", {"joints": [2, 1], "inverseBindMatrices": s.array(np.float32(inverse.swapaxes(1, 2).reshape(2, 16)))}
    )
    s.node(mesh=0, skin=1, name="again")
    rig = read_rig(s.save(tmp_path / "a.glb"))
    assert rig.skeleton.names == ("neck", "mixamorig:Head", "mixamorig:Head", "neck", "eye")
    assert np.abs(rig.pose(np.zeros(2), np.array(rig.skeleton.rest)) - rig.neutral.vertices).max() < 1e-12


@pytest.mark.real
def test_the_animated_adult_plays_the_weights_of_its_take(data):
    clip = read_clip(data / "clips" / "adult_plays_S07.glb")
    with (data / "clips" / "livelink" / "S07-001.csv").open(encoding="utf-8-sig") as file:
        rows = [row for row in csv.reader(file) if row]
    column = {name.lower(): i for i, name in enumerate(rows[0])}
    expected = [[float(row[column[name.lower()]]) for name in clip.names] for row in rows[1:]]
    assert (len(clip), clip.fps) == (2028, 30)
    assert np.abs(clip.values - expected).max() < 1e-6
