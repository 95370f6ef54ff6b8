"""Combinations and in-betweens: weights that follow from other weights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.core import Blendshapes, InputError
from mien.core.correctives import Correctives, correctives_of
from tests.conftest import grid_rig

NAMES = ("a", "b", "c", "a_b", "a50", "a75", "a50_b_c")
RULES = {"a_b": {"a": 1, "b": 1}, "a50": {"a": 0.5}, "a75": {"a": 0.75}, "a50_b_c": {"a": 0.5, "b": 1, "c": 1}}


def test_a_combination_is_the_product_of_its_drivers_whatever_their_size() -> None:
    weights = correctives_of(RULES, NAMES).complete(np.array([1.2, -0.5, 0, 9, 9, 9, 9]))
    np.testing.assert_allclose(weights, [1.2, -0.5, 0, -0.6, 0, 0, 0])


@pytest.mark.parametrize(
    ("a", "half", "three_quarters"),
    [(-0.3, 0, 0), (0, 0, 0), (0.25, 0.5, 0), (0.5, 1, 0), (0.6, 0.6, 0.4), (0.75, 0, 1), (0.9, 0, 0.4), (1.3, 0, 0)],
)
def test_an_in_between_is_full_at_its_place_and_gone_at_its_neighbours(
    a: float, half: float, three_quarters: float
) -> None:
    weights = correctives_of(RULES, NAMES).complete(np.array([a, 0.5, 0.4, 0, 0, 0, 0]))
    np.testing.assert_allclose(weights[3:], [0.5 * a, half, three_quarters, half * 0.2], atol=1e-12)


@given(st.lists(st.floats(0, 1), min_size=3, max_size=3))
def test_completing_twice_is_completing_once(drivers: list[float]) -> None:
    correctives = correctives_of(RULES, NAMES)
    once = correctives.complete(np.array([*drivers, 0, 0, 0, 0]))
    np.testing.assert_array_equal(correctives.complete(once), once)
    np.testing.assert_array_equal(correctives.complete(np.stack([once, 0 * once]))[0], once)


def test_a_posed_rig_uses_its_correctives_and_plays_the_completed_weights_the_same_without_them() -> None:
    plain = grid_rig(shapes=("a", "b", "a_b"))
    rig = replace(plain, correctives=correctives_of({"a_b": {"a": 1, "b": 1}}, plain.blendshapes.names))
    weights = np.array([[0.5, 0.4, 0.0], [1, 1, 0]])
    completed = rig.correctives.complete(weights)  # type: ignore[union-attr]
    np.testing.assert_array_equal(rig.pose(weights), plain.pose(completed))
    few = rig.only(np.array([3, 7]))
    np.testing.assert_array_equal(few.pose(weights), rig.pose(weights)[:, [3, 7]])
    assert not np.array_equal(rig.pose(weights), plain.pose(weights))


@pytest.mark.parametrize(
    ("rules", "said"),
    [
        ({"nope": {"a": 0.5}}, "unknown blendshape 'nope'"),
        ({"a_b": {"a": 1, "x": 1}}, "unknown blendshape 'x'"),
        ({"a_b": {"a": 1}}, "two drivers"),
        ({"a_b": {}}, "two drivers"),
        ({"a_b": {"a_b": 0.5}}, "driven by a corrective"),
        ({"a_b": {"a": 1, "b": 1}, "c": {"a_b": 0.5}}, "driven by a corrective"),
        ({"a_b": {"a": 1, "b": 0}}, "above 0"),
        ({"a_b": {"a": 1, "b": 1.5}}, "above 0"),
        ({"a_b": {"a": 1, "b": float("nan")}}, "above 0"),
    ],
)
def test_a_rule_that_makes_no_corrective_is_refused(rules: dict[str, dict[str, float]], said: str) -> None:
    with pytest.raises(InputError, match=said):
        correctives_of(rules, NAMES)


def test_correctives_of_another_rig_are_refused() -> None:
    rig = grid_rig(shapes=("a", "b", "c"))
    with pytest.raises(InputError, match="name shape 6, but it has 3"):
        replace(rig, correctives=correctives_of(RULES, NAMES))
    with pytest.raises(InputError, match="two rules"):
        Correctives(np.array([2, 2]), np.array([[0, 1], [0, 1]]), np.ones((2, 2)))
    with pytest.raises(InputError, match="a driver twice"):
        Correctives(np.array([2]), np.array([[0, 0]]), np.ones((1, 2)))
    assert Blendshapes(("a", "b", "c"), rig.blendshapes.deltas).index("c") == 2
