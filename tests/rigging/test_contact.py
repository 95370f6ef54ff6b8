"""What touches on the source touches on the target, and nothing else changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core.units import human_centimetre
from mien.rigging.blendshapes import carried, poses
from mien.rigging.contact import REACH_CM
from mien.rigging.touching import Touching, closest_on_triangles
from tests.rigging.faces import closing, exact_fit, face_with_slit, rig_of


def test_lips_that_meet_on_the_source_meet_on_the_target() -> None:
    source, upper, lower = face_with_slit(0.006)
    target, _, _ = face_with_slit(0.010)
    rig = rig_of(source, mouthPress=closing(source, upper, lower))
    fit = exact_fit(source, target)
    millimetre = human_centimetre(fit.warp(fit.warp.centres)) / 10
    gaps = {}
    for contact in (False, True):
        shapes, notes = carried(rig, fit, contact=contact)
        posed = target.vertices + shapes.deltas[0]
        gaps[contact] = np.linalg.norm(posed[upper] - posed[lower], axis=1).max() / millimetre
        assert [note.where for note in notes if note.code == "contact-kept"] == ["mouthPress"] * contact
    assert gaps[False] > 1.0
    assert gaps[True] < 0.3


def test_a_correction_stays_near_the_slit() -> None:
    source, upper, lower = face_with_slit(0.006)
    target, _, _ = face_with_slit(0.010)
    rig = rig_of(source, mouthPress=closing(source, upper, lower))
    fit = exact_fit(source, target)
    before, after = (carried(rig, fit, contact=contact)[0].deltas[0] for contact in (False, True))
    change = np.linalg.norm(after - before, axis=1)
    margin = target.vertices[np.concatenate([upper, lower])]
    far = np.linalg.norm(target.vertices[:, None] - margin, axis=2).min(axis=1)
    reach = REACH_CM * human_centimetre(fit.warp(fit.warp.centres))
    assert change.max() > 0.001
    assert change[far > reach].max() == 0


def test_lips_that_move_together_are_left_as_they_are_on_the_target() -> None:
    source, upper, _ = face_with_slit(0.0002)
    target, _, _ = face_with_slit(0.004)
    shift = np.exp(-(source.vertices**2)[:, :2].sum(1, keepdims=True) / 0.03**2) * [0.0, 0.004, 0.002]
    rig = rig_of(source, mouthLeft=shift)
    fit = exact_fit(source, target)
    found = Touching(source, fit.source_skin, human_centimetre(fit.warp.centres)).contacts(shift)
    assert np.isin(upper[3:-3], found.vertices).all()
    assert found.met.all()
    before, after = (carried(rig, fit, contact=contact)[0].deltas for contact in (False, True))
    assert np.abs(after - before).max() < 2e-5


def test_an_open_slit_and_its_neighbourhood_touch_nothing() -> None:
    source, upper, lower = face_with_slit(0.006)
    touching = Touching(source, np.ones(len(source.vertices), np.bool_), human_centimetre(source.vertices))
    assert len(touching.contacts(0.3 * closing(source, upper, lower))) == 0
    assert len(touching.contacts(np.zeros_like(source.vertices))) == 0


def test_the_closing_of_the_mouth_is_corrected_with_the_jaw_open() -> None:
    names = ("jawOpen", "mouth_close", "smile_L")
    assert poses(names) == {"jawOpen": (0,), "smile_L": (2,), "jawOpen + mouth_close": (0, 1)}
    assert poses(names[1:]) == {"mouth_close": (0,), "smile_L": (1,)}
    source, upper, lower = face_with_slit(0.001)
    target, _, _ = face_with_slit(0.002)
    drop = -closing(source, upper, lower) * 8
    shut = -drop + closing(source, upper, lower)
    rig = rig_of(source, jawOpen=drop, mouthClose=shut)
    shapes, _ = carried(rig, exact_fit(source, target))
    plain, _ = carried(rig, exact_fit(source, target), contact=False)
    assert (shapes.deltas[0] == plain.deltas[0]).all()
    posed = target.vertices + shapes.deltas.sum(axis=0)
    assert np.linalg.norm(posed[upper] - posed[lower], axis=1).max() < 0.0003


def test_the_closest_point_of_a_triangle_is_the_best_of_many(rng: np.random.Generator) -> None:
    corners = rng.normal(size=(40, 3, 3))
    points = 2 * rng.normal(size=(40, 3))
    weights = closest_on_triangles(points, corners)
    assert (weights >= 0).all()
    assert np.allclose(weights.sum(axis=1), 1)
    found = np.linalg.norm(np.einsum("mi,mic->mc", weights, corners) - points, axis=1)
    tried = rng.dirichlet(np.full(3, 0.5), size=4000)
    best = np.linalg.norm(np.einsum("ki,mic->mkc", tried, corners) - points[:, None], axis=2).min(axis=1)
    assert (found <= best + 1e-12).all()


def test_a_face_carried_to_itself_is_not_corrected() -> None:
    source, upper, lower = face_with_slit(0.006)
    rig = rig_of(source, mouthPress=closing(source, upper, lower))
    shapes, notes = carried(rig, exact_fit(source, source))
    assert np.allclose(shapes.deltas, rig.blendshapes.deltas, atol=1e-12)
    assert not notes
    assert replace(rig, blendshapes=shapes).pose(np.ones(1)).shape == source.vertices.shape
