"""Meshes as they come: holes, loose parts, doubled edges, wrong units, inside out.  Said clearly, or made up for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import InputError, Mesh, Rig, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.core.rig import no_blendshapes
from mien.core.units import face_radius
from mien.geometry.templates import template_shapes
from mien.library.generic import generic_rig
from mien.library.heads import tortoise_head
from mien.rigging.transfer import Transfer, transfer_rig
from mien.rigging.warp_and_stick.folds import LEASH
from tests.rigging.moved import without

FEW = ("jawOpen", "eyeBlinkLeft", "mouthSmileLeft")


@pytest.fixture(scope="module")
def face() -> Rig:
    return tortoise_head()


@pytest.fixture(scope="module")
def plain(face: Rig) -> Transfer:
    return transfer_rig(generic_rig(), face)


def made_of(face: Rig, vertices: Floats, triangles: Ints, groups: bool = True) -> Rig:
    mesh = Mesh(vertices, triangles, groups=face.neutral.groups if groups else {})
    return Rig(mesh, no_blendshapes(len(vertices)), landmarks=face.landmarks, name="face")


def unmarked(face: Rig) -> Ints:
    """Triangles on which no landmark is."""
    marked = np.concatenate([point.corners.ravel() for point in face.landmarks.values()])
    return np.flatnonzero(~np.isin(face.neutral.triangles, marked).any(axis=1))


def shapes(moved: Transfer) -> Floats:
    return template_shapes(moved.rig, FEW).deltas


def typical(moved: Transfer, plain: Transfer, scale: float = 1.0) -> float:
    """The median difference of the shapes, as a share of the largest motion."""
    count = len(plain.fit.target.vertices)
    difference = np.linalg.norm(shapes(moved)[:, :count] / scale - shapes(plain)[:, :count], axis=2)
    return float(np.median(difference) / np.abs(shapes(plain)).max())


def test_holes_change_what_is_around_them_only(face: Rig, plain: Transfer) -> None:
    own = face.neutral
    holed = made_of(face, own.vertices, np.delete(own.triangles, unmarked(face)[::61], axis=0))
    moved = transfer_rig(generic_rig(), holed)
    assert np.isfinite(shapes(moved)).all()
    assert typical(moved, plain) < 0.01


def test_damaged_triangles_and_stray_vertices_change_nothing(face: Rig, plain: Transfer) -> None:
    own = face.neutral
    a, b, c = own.triangles[unmarked(face)[0]]
    stray = len(own.vertices)
    odd = np.array([[a, a, b], [c, c, c], [a, b, stray]])  # no area twice, and a third triangle on an edge
    extra = np.vstack([own.vertices[a] + 0.001, [9.0, 9.0, 9.0], [-9.0, 0.0, 0.0]])
    damaged = made_of(face, np.vstack([own.vertices, extra]), np.vstack([own.triangles, odd]))
    moved = transfer_rig(generic_rig(), damaged)
    assert np.isfinite(shapes(moved)).all()
    assert typical(moved, plain) < 1e-6
    skin = moved.rig.skin
    assert skin is not None
    assert np.abs(skin.weights.sum(axis=1) - 1).max() < 1e-12


def test_loose_parts_ride_along(face: Rig, plain: Transfer) -> None:
    own = face.neutral
    crumbs = own.vertices[[0, 1, 2]] + [0.0, 0.3, 0.0]
    more = made_of(
        face, np.vstack([own.vertices, crumbs]), np.vstack([own.triangles, [np.arange(3) + len(own.vertices)]])
    )
    moved = transfer_rig(generic_rig(), more)
    assert typical(moved, plain) < 1e-9
    assert np.isfinite(shapes(moved)).all()


@pytest.mark.parametrize("scale", [1024.0, 1 / 1024])
def test_a_size_that_rounds_nothing_changes_nothing_but_the_size(face: Rig, plain: Transfer, scale: float) -> None:
    moved = transfer_rig(generic_rig(), made_of(face, scale * face.neutral.vertices, face.neutral.triangles))
    assert np.abs(moved.fit.stuck / scale - plain.fit.stuck).max() < 1e-12
    assert typical(moved, plain, scale) < 1e-12
    assert {**moved.figures, "seconds": 0} == pytest.approx({**plain.figures, "seconds": 0}, abs=1e-3)


@pytest.mark.parametrize("scale", [1000.0, 0.001])
def test_other_units_change_nothing_but_the_size(face: Rig, plain: Transfer, scale: float) -> None:
    # rounding decides ties: from which neighbour a few points are laid, and in which of several ways a fold is undone
    moved = transfer_rig(generic_rig(), made_of(face, scale * face.neutral.vertices, face.neutral.triangles))
    assert typical(moved, plain, scale) < 1e-6
    away = np.linalg.norm(moved.fit.stuck / scale - plain.fit.stuck, axis=1)[plain.fit.paired]
    assert np.median(away) < 1e-12
    assert np.quantile(away, 0.99) < 2 * LEASH * face_radius(plain.fit.warp(plain.fit.warp.centres))
    assert moved.figures["landmarks"] == plain.figures["landmarks"]
    assert moved.figures["structure_rms_mm"] == pytest.approx(plain.figures["structure_rms_mm"], rel=0.25)


def test_a_face_turned_inside_out_is_noted_and_acts_the_same(face: Rig, plain: Transfer) -> None:
    moved = transfer_rig(generic_rig(), made_of(face, face.neutral.vertices, face.neutral.triangles[:, ::-1]))
    assert "inside-out" in [note.code for note in moved.notes]
    assert typical(moved, plain) < 0.02


def test_a_face_without_any_of_its_parts_is_given_them(face: Rig) -> None:
    bald = without(face, np.isin(np.arange(len(face.neutral.vertices)), face.neutral.groups["eye_left"]))
    moved = transfer_rig(generic_rig(), bald)
    assert "parts-brought" in [note.code for note in moved.notes]
    assert np.isin(moved.brought.vertices, generic_rig().neutral.groups["eye_left"]).all()


def test_landmarks_in_their_places_but_swapped_are_refused(face: Rig) -> None:
    swapped = {
        name.replace("left", "LEFT").replace("right", "left").replace("LEFT", "right"): p
        for name, p in face.landmarks.items()
    }
    sides = {"ibug_36": "ibug_45", "ibug_45": "ibug_36", "ibug_48": "ibug_54", "ibug_54": "ibug_48"}
    named = {sides.get(name, name): point for name, point in swapped.items()}
    with pytest.raises(InputError, match="swapped"):
        transfer_rig(generic_rig(), replace(face, landmarks=named))


def test_too_few_and_coinciding_landmarks_are_refused(face: Rig) -> None:
    few = dict(list(face.landmarks.items())[:2])
    with pytest.raises(InputError, match="at least 4"):
        transfer_rig(generic_rig(), replace(face, landmarks=few))
    names = list(face.landmarks)
    doubled = {**face.landmarks, names[0]: face.landmarks[names[1]]}
    with pytest.raises(InputError, match="same place"):
        transfer_rig(generic_rig(), replace(face, landmarks=doubled))


def test_a_landmark_of_another_mesh_is_named(face: Rig) -> None:
    far = {**face.landmarks, "ibug_30": SurfacePoints.at_vertices(np.array([10**6]))}
    with pytest.raises(InputError, match="ibug_30"):
        transfer_rig(generic_rig(), replace(face, landmarks=far))


def test_a_mesh_without_triangles_is_refused(face: Rig) -> None:
    with pytest.raises(InputError, match="triangle"):
        transfer_rig(generic_rig(), made_of(face, face.neutral.vertices, np.empty((0, 3), np.int64), groups=False))
