"""A known list of expressions in a take: what is found is right, whatever lies in between."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from benchmarks.accuracy.calibration_take import FPS, played
from mien.core import Clip, Correspondence
from mien.evaluate.conditions import Conditions
from mien.geometry.correspond import spread_points
from mien.io.documents import join
from mien.retargeting.listed import Listed, in_order, recognise
from mien.retargeting.prepare import prepare
from mien.vocabularies.calibration import list_weights
from tests.retargeting.listed_takes import SMALL_FACE, blinking, filmed, holds, listed_face, without

FACE = listed_face()


def recognised(clip: Clip, conditions: Conditions = SMALL_FACE) -> Listed:
    markers = filmed(FACE, clip, conditions)
    points = spread_points(FACE.neutral, join(list(FACE.landmarks.values())), conditions.markers)
    pairs = Correspondence(markers.names, points)
    return recognise(prepare(FACE, markers, pairs, head_moves=conditions.head), list_weights())


def test_every_expression_is_found_within_its_hold() -> None:
    found = recognised(blinking(played()))
    assert found.entries.tolist() == list(range(29))
    first, last = holds().T
    assert ((first <= found.frames) & (found.frames <= last)).all()
    assert found.others == ()
    assert found.backwards < 0.3


@pytest.mark.parametrize(
    "conditions", [replace(SMALL_FACE, head=True), replace(SMALL_FACE, gaps=0.03), replace(SMALL_FACE, noise_mm=0.3)]
)
def test_the_capture_may_be_hard(conditions: Conditions) -> None:
    found = recognised(blinking(played()), conditions)
    first, last = holds()[found.entries].T
    assert len(found.entries) >= 27
    assert ((first <= found.frames) & (found.frames <= last)).all()


def test_an_expression_left_out_is_the_one_not_found() -> None:
    for entry in (0, 12, 28):
        found = recognised(without(played(), entry))
        assert found.entries.tolist() == [e for e in range(29) if e != entry]


def test_something_else_in_between_is_nothing_of_the_list() -> None:
    values = np.array(played().values)
    first, last = holds()[9]
    other = np.zeros_like(values[first - 9 : last + 25])
    other[9:39, values[holds()[20][0]] > 0] = 1.0
    between = np.insert(values, last + 25, other, axis=0)
    found = recognised(replace(played(), values=between))
    assert found.entries.tolist() == list(range(29))
    assert [round(hold.plateau.mean()) for hold in found.others] == pytest.approx([last + 25 + 24], abs=4)


def test_a_list_done_backwards_fits_backwards() -> None:
    found = recognised(replace(played(), values=played().values[::-1]))
    assert found.backwards > 2


def test_the_order_is_the_best_of_all_orders(rng: np.random.Generator) -> None:
    for _ in range(20):
        gain = rng.normal(0, 1, (5, 4))
        rows, columns = in_order(gain, np.arange(5))
        pairs = (
            gain[list(r), list(c)].sum()
            for n in range(1, 5)
            for r in combinations(range(5), n)
            for c in combinations(range(4), n)
        )
        assert gain[rows, columns].sum() == pytest.approx(max(0.0, *pairs))
        assert (np.diff(rows) > 0).all()
        assert (np.diff(columns) > 0).all()


def test_rows_that_overlap_are_not_both_paired() -> None:
    rows, columns = in_order(np.array([[0.6, 0.0], [0.0, 0.7]]), np.array([0, 0]))
    assert (rows.tolist(), columns.tolist()) == ([1], [1])


def test_a_take_in_which_nothing_is_held_has_next_to_nothing_of_the_list() -> None:
    values = np.array(played().values)
    flashes = np.zeros_like(values)
    flashes[::FPS] = values[holds()[:, 0]][np.arange(len(flashes[::FPS])) % 29]
    found = recognised(replace(played(), values=flashes))
    assert len(found.entries) < 3
