"""Slits are found from landmarks, and what went to their other side is brought back."""

from __future__ import annotations

import numpy as np

from mien.core import SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.core.units import face_radius
from mien.rigging.warp_and_stick.sheet import Sheet
from mien.rigging.warp_and_stick.sides import righted, sides, slits_of
from tests.rigging.test_dense import slit_sheet, wrong_sides

NOBODY = np.empty((0, 2), np.int64)
SPOTS = [(-0.045, -0.045), (0.045, -0.045), (0.045, 0.045), (-0.045, 0.045), (-0.0275, 0.0), (0.0275, 0.0)]
EDGES = [(-0.004, 0.003), (0.004, 0.003), (-0.004, -0.003), (0.004, -0.003)]


def face() -> tuple[Sheet, SurfacePoints, Ints, float]:
    """The slit sheet with landmarks around it, at its ends, and two on each side of it."""
    mesh, truth = slit_sheet(0.0)
    flat: Floats = mesh.vertices[:, :2]
    found = [int(((flat - spot) ** 2).sum(axis=1).argmin()) for spot in SPOTS]
    for spot in EDGES:
        own = np.flatnonzero(truth == np.sign(spot[1]))
        found.append(int(own[((flat[own] - spot) ** 2).sum(axis=1).argmin()]))
    marks = SurfacePoints.at_vertices(np.array(found))
    return Sheet.of(mesh.vertices, mesh.triangles, NOBODY), marks, truth, face_radius(marks.of(mesh.vertices))


def test_a_slit_has_the_landmarks_above_it_on_one_side_and_those_below_on_the_other() -> None:
    sheet, marks, _, radius = face()
    slits = slits_of(sheet, marks, radius)
    assert [{tuple(np.sort(side).tolist()) for side in slit} for slit in slits] == [{(6, 7), (8, 9)}]


def test_an_uncut_sheet_has_no_slits() -> None:
    sheet, marks, _, radius = face()
    open_part = marks.take(np.arange(6))
    assert slits_of(sheet, open_part, radius) == []


def test_sides_are_those_of_the_slit() -> None:
    sheet, marks, truth, radius = face()
    slits = slits_of(sheet, marks, radius)
    upper_first = 6 in slits[0][0]
    found = sides(sheet, marks, slits, radius)[0] * (1 if upper_first else -1)
    clear = (truth != 0) & (np.abs(sheet.vertices[:, 0]) < 0.008)
    assert (found[clear] * truth[clear] > 0).all()


def test_points_on_the_wrong_side_are_brought_back_and_no_others() -> None:
    sheet, marks, truth, radius = face()
    own = sides(sheet, marks, slits_of(sheet, marks, radius), radius)
    places = SurfacePoints.at_vertices(np.arange(len(sheet.vertices)))
    above = np.flatnonzero((truth > 0) & (np.abs(sheet.vertices[:, 0]) < 0.008))
    below = marks.corners[8]
    corners = places.corners.copy()
    corners[above] = below
    astray = SurfacePoints(corners, places.weights)
    back, changed = righted(sheet, own, sheet, own, astray, np.ones(len(truth), np.bool_))
    assert changed == wrong_sides(astray, truth, truth) == len(above)
    assert wrong_sides(back, truth, truth) == 0
    np.testing.assert_allclose(back.of(sheet.vertices)[above], sheet.vertices[above], atol=1e-12)
    untouched = np.setdiff1d(np.arange(len(truth)), above)
    np.testing.assert_array_equal(back.corners[untouched], astray.corners[untouched])
