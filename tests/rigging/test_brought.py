"""Eyes, teeth and tongue for a face without: as they sat where they come from, and inside the head."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import Rig
from mien.core.arrays import Floats
from mien.geometry.surface import closest_points, triangle_normals
from mien.library.generic import generic_rig
from mien.library.heads import tortoise_head
from mien.rigging.dense import lay
from mien.rigging.eyeballs import Ball, ball_of, fitted_ball
from mien.rigging.landmarks import paired_landmarks
from mien.rigging.structure import Structure
from mien.rigging.transfer import Transfer, transfer_rig
from mien.rigging.tucking import tucked_in
from tests.rigging.moved import skin_only

MILLIMETRE = 0.001


@pytest.fixture(scope="module")
def generic() -> Rig:
    return generic_rig()


@pytest.fixture(scope="module")
def moved(generic: Rig) -> Transfer:
    return transfer_rig(generic, skin_only())


def test_what_a_face_lacks_comes_back_to_where_it_was(generic: Rig, moved: Transfer) -> None:
    was = generic.neutral.vertices[moved.brought.vertices]
    apart = np.linalg.norm(moved.brought.places - was, axis=1)
    assert len(was) == sum(len(generic.neutral.groups[name]) for name in ("eye_left", "eye_right", "teeth", "tongue"))
    assert apart.max() < 2 * MILLIMETRE
    assert [note.code for note in moved.notes] == ["parts-brought"]


def test_a_brought_part_keeps_its_form(generic: Rig, moved: Transfer) -> None:
    own = {int(v): k for k, v in enumerate(moved.brought.vertices)}
    for name in ("eye_left", "teeth_upper", "tongue"):
        ids = generic.neutral.groups[name]
        was, now = generic.neutral.vertices[ids], moved.brought.places[[own[int(v)] for v in ids]]
        ratio = _distances(now) / _distances(was)
        assert np.ptp(ratio) < 1e-9


def test_nothing_is_brought_where_nothing_lacks(generic: Rig) -> None:
    assert not len(transfer_rig(generic, skin_only(), parts="none").brought.vertices)
    assert not len(transfer_rig(generic, tortoise_head()).brought.vertices)


def test_a_ball_is_told_from_what_is_none(generic: Rig) -> None:
    eye, teeth = (generic.neutral.vertices[generic.neutral.groups[name]] for name in ("eye_left", "teeth_upper"))
    ball = ball_of(eye)
    assert ball is not None
    assert ball.radius == pytest.approx(0.0172, abs=5e-4)
    assert ball_of(teeth) is None


def test_an_eyeball_finds_its_place_under_lids_that_were_made_for_another_size(generic: Rig) -> None:
    """The face's own eyes are the truth: left out, and found again from the lids."""
    face = tortoise_head()
    pairs = paired_landmarks(generic, face)
    fit = lay(generic.neutral, pairs.source, face.neutral, pairs.target)
    true = ball_of(face.neutral.vertices[face.neutral.groups["eye_left"]])
    given = ball_of(generic.neutral.vertices[generic.neutral.groups["eye_left"]])
    assert true is not None
    assert given is not None
    structure = Structure.of(fit)
    found = fitted_ball(given, fit, structure)
    plain = Ball(structure.warp(given.centre[None])[0], structure.around(given.centre)[1] * given.radius)
    assert abs(found.radius / true.radius - 1) < 0.1
    assert _off(found, true) < 0.35 * true.radius
    assert _off(found, true) < 0.6 * _off(plain, true)


def test_teeth_that_stand_out_of_the_lips_are_drawn_back(generic: Rig, moved: Transfer) -> None:
    teeth = generic.neutral.vertices[generic.neutral.groups["teeth_upper"]] + [0, 0, 0.03]
    assert _outside(teeth, moved) > 5 * MILLIMETRE
    (tucked,), shrunk = tucked_in([teeth], moved.fit)
    assert _outside(tucked, moved) < 0
    assert 0.3 < shrunk < 1


def _distances(points: Floats) -> Floats:
    step = np.roll(points, 1, axis=0) - points
    length = np.linalg.norm(step, axis=1)
    return np.asarray(length[length > 1e-6])


def _off(ball: Ball, true: Ball) -> float:
    return float(np.linalg.norm(ball.centre - true.centre))


def _outside(points: Floats, moved: Transfer) -> float:
    """How far the farthest of some points stands out of the front of the face."""
    mesh = moved.fit.target
    inside = np.zeros(len(mesh.vertices), np.bool_)
    for name in ("mouth", "nostril_left", "nostril_right"):
        inside[mesh.groups[name]] = True
    triangles = mesh.triangles[~inside[mesh.triangles].any(axis=1)]
    nearest, _, which = closest_points(mesh.vertices, triangles, points)
    normals = triangle_normals(mesh.vertices, triangles)[which]
    return float(((points - nearest.of(mesh.vertices)) * normals).sum(axis=1).max())
