"""An actor's own shapes as extremes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Blendshapes, Correspondence, InputError, SurfacePoints
from mien.retargeting.layers.posed import posed_extremes, shared_table
from tests.conftest import grid_rig

SHAPES = ("joy", "anger", "viseme_aa", "viseme_PP", "blink_open", "blink_closed")


def test_each_extreme_is_one_frame_that_shows_the_pose() -> None:
    rig = grid_rig(shapes=SHAPES)
    points = SurfacePoints.at_vertices(np.arange(len(rig.neutral.vertices)))
    names = tuple(f"p{i}" for i in range(len(points)))
    table = shared_table(rig, rig)
    take, examples = posed_extremes(rig, Correspondence(names, points, points), table, 30.0)
    assert len(take) == sum(len(extremes) for extremes in table.values()) == len(examples.names)
    row = examples.names.index("emotion.joy")
    assert np.flatnonzero(~np.isnan(examples.values[:, row])).tolist() == [row]
    weights = np.zeros(len(SHAPES))
    weights[SHAPES.index("joy")] = 1.0
    np.testing.assert_allclose(take.points[row], rig.pose(weights), atol=1e-12)


def test_extremes_that_look_alike_at_the_points_are_left_out_and_counted() -> None:
    rig = grid_rig(shapes=SHAPES)
    far = np.argsort(np.linalg.norm(rig.blendshapes.deltas[SHAPES.index("joy")], axis=1))[:3]
    deltas = rig.blendshapes.deltas.copy()
    deltas[SHAPES.index("joy"), far] = 0.0
    rig = replace(rig, blendshapes=Blendshapes(SHAPES, deltas))
    points = SurfacePoints.at_vertices(far)
    take, examples = posed_extremes(rig, Correspondence(("a", "b", "c"), points, points), shared_table(rig, rig), 30.0)
    assert "emotion.joy" not in examples.names
    assert [note.code for note in take.notes] == ["extremes-unseen"]
    assert "emotion.joy" in take.notes[0].message


def test_points_that_are_nowhere_on_the_actor_are_refused() -> None:
    rig = grid_rig(shapes=SHAPES)
    points = SurfacePoints.at_vertices(np.arange(4))
    with pytest.raises(InputError, match="actor"):
        posed_extremes(rig, Correspondence(("a", "b", "c", "d"), points), shared_table(rig, rig), 30.0)
