from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.core import InputError
from mien.geometry.align import head_motion, inverse_rigid, nearest_rotations, similarity, transform


def test_a_similarity_is_recovered(rng: np.random.Generator) -> None:
    points, turn = rng.normal(size=(20, 3)), Rotation.random(random_state=1).as_matrix()
    found = similarity(points, 3.5 * points @ turn.T + [1, 2, 3])
    assert found.scale == pytest.approx(3.5)
    assert np.allclose(found.rotation, turn)
    assert found.residual < 1e-7
    assert np.allclose(found.invert(found.apply(points)), points)


def test_a_mirror_image_shows_in_the_residuals(rng: np.random.Generator) -> None:
    points = rng.normal(size=(20, 3))
    found = similarity(points, points * [-1, 1, 1])
    assert found.mirrored_residual < 1e-6 < 0.3 < found.residual
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_rigid_motion_is_carried_into_the_other_space(rng: np.random.Generator) -> None:
    points, turn = rng.normal(size=(20, 3)), Rotation.random(random_state=2).as_matrix()
    found = similarity(points, 0.5 * points @ turn.T + [1, 0, 0])
    motion = np.eye(4)[None].repeat(2, axis=0)
    motion[1, :3, :3], motion[1, :3, 3] = Rotation.random(random_state=3).as_matrix(), [0.1, 0.2, 0.3]
    there = found.conjugate(motion)
    moved = transform(there, found.apply(points))
    assert np.allclose(moved[1], found.apply(transform(motion, points)[1]))
    assert np.allclose(transform(inverse_rigid(motion), transform(motion, points)), points)


def test_few_coplanar_or_coinciding_pairs_are_refused(rng: np.random.Generator) -> None:
    points = rng.normal(size=(10, 3))
    for bad, why in ((points[:3], "too few"), (points * [1, 0, 1], "one plane"), (points * 0, "coincide")):
        with pytest.raises(InputError, match=why):
            similarity(bad, points[: len(bad)])


def test_head_motion_is_found_under_a_moving_jaw(rng: np.random.Generator) -> None:
    face = rng.normal(size=(40, 3)) * 0.05
    turns = Rotation.from_euler("xyz", rng.uniform(-0.3, 0.3, (25, 3)))
    shifts = rng.normal(size=(25, 3)) * 0.1
    opened = np.repeat(face[None], 25, axis=0)
    opened[:, :12, 1] -= rng.uniform(0.01, 0.03, 25)[:, None]
    points = opened @ np.swapaxes(turns.as_matrix(), 1, 2) + shifts[:, None]
    points[3, 20:24] = np.nan
    motion, residuals = head_motion(face, points, np.ones(40), softness=0.0015)
    error = Rotation.from_matrix(motion[:, :3, :3]) * turns.inv()
    assert error.magnitude().max() < 1e-3
    assert np.abs(motion[:, :3, 3] - shifts).max() < 2e-4
    assert np.isnan(residuals[3, 20:24]).all()


def test_a_frame_that_sees_nothing_keeps_the_motion_before(rng: np.random.Generator) -> None:
    face = rng.normal(size=(10, 3))
    points = np.stack([face, face + 1, np.full_like(face, np.nan), face])
    motion, _ = head_motion(face, points, np.ones(10), softness=0.1)
    assert np.allclose(motion[2], motion[1])
    assert np.allclose(motion[1, :3, 3], 1)


def test_the_nearest_rotations_are_those_of_the_singular_values(rng: np.random.Generator) -> None:
    matrices = rng.normal(size=(300, 3, 3)) * np.geomspace(1e-9, 1e9, 300)[:, None, None]
    matrices[::7, :, 2] *= 1e-9
    left, _, right = np.linalg.svd(matrices)
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    found = nearest_rotations(matrices)
    assert np.abs(found - left @ right).max() < 1e-9
    assert np.abs(np.linalg.det(found) - 1).max() < 1e-12


def test_what_has_no_nearest_rotation_still_gets_one() -> None:
    found = nearest_rotations(np.stack([np.zeros((3, 3)), np.diag([1.0, 0, 0]), np.diag([1.0, 1, -1])]))
    assert np.abs(found @ np.swapaxes(found, 1, 2) - np.eye(3)).max() < 1e-12
    assert np.allclose(np.linalg.det(found), 1)


def test_a_head_far_from_the_origin_moves_alike(rng: np.random.Generator) -> None:
    face = rng.normal(size=(20, 3))
    points = face + 0.1 * rng.normal(size=(5, 20, 3))
    near, _ = head_motion(face, points, np.ones(20), softness=0.1)
    far, _ = head_motion(face + 1000, points + 1000, np.ones(20), softness=0.1)
    assert np.abs(near[:, :3, :3] - far[:, :3, :3]).max() < 1e-9
