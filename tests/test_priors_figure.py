"""What figure 14 of the range-of-motion paper is judged by."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.paper_figures.range_of_motion.folds import folded
from benchmarks.paper_figures.range_of_motion.priors import Cell
from mien.retargeting import make_method
from tests.retargeting.actors import at_rest, capture, face, pairs_of, points_on, weights


def test_a_surface_that_turns_and_bends_is_not_folded() -> None:
    mesh = face().neutral
    turned = Rotation.from_euler("xyz", [100, 40, 170], degrees=True).apply(mesh.vertices.copy())
    assert not folded(mesh, turned).any()
    curled = mesh.vertices.copy()
    angle = mesh.vertices[:, 1] / 0.05
    curled[:, 1], curled[:, 2] = 0.05 * np.sin(angle), mesh.vertices[:, 2] - 0.05 * (1 - np.cos(angle))
    assert not folded(mesh, curled).any()


def test_a_vertex_pushed_across_its_neighbours_folds_the_triangles_behind_it() -> None:
    mesh = face().neutral
    middle = 12 * 24 + 12
    posed = mesh.vertices.copy()
    posed[middle, 0] += 2.5 * (posed[middle + 24, 0] - posed[middle, 0])
    flags = folded(mesh, posed)
    assert flags.any()
    assert (mesh.triangles[flags] == middle).any(axis=1).all()


@pytest.mark.parametrize("kind", ["geometric", "l2", "elastic-net", "pca"])
def test_every_prior_is_made_as_strong_as_the_same_fit_allows(kind: str) -> None:
    rig = face()
    points = points_on(rig)
    take = capture(rig, weights(60), points, noise=1e-3)
    free = {"bounds": None, "damping": 0.0, "smooth": 0.0}
    known = {"neutral": at_rest(rig, points), "head_moves": False}
    fitted = make_method("rbf", free).fit(rig, take, pairs_of(points), **known)
    cell = Cell("take", "face", rig, fitted, fitted.displacements(take.points)[0])
    least = cell.residual(cell.weights("none", 0.0))
    strength, found = cell.at(kind, 1.05 * least)
    assert cell.residual(found) == pytest.approx(1.05 * least, rel=1e-3)
    assert strength > 0
