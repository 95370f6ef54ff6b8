from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Blendshapes, Correspondence
from mien.retargeting import make_method
from mien.retargeting.visibility import IN_SIGHT, cost_of_unseen
from tests.retargeting.actors import SHAPES, capture, face, pairs_of, points_on, weights


def test_shapes_in_the_markers_sight_cost_nothing_extra() -> None:
    rig = face()
    assert np.array_equal(cost_of_unseen(rig, pairs_of(points_on(rig))), np.ones(len(SHAPES)))


def test_a_shape_costs_more_the_more_it_moves_out_of_sight() -> None:
    rig = face()
    points = points_on(rig)
    away = int(np.setdiff1d(np.arange(len(rig.neutral.vertices)), points.corners)[0])
    costs = []
    for times in (2.0, 6.0, 12.0):
        deltas = rig.blendshapes.deltas.copy()
        seen = np.linalg.norm(points.of(deltas)[0], axis=1).max()
        deltas[0, away] = [times * seen, 0, 0]
        hidden = replace(rig, blendshapes=Blendshapes(SHAPES, deltas))
        costs.append(cost_of_unseen(hidden, pairs_of(points))[0])
    assert costs[0] == 1
    assert np.isclose(costs[1], (6 / IN_SIGHT) ** 4)
    assert costs[2] > costs[1]


def test_an_empty_shape_costs_nothing_extra() -> None:
    rig = face()
    deltas = rig.blendshapes.deltas.copy()
    deltas[2] = 0
    empty = replace(rig, blendshapes=Blendshapes(SHAPES, deltas))
    assert cost_of_unseen(empty, pairs_of(points_on(rig)))[2] == 1


def test_a_hidden_twin_is_left_alone() -> None:
    """Two shapes look alike at the markers; the one that also moves much elsewhere is not used."""
    rig = face()
    points = points_on(rig)
    away = int(np.setdiff1d(np.arange(len(rig.neutral.vertices)), points.corners)[0])
    twin = rig.blendshapes.deltas[:1].copy()
    twin[0, away] = [0.3, 0, 0]
    both = replace(rig, blendshapes=Blendshapes((*SHAPES, "twin"), np.concatenate([rig.blendshapes.deltas, twin])))
    take = capture(rig, weights(), points)
    pairs: Correspondence = pairs_of(points)
    clip, _ = make_method("direct").fit(both, take, pairs, head_moves=False).retarget(take)
    careless, _ = make_method("direct", {"unseen": False}).fit(both, take, pairs, head_moves=False).retarget(take)
    assert clip.values[:, 6].max() < 0.05 * clip.values[:, 0].max()
    assert careless.values[:, 6].max() > 0.2
