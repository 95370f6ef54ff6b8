"""Values carried to another face: exact where it is clean, relaxed where it is crumpled, never across a slit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Rig, SurfacePoints
from mien.core.arrays import Flags
from mien.library.generic import generic_rig
from mien.library.heads import cartoon_head
from mien.rigging.attributes import Carrier, strongest_joints
from mien.rigging.brought import Brought
from mien.rigging.dense import DenseFit, lay
from mien.rigging.inside import settled
from mien.rigging.landmarks import paired_landmarks
from mien.rigging.parts import attachments
from mien.rigging.roughness import Smoothing
from tests.rigging.faces import exact_fit, face_with_slit


@pytest.fixture(scope="module")
def generic() -> Rig:
    return generic_rig()


@pytest.fixture(scope="module")
def fit(generic: Rig) -> DenseFit:
    face = cartoon_head()
    pairs = paired_landmarks(generic, face)
    return lay(generic.neutral, pairs.source, face.neutral, pairs.target)


@pytest.fixture(scope="module")
def carrier(generic: Rig, fit: DenseFit) -> Carrier:
    return Carrier.of(fit, settled(fit, generic.skin, attachments(fit)), Brought.nothing())


def crumpled(fit: DenseFit, some: Flags, rng: np.random.Generator) -> DenseFit:
    """The same correspondence with the points of some vertices exchanged at random."""
    corners = np.array(fit.back.corners[:, 0])
    ids = np.flatnonzero(some)
    corners[ids] = corners[rng.permutation(ids)]
    return replace(fit, back=SurfacePoints.at_vertices(corners))


def test_a_constant_stays_that_constant(carrier: Carrier) -> None:
    assert np.abs(carrier.values(np.full(len(carrier.fit.source.vertices), 0.7)) - 0.7).max() < 1e-12


def test_values_stay_within_their_range(carrier: Carrier, rng: np.random.Generator) -> None:
    values = rng.uniform(-2, 3, len(carrier.fit.source.vertices))
    carried = carrier.values(values)
    assert carried.min() >= values.min() - 1e-12
    assert carried.max() <= values.max() + 1e-12


def test_columns_are_carried_one_by_one(carrier: Carrier, rng: np.random.Generator) -> None:
    values = rng.normal(size=(len(carrier.fit.source.vertices), 3))
    whole = carrier.values(values)
    for column in range(3):
        assert np.allclose(whole[:, column], carrier.values(values[:, column]), atol=1e-12)


def test_where_it_is_clean_a_value_is_the_one_of_its_point(carrier: Carrier, fit: DenseFit) -> None:
    values = fit.source.vertices[:, 1]
    smoothing = carrier.smoothing
    clean = fit.target_skin & (smoothing.rough[smoothing.point] == 0)
    assert clean.sum() > 0.5 * fit.target_skin.sum()
    assert np.abs(carrier.values(values)[clean] - fit.back.of(values[:, None])[clean, 0]).max() < 1e-15


def test_a_clean_correspondence_is_not_smoothed(rng: np.random.Generator) -> None:
    mesh, _, _ = face_with_slit(0.004)
    smoothing = Smoothing.of(exact_fit(mesh, mesh))
    values = rng.normal(size=len(mesh.vertices))
    assert not len(smoothing.moved)
    assert np.array_equal(smoothing(values), values)


def test_crumples_are_smoothed_out(rng: np.random.Generator) -> None:
    mesh, _, _ = face_with_slit(0.004, n=121)
    spot = np.linalg.norm(mesh.vertices[:, :2] - [0.0, 0.04], axis=1) < 0.012
    fit = crumpled(exact_fit(mesh, mesh), spot, rng)
    plain = fit.back.of(mesh.vertices)[:, 0]
    a, b = mesh.triangles[spot[mesh.triangles].all(axis=1)][:, :2].T
    jumps = [np.abs(x[a] - x[b]).mean() for x in (plain, Smoothing.of(fit)(plain))]
    assert jumps[1] < 0.5 * jumps[0]


def test_nothing_is_smoothed_across_a_slit(rng: np.random.Generator) -> None:
    mesh, upper, lower = face_with_slit(0.001, n=41)
    above = mesh.vertices[:, 1] > 0
    above[upper], above[lower] = True, False
    near = (np.abs(mesh.vertices[:, 1]) < 0.008) & (np.abs(mesh.vertices[:, 0]) < 0.03)
    fit = exact_fit(mesh, mesh)
    for side in (above & near, ~above & near):
        fit = crumpled(fit, side, rng)
    smoothed = Smoothing.of(fit)(above.astype(np.float64))
    middle = [ids[np.abs(mesh.vertices[ids, 0]) < 0.015] for ids in (upper, lower)]
    assert len(Smoothing.of(fit).moved)
    assert smoothed[middle[0]].min() > 0.95
    assert smoothed[middle[1]].max() < 0.05


def test_a_part_follows_as_one_piece(generic: Rig, carrier: Carrier) -> None:
    assert generic.skin is not None
    joints, weights = carrier.skin(generic.skin, 4)
    groups = carrier.fit.target.groups
    for name, joint in (("teeth_upper", 0), ("teeth_lower", 1), ("eye_left", 2), ("eye_right", 3)):
        strongest = joints[groups[name], 0]
        assert (strongest == joint).all(), name
        assert weights[groups[name], 0].min() > 1 - 1e-9, name


def test_a_joint_fades_before_it_is_left_out() -> None:
    rng = np.random.default_rng(8)
    ends, steps = rng.dirichlet(np.ones(9), 2), 2000
    t = np.linspace(0, 1, steps)[:, None]
    along = (1 - t) * ends[0] + t * ends[1]
    joints, weights = strongest_joints(along, 4)
    spread = np.zeros_like(along)
    np.put_along_axis(spread, joints, weights, axis=1)
    assert np.abs(spread.sum(axis=1) - 1).max() < 1e-12
    assert np.abs(np.diff(spread, axis=0)).max() < 100 / steps * np.abs(ends[1] - ends[0]).max()
    assert len({tuple(sorted(row)) for row in joints}) > 2, "no joint was left out on the way"


def test_few_enough_joints_keep_their_weights() -> None:
    weights = np.array([[0.5, 0.0, 0.2, 0.3, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0]])
    joints, kept = strongest_joints(weights, 4)
    spread = np.zeros_like(weights)
    np.put_along_axis(spread, joints, kept, axis=1)
    assert np.array_equal(spread, weights)


def test_joints_that_weigh_alike_share() -> None:
    assert strongest_joints(np.full((1, 6), 1 / 6), 4)[1] == pytest.approx(0.25)
