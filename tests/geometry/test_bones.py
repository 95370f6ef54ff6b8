"""Posed bones against matrices multiplied out one by one, and their derivatives against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.core import InputError, Skeleton, SurfacePoints
from mien.geometry.bones import Bones, CarriedPoints, parents_first
from tests.retargeting.actors import points_on
from tests.retargeting.bone_face import POINTS, POSES, bone_face, bones, posed, poses


def test_a_parameter_at_one_is_its_pose_and_at_zero_nothing():
    known = bones()
    expected = poses(known.skeleton)
    assert np.allclose(known.world(np.eye(len(POSES))), [expected[name] for name in POSES], atol=1e-12)
    assert np.array_equal(known.world(np.zeros(len(POSES))), known.skeleton.rest)


def test_half_a_pose_is_half_of_every_turn():
    known = bones()
    half = posed(known.skeleton, {"jaw": ((0.3, 0, 0), (0, 0, 0)), "lip": ((-0.2, 0, 0), (0, 0.001, 0))})
    assert np.allclose(known.world(0.5 * np.eye(len(POSES))[0]), half, atol=1e-12)


def test_poses_of_the_same_joint_add_up():
    known = bones()
    both = {"jaw": ((0.6 - 0.05, 0, 0), (0, 0, 0)), "lip": ((-0.4 + 0.9, 0, 0), (0, 0.002, 0.006))}
    assert np.allclose(known.world(np.array([1, 1, 0, 0, 0, 0, 0.0])), posed(known.skeleton, both), atol=1e-12)


def test_points_are_carried_as_the_rig_is_posed(rng):
    rig, known = bone_face(), bones()
    triangles = rng.integers(0, len(rig.neutral.triangles), 30)
    points = SurfacePoints(rig.neutral.triangles[triangles], rng.dirichlet([1, 1, 1], 30))
    carried = CarriedPoints.of(rig, points, known)
    weights = rng.uniform(0, 1, (4, len(POSES)))
    expected = points.of(rig.pose(np.zeros((4, 0)), known.world(weights)))
    assert np.allclose(carried.at(weights), expected, atol=1e-13)
    assert np.allclose(carried.around(weights[0])[0], expected[0], atol=1e-13)
    assert np.allclose(carried.rest, points.of(rig.neutral.vertices), atol=1e-13)


@pytest.mark.parametrize("size", [0.0, 1e-5, 0.7, 3.0])
def test_derivatives_are_those_of_differences(rng, size):
    rig = bone_face()
    turns, moves = rng.normal(0, 1, (2, 6, len(rig.skeleton.names), 3)) * [[[[0.7]]], [[[0.01]]]]
    known = Bones(tuple("abcdef"), rig.skeleton, turns, moves)
    carried = CarriedPoints.of(rig, points_on(rig, POINTS), known)
    weights, step = size * rng.uniform(-1, 1, 6), 1e-6
    _, slopes = carried.around(weights)
    differences = [(carried.at(weights + step * e) - carried.at(weights - step * e)) / (2 * step) for e in np.eye(6)]
    assert np.abs(slopes - differences).max() < 1e-9 < np.abs(slopes).max()


def test_a_skin_bound_in_another_pose_is_carried_too(rng):
    rig, known = bone_face(), bones()
    bound = np.linalg.inv(rig.skeleton.rest)
    bound[:, :3, 3] += 0.01 * rng.normal(size=(len(bound), 3))
    other = replace(rig, skin=replace(rig.skin, inverse_bind=bound))
    weights = rng.uniform(0, 1, len(POSES))
    carried = CarriedPoints.of(other, points_on(other, POINTS), known)
    expected = points_on(other, POINTS).of(other.pose(np.zeros(0), known.world(weights)))
    assert np.allclose(carried.at(weights), expected, atol=1e-13)


def test_poses_go_to_a_bigger_skeleton_by_the_names_of_its_joints():
    rig, known = bone_face(), bones()
    order = np.argsort(rig.skeleton.names)
    rest = rig.skeleton.rest[order].copy()
    rest[:, :3, 3] *= 2
    parents = np.array([-1 if p < 0 else int(np.flatnonzero(order == p)[0]) for p in rig.skeleton.parents[order]])
    other = Skeleton(tuple(np.array(rig.skeleton.names)[order]), parents, rest)
    there = known.on(other).world(np.eye(len(POSES)))
    here = known.world(np.eye(len(POSES)))[:, order]
    assert np.allclose(there[..., :3, :3], here[..., :3, :3], atol=1e-12)
    assert np.allclose(there[..., :3, 3], 2 * here[..., :3, 3], atol=1e-12)
    fewer = Skeleton(other.names[:3], np.array([-1, 0, 0]), rest[:3])
    with pytest.raises(InputError, match="lacks"):
        known.on(fewer)


def test_joints_come_after_their_parents_and_a_ring_is_refused():
    order = parents_first(bones().skeleton.parents)
    assert all(p < 0 or order.index(p) < order.index(j) for j, p in enumerate(bones().skeleton.parents))
    with pytest.raises(InputError, match="hang on each other"):
        parents_first(np.array([-1, 2, 1]))


def test_a_joint_without_extent_cannot_pose():
    skeleton = bones().skeleton
    flat = skeleton.rest.copy()
    flat[2, :3, :3] = 0
    with pytest.raises(InputError, match="'jaw' has no extent"):
        Bones.of_poses(replace(skeleton, rest=flat), {"a": flat})


def test_rounding_in_a_file_poses_no_joint():
    skeleton = bones().skeleton
    pose = poses(skeleton)["smile_L"].copy()
    pose[5, :3, :3] = pose[5, :3, :3] @ Rotation.from_rotvec([1e-6, 0, 0]).as_matrix()
    known = Bones.of_poses(skeleton, {"smile": pose})
    assert [skeleton.names[j] for j in known.moved] == ["cheek_L"]
