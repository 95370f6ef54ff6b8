"""Faces driven by their bones: known motion comes back, and the solve is the optimum of what it says it solves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from mien.core import InputError
from mien.retargeting import make_method
from mien.retargeting.bone_solver import BoneSolver, on_bones
from mien.retargeting.bones import free_bones, with_bone_shapes
from tests.retargeting.actors import at_rest, face, pairs_of, points_on
from tests.retargeting.bone_face import POINTS, POSES, bone_face, bones, curves, performed, played

EXACT = {"sparsity": 0.0, "damping": 0.0, "smooth": 0.0, "unseen": False}


def fitted(method="direct", settings=EXACT, known=None, **conditions):
    """The method on the chords of the bones, and on the bones themselves."""
    rig, known = bone_face(), known or bones()
    points = points_on(rig, POINTS)
    take = performed(curves(), **conditions)
    shown = with_bone_shapes(rig, known)
    neutral = at_rest(rig, points, conditions.get("scale", 1.0))
    head = bool(conditions.get("head", False))
    straight = make_method(method, settings).fit(shown, take, pairs_of(points), neutral=neutral, head_moves=head)
    return take, straight, on_bones(straight, rig, pairs_of(points), known)


def test_a_shape_is_the_skin_in_its_pose():
    rig, known = bone_face(), bones()
    shown = with_bone_shapes(rig, known)
    assert shown.blendshapes.names == POSES
    expected = rig.pose(np.zeros((len(POSES), 0)), known.world(np.eye(len(POSES))))
    assert np.allclose(shown.pose(np.eye(len(POSES))), expected, atol=1e-12)


def test_known_motion_of_bones_comes_back_exactly_where_chords_do_not():
    take, straight, turning = fitted(scale=100.0)
    truth = curves()
    errors = [np.abs(method.retarget(take)[0].values - truth).max() for method in (straight, turning)]
    assert errors[1] < 2e-4 < 0.05 < errors[0]


@pytest.mark.parametrize(("method", "most"), [("rbf", 0.2), ("range-of-motion", 0.3)])
def test_the_default_solve_puts_vertices_within_a_fraction_of_a_millimetre(method, most):
    settings = {"ahead": False, **({"full_range": False} if method == "range-of-motion" else {})}
    take, straight, turning = fitted(method, settings, scale=1000.0, noise=0.0002)
    rig, known, truth = bone_face(), bones(), played(curves())
    right = rig.pose(np.zeros((len(truth), 0)), truth.joints)
    moved = np.linalg.norm(right - rig.neutral.vertices, axis=2) > 0.0005
    errors = []
    for fit in (straight, turning):
        found = rig.pose(np.zeros((len(truth), 0)), known.world(fit.retarget(take)[0].values))
        errors.append(1000 * np.linalg.norm(found - right, axis=2)[moved].mean())
    assert errors[1] < most
    assert errors[1] < 0.6 * errors[0]


def test_a_take_and_its_frames_one_by_one_are_the_same():
    take, _, turning = fitted(settings={}, head=True)
    whole = turning.retarget(take)[0].values
    state = turning.start()
    for frame, expected in zip(take.points[:60], whole, strict=False):
        state, weights = turning.step(state, frame)
        assert np.abs(weights - expected).max() < 1e-9


def test_the_model_of_the_actor_has_the_slopes_it_is_solved_with(rng):
    _, _, turning = fitted("rbf")
    solver, weights, step = turning.solver, rng.uniform(0, 1, len(POSES)), 1e-6
    points, slopes = solver.around(weights)
    assert np.allclose(points, solver.displaced(weights), atol=1e-12)
    there = [solver.displaced(weights + step * e) - solver.displaced(weights - step * e) for e in np.eye(len(POSES))]
    assert np.abs(slopes - np.array(there) / (2 * step)).max() < 1e-7


def test_the_solve_ends_where_the_energy_of_the_bones_is_least(rng):
    settings = {"sparsity": 0.0, "damping": 0.02, "smooth": 0.05, "bounds": None, "unseen": False}
    take, _, turning = fitted("rbf", settings)
    solver = turning.solver
    assert isinstance(solver, BoneSolver)
    moved, _ = turning.displacements(take.points)
    before, frame = solver.step(moved[40], None, 60.0), moved[48]
    weights = solver.step(frame, before, 60.0)

    def energy(w):
        follow = solver.settings.smooth * (60 / 30) ** 2 * ((w - before) ** 2).sum()
        fit = ((frame - solver.displaced(w)) ** 2).sum() / len(frame)
        return fit + 0.5 * w @ solver.regular @ w + follow

    best = minimize(energy, weights, tol=1e-12).x
    assert energy(weights) - energy(best) < 1e-4 * (energy(before) - energy(best))
    assert np.abs(weights - best).max() < 1e-2


def test_lost_markers_are_left_out_and_a_blind_frame_holds():
    take, _, turning = fitted()
    points = take.points.copy()
    points[30:60, ::5] = np.nan
    points[70] = np.nan
    found = turning.retarget(replace(take, points=points))[0].values
    assert np.abs(found[30:60] - curves()[30:60]).max() < 2e-3
    assert np.array_equal(found[70], found[69])


def test_free_bones_are_those_of_the_face():
    rig = bone_face()
    known = free_bones(rig, pairs_of(points_on(rig, POINTS)))
    moved = {name.split(".")[0] for name in known.names}
    assert moved == {"jaw", "lip", "cheek_L", "cheek_R", "lid_L", "lid_R", "brow"}
    assert "jaw.turn_x" in known.names
    assert "jaw.move_x" not in known.names  # far from what it moves, it only turns
    assert known.two_sided


def test_free_bones_find_a_motion_that_no_pose_names():
    rig = bone_face()
    known = free_bones(rig, pairs_of(points_on(rig, POINTS)))
    settings = {"bounds": (-1.0, 1.0), "damping": 0.001, "sparsity": 0.0, "smooth": 0.0}
    take, straight, turning = fitted(settings=settings, known=known)
    right = rig.pose(np.zeros((len(take), 0)), played(curves()).joints)
    moved = np.linalg.norm(right - rig.neutral.vertices, axis=2) > 0.0005
    errors = []
    for fit in (straight, turning):
        found = rig.pose(np.zeros((len(take), 0)), known.world(fit.retarget(take)[0].values))
        errors.append(1000 * np.linalg.norm(found - right, axis=2)[moved].mean())
    assert errors[1] < 0.25
    assert errors[1] < 0.7 * errors[0]


def test_a_face_without_bones_of_its_own_is_refused():
    rig = face()
    with pytest.raises(InputError, match="no bones"):
        free_bones(rig, pairs_of(points_on(rig, POINTS)))
    stiff = bone_face()
    skin = replace(stiff.skin, weights=np.eye(len(stiff.skeleton.names))[np.ones(len(stiff.skin.weights), int)])
    with pytest.raises(InputError, match="moves a part of the face"):
        free_bones(replace(stiff, skin=skin), pairs_of(points_on(stiff, POINTS)))
