"""Running methods on cases: the embedded one everywhere, the real ones where the data is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core import Clip, InputError
from mien.evaluate import Case, embedded_cases, run_case, run_suite, summary
from mien.evaluate.collection import QUICK, Recipe, actor, made
from mien.evaluate.deformation import transferred_shapes
from mien.evaluate.metrics import shape_error
from mien.evaluate.played import DEFORMATION_TRANSFER, play
from mien.evaluate.suite import compare
from mien.retargeting import make_method

SOLVE = {"sparsity": 0.02, "bounds": (0.0, 1.1)}


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    return embedded_cases(stride=4)


def test_the_true_weights_have_no_error_and_full_correlation(cases: list[Case]) -> None:
    for name, clip in (("absolute", cases[0].truth), ("range", cases[0].truth_range)):
        found = cases[0].yardsticks[name].measure(np.asarray(clip.values))
        assert found["rmse"] == 0
        assert found["gain"] == pytest.approx(1)
        assert found["vertex_mm"] == 0


def test_the_floor_has_the_true_shapes_and_beats_the_guess(cases: list[Case]) -> None:
    floor, guess = (run_case(cases[0], method, SOLVE) for method in ("floor", "rbf"))
    for truth in ("absolute", "range"):
        assert floor[truth]["shapes"] == pytest.approx(0, abs=1e-9)
        assert floor[truth]["vertex_mm"] < guess[truth]["vertex_mm"]
        assert floor[truth]["correlation"] > guess[truth]["correlation"]


def test_true_shapes_given_as_an_array_or_a_function_are_the_floor(cases: list[Case]) -> None:
    case = cases[0]
    shapes = case.shapes("absolute")
    floor = run_case(case, "floor", SOLVE)["absolute"]
    for given in (shapes, lambda prepared: shapes):
        np.testing.assert_equal(run_case(case, given, SOLVE)["absolute"], floor)


def test_deformation_transfer_onto_the_same_face_finds_the_true_shapes(cases: list[Case]) -> None:
    case = cases[0]
    assert case.pairs.source is not None
    deltas = case.pairs.source.of(case.actor.blendshapes.deltas)
    points = replace(case.pairs, target=case.pairs.source)
    every = np.ones(len(deltas), dtype=bool)
    mirror = replace(case, character=case.actor, pairs=points)
    assert shape_error(transferred_shapes(mirror), deltas / case.prepared.terms.centimetre, every) < 0.1


def test_deformation_transfer_is_played_by_name_and_says_what_it_was_given(cases: list[Case]) -> None:
    played = play(cases[0], DEFORMATION_TRANSFER, SOLVE)
    assert played.given == "the actor's mesh"
    assert compare(cases[0], played.clip, "absolute", played.shapes)["correlation"] > 0.7


def test_a_method_by_name_and_as_an_object_give_the_same(cases: list[Case]) -> None:
    by_name, as_object = (
        run_case(cases[0], m, s) for m, s in (("direct", SOLVE), (make_method("direct", SOLVE), None))
    )
    np.testing.assert_equal(by_name["absolute"], as_object["absolute"])


def test_gaps_noise_and_head_motion_leave_a_case_that_can_be_played(cases: list[Case]) -> None:
    hard = cases[1]
    assert hard.head_moves
    assert np.isnan(hard.test.points).any()
    assert len(hard.pairs) == 41
    assert run_case(hard, "floor", SOLVE)["absolute"]["correlation"] > 0.7


def test_methods_that_cannot_play_a_case_have_no_row_and_the_summary_places_the_others(cases: list[Case]) -> None:
    nameless = replace(cases[0], recording=Clip(("wag",), np.ones((3, 1)), 60.0))
    rows = run_suite([nameless], ["floor", "rbf", "direct", "copy"], SOLVE)
    assert [row["method"] for row in rows] == ["floor", "rbf", "direct"]
    means = {row["method"]: row for row in summary(rows, "absolute")}
    assert means["floor"]["closed"] == pytest.approx(1)
    assert means["rbf"]["closed"] == pytest.approx(0)
    assert means["rbf"]["worse"] + means["direct"]["worse"] <= 1


def test_a_misspelt_setting_is_an_error_and_not_a_missing_row(cases: list[Case]) -> None:
    with pytest.raises(InputError, match="sparsty"):
        run_suite(cases[:1], ["rbf"], {"sparsty": 1.0})


@pytest.mark.real
def test_a_person_with_exact_pairs_is_played_back_by_the_true_shapes(data: Path) -> None:
    case = made(data, Recipe("p1", "toon", spread=0.3), stride=16)
    floor, guess = (run_case(case, method, SOLVE)["absolute"] for method in ("floor", "rbf"))
    assert floor["shapes"] == pytest.approx(0, abs=1e-9)
    assert floor["vertex_mm"] < guess["vertex_mm"]
    copied = run_case(case, "copy")
    assert copied["absolute"]["rmse"] == pytest.approx(0)
    assert copied["range"]["gain"] < 1


@pytest.mark.real
def test_pairs_across_topologies_lie_on_the_same_places(data: Path) -> None:
    case = made(data, Recipe("adult", "ict"), stride=16)
    assert len(case.pairs) >= 90
    assert run_case(case, "floor", SOLVE)["absolute"]["gain"] > 0.6


@pytest.mark.real
def test_people_differ_and_each_is_always_the_same(data: Path) -> None:
    one, again, other = (actor(data, name) for name in ("p1", "p1", "p2"))
    assert np.array_equal(one.neutral.vertices, again.neutral.vertices)
    apart = np.linalg.norm(one.neutral.vertices - other.neutral.vertices, axis=1)
    assert 0.001 < apart.mean() < 0.02


def test_recipes_have_names_of_their_own() -> None:
    assert len({recipe.name for recipe in QUICK}) == len(QUICK)
