"""Judging without a truth."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import InputError
from mien.evaluate import Case, embedded_cases
from mien.evaluate.real import closures, mirror_partners, predict_held_out, symmetry
from mien.retargeting import make_method


@pytest.fixture(scope="module")
def case() -> Case:
    return embedded_cases(stride=4)[0]


def test_held_out_markers_are_predicted_better_than_by_a_face_at_rest(case: Case) -> None:
    found = predict_held_out(make_method("direct"), case.character, case.training, case.pairs, folds=3, stride=8)
    assert found.motion_mm > 1
    assert found.error_mm < 0.8 * found.motion_mm
    assert found.shown_mm < found.error_mm
    assert 0.5 < found.gain < 1.2


def test_every_point_of_a_symmetric_face_has_its_partner_on_the_other_side(case: Case) -> None:
    points = case.prepared.terms.character_neutral
    partner, normal = mirror_partners(points, points)
    assert (partner >= 0).mean() > 0.9
    found = np.flatnonzero(partner >= 0)
    np.testing.assert_array_equal(partner[partner[found]], found)
    assert abs(normal[0]) == pytest.approx(1, abs=1e-2)


def test_equal_weights_are_symmetric_and_one_sided_ones_are_not(case: Case) -> None:
    terms, take = case.prepared.terms, case.prepared.take
    names = case.character.blendshapes.names
    even = np.ones((len(take), len(names)))
    same = symmetry(even, names, take, terms.character_neutral, terms.character_neutral)
    assert same.frames > 10
    assert same.difference == 0
    odd = even * [not name.endswith("_R") for name in names]
    assert symmetry(odd, names, take, terms.character_neutral, terms.character_neutral).difference == pytest.approx(1)


def test_a_character_whose_jaw_hangs_open_does_not_close_its_lips(case: Case) -> None:
    rig = case.character
    open_mouth = np.zeros((100, len(rig.blendshapes)))
    apart = np.linspace(0, 1, 100)
    upper, lower = np.zeros((100, 3)), np.stack([0 * apart, -apart, 0 * apart], axis=1)
    shut = closures(rig, open_mouth, upper, lower)
    open_mouth[:, rig.blendshapes.index("Jaw_Open")] = 0.5
    hanging = closures(rig, open_mouth, upper, lower)
    assert shut is not None
    assert hanging is not None
    assert shut.frames == 10
    assert shut.lip_mm == 0
    assert hanging.lip_mm > 3


def test_a_method_without_shapes_cannot_predict(case: Case) -> None:
    with pytest.raises(InputError):
        predict_held_out(make_method("copy"), case.character, case.training, case.pairs, folds=2)
