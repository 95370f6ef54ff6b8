"""The generic rig's muscles and expressions, as a face would be judged: nothing torn, nothing through an eye."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import Rig
from mien.core.anatomy import Anatomy
from mien.core.arrays import Floats, Ints
from mien.geometry.muscles import on_polyline
from mien.geometry.puppet import Puppet, controls_of
from mien.geometry.templates import played, template_controls, template_shapes
from mien.library.expressions import BASES, SCRIPTS, recipes
from mien.library.generic import generic_rig
from mien.library.generic.head import build
from mien.library.generic.proportions import GENERIC
from mien.library.modelling.half import Head
from mien.vocabularies.arkit import ARKIT_NAMES
from mien.vocabularies.expressions import BLINKS, EMOTIONS, NEUTRAL, PRIMARIES, VISEMES
from mien.vocabularies.facs import ACTION_UNITS, FAIGIN, parsed_code

MILLIMETRE = 1e-3


@pytest.fixture(scope="module")
def rig() -> Rig:
    return generic_rig()


@pytest.fixture(scope="module")
def head() -> Head:
    return build(GENERIC)


@pytest.fixture(scope="module")
def anatomy(rig: Rig) -> Anatomy:
    assert rig.anatomy is not None
    return rig.anatomy


@pytest.fixture(scope="module")
def poses(rig: Rig, anatomy: Anatomy) -> dict[str, Floats]:
    """Every template at full strength, on top of its base."""
    puppet = Puppet.of(rig)
    whole = {name: {name: 1.0} | ({BASES[name]: 1.0} if name in BASES else {}) for name in anatomy.templates}
    return {name: puppet.posed(template_controls(rig, weights)) for name, weights in whole.items()}


def slit_pairs(rig: Rig) -> Ints:
    """Vertices of the upper and the lower lip that touch at rest."""
    upper, lower = rig.neutral.groups["upper_lip"], rig.neutral.groups["lower_lip"]
    gaps = np.linalg.norm(rig.neutral.vertices[upper][:, None] - rig.neutral.vertices[lower], axis=2)
    touching = gaps.min(axis=1) < 0.3 * MILLIMETRE
    assert touching.sum() > 10
    return np.stack([upper[touching], lower[gaps.argmin(axis=1)[touching]]], axis=1)


def test_every_name_of_the_vocabularies_is_a_template(anatomy: Anatomy) -> None:
    assert set(anatomy.templates) == {NEUTRAL, *ARKIT_NAMES, *EMOTIONS, *VISEMES, *BLINKS}


def test_every_template_but_the_neutral_moves_the_face(rig: Rig, poses: dict[str, Floats]) -> None:
    for name, points in poses.items():
        moved = np.abs(points - rig.neutral.vertices).max()
        assert (moved == 0) if name == NEUTRAL else (moved > MILLIMETRE), name


def test_the_eleven_muscles_are_there_and_lie_in_pairs(anatomy: Anatomy) -> None:
    laid = {muscle.name for muscle in anatomy.muscles}
    stems = {"depressor labii inferioris": "depressor_labii", "levator labii superioris": "levator_labii"}
    for name in FAIGIN:
        stem = stems.get(name, name.replace(" ", "_"))
        assert any(muscle.startswith(stem) for muscle in laid), name
    assert len(FAIGIN) == 11
    for name in laid:
        assert not name.endswith("_left") or name[:-4] + "right" in laid
    assert {unit for units in FAIGIN.values() for unit in units} <= set(ACTION_UNITS)


def test_templates_are_written_in_known_action_units_and_controls(rig: Rig, anatomy: Anatomy) -> None:
    for units in recipes().values():
        assert all(parsed_code(code)[1].strip("TB") in ACTION_UNITS and 0 < v <= 1 for code, v in units.items())
    assert {control for template in anatomy.templates.values() for control in template} <= set(controls_of(rig))


def test_closed_lids_meet_along_the_whole_slit(head: Head, poses: dict[str, Floats]) -> None:
    points = poses["blink_closed"]
    for side in ("left", "right"):
        upper, lower = (points[head.groups[f"{lid}_lid_{side}"]] for lid in ("upper", "lower"))
        for lid, other in ((upper, lower), (lower, upper)):
            edge = other[np.argsort(other[:, 0])]
            inner = lid[(lid[:, 0] >= edge[0, 0]) & (lid[:, 0] <= edge[-1, 0])]
            assert len(inner) >= len(lid) - 2
            gaps = np.linalg.norm(inner - on_polyline(edge, inner)[2], axis=1)
            assert gaps.max() < 0.1 * MILLIMETRE


def test_no_skin_enters_an_eyeball(head: Head, poses: dict[str, Floats]) -> None:
    parts = [head.groups[name] for name in ("eye_left", "eye_right", "teeth", "tongue")]
    skin = np.setdiff1d(np.arange(len(head.vertices)), np.concatenate(parts))
    for name, points in poses.items():
        for side in (1, -1):
            centre = np.multiply(GENERIC.eye.centre, [side, 1, 1]) * 0.01
            depth = GENERIC.eye.radius * 0.01 - np.linalg.norm(points[skin] - centre, axis=1)
            assert depth.max() < 0.1 * MILLIMETRE, name


def test_eyes_and_teeth_move_rigidly(rig: Rig, poses: dict[str, Floats]) -> None:
    for part in ("eye_left", "eye_right", "teeth_upper", "teeth_lower"):
        ids = rig.neutral.groups[part]
        rest = rig.neutral.vertices[ids]
        for name, points in poses.items():
            a, b = rest - rest.mean(axis=0), points[ids] - points[ids].mean(axis=0)
            u, _, v = np.linalg.svd(a.T @ b)
            assert np.abs(a @ (u @ v) - b).max() < 1e-9, (part, name)


def test_the_right_template_is_the_mirror_image_of_the_left(head: Head, poses: dict[str, Floats]) -> None:
    for name in ARKIT_NAMES:
        if name.endswith("Left"):
            mirrored = poses[name][head.mirror] * [-1, 1, 1]
            assert np.abs(mirrored - poses[name[:-4] + "Right"]).max() < 1e-12, name


def test_expressions_of_both_sides_are_symmetric(head: Head, poses: dict[str, Floats]) -> None:
    one_sided = {"contempt", "disapproval"}
    for name in {*EMOTIONS, *VISEMES, *BLINKS} - one_sided:
        assert np.abs(poses[name][head.mirror] * [-1, 1, 1] - poses[name]).max() < 1e-12, name


def test_lips_meet_where_the_sound_or_the_flexor_closes_them(rig: Rig, poses: dict[str, Floats]) -> None:
    upper, lower = slit_pairs(rig).T
    for name in ("viseme_PP", "mouthClose"):
        assert np.linalg.norm(poses[name][upper] - poses[name][lower], axis=1).max() < 0.3 * MILLIMETRE
    apart = np.linalg.norm(poses["jawOpen"][upper] - poses["jawOpen"][lower], axis=1)
    assert apart.max() > 20 * MILLIMETRE


def test_the_tongue_alone_moves_when_it_is_shown(rig: Rig) -> None:
    """The jaw has a shape of its own, and both are played together."""
    shown = np.linalg.norm(template_shapes(rig, ["tongueOut"]).deltas[0], axis=1)
    tongue = rig.neutral.groups["tongue"]
    assert shown[tongue].max() > 30 * MILLIMETRE
    assert np.delete(shown, tongue).max() < 0.1 * MILLIMETRE


def test_degrees_of_an_emotion_grow(rig: Rig, poses: dict[str, Floats]) -> None:
    for primary, degrees in PRIMARIES.items():
        sizes = [float(np.linalg.norm(poses[name] - rig.neutral.vertices)) for name in degrees]
        assert sizes == sorted(sizes), primary


def test_muscles_of_one_lip_leave_the_other(rig: Rig, anatomy: Anatomy) -> None:
    weights = {muscle.name: muscle.weights for muscle in anatomy.muscles}
    assert not weights["levator_labii_left"][rig.neutral.groups["lower_lip"]].any()
    assert not weights["depressor_labii_left"][rig.neutral.groups["upper_lip"]].any()


def test_shapes_are_what_templates_add(rig: Rig, poses: dict[str, Floats]) -> None:
    shapes = template_shapes(rig, ["mouthClose", "jawOpen", "joy"])
    assert np.allclose(shapes.deltas[0], poses["mouthClose"] - poses["jawOpen"])
    assert np.allclose(shapes.deltas[2], poses["joy"] - rig.neutral.vertices)


def test_scripts_start_and_end_at_rest_and_play_on_the_rig(rig: Rig) -> None:
    assert {"sentence", "range_of_motion"} <= set(SCRIPTS)
    for script in SCRIPTS.values():
        values = played(rig, script)
        assert values.shape == (len(script), len(controls_of(rig)))
        assert not values[[0, -1]].any()
        assert script.values.max() <= 1
    assert set(SCRIPTS["range_of_motion"].names) == set(ARKIT_NAMES)


def test_stress_is_felt_where_muscles_end_and_nowhere_on_the_neck(rig: Rig, anatomy: Anatomy) -> None:
    stress = anatomy.fields["muscle_stress"]
    assert stress.min() >= 0
    assert stress[rig.neutral.groups["neck"]].max() == 0
    assert stress[rig.neutral.groups["lip_corner_left"]].min() > 0.2
