"""Folds of a stuck skin, and smoothing them out (Orvalho et al., §4.3, leave this open).

A triangle is folded if sticking turned it over.  Around each fold the skin is relaxed to
where its neighbours pull it, and stuck again; what does not improve is left as it was.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import triangle_normals
from mien.rigging.warp_and_stick.sheet import Sheet
from mien.rigging.warp_and_stick.stick import Anchors, Stuck, stick

ROUNDS = 6
"""Folds that survive this often have no room on the target (the inside of a mouth it does not have)."""
RINGS = 2
"""How far around a fold the skin is relaxed, in edges."""


def folded(before: Floats, after: Floats, triangles: Ints) -> Flags:
    """Return which triangles were turned over `(T,)`."""
    turned = (triangle_normals(before, triangles) * triangle_normals(after, triangles)).sum(axis=1)
    return np.asarray(turned < 0)


def smooth_out(film: Sheet, order: Floats, ground: Sheet, stuck: Stuck, held: Ints, radius: float) -> Stuck:
    """Relax the folds of a stuck sheet.

    Args:
        film: the sheet, where the warp has brought it.
        order: `(N,)` the order of laying.
        ground: the sheet it lies on.
        stuck: where it lies.
        held: vertices that stay: landmarks.
        radius: the size of the ground's face [m].

    Returns:
        The same, with no more folds than before.
    """
    graph = film.graph(shortest=1e-3 * float(np.median(film.ways.lengths)))
    part = np.zeros(len(film.vertices), dtype=np.bool_)
    part[film.triangles] = True
    part[held] = False
    best, rings = stuck, RINGS
    fewest = folded(film.vertices, stuck.points.of(ground.vertices), film.triangles)
    for _ in range(ROUNDS):
        if not fewest.any():
            break
        free = _around(graph, film.triangles[fewest], rings) & part
        positions = best.points.of(ground.vertices)
        relaxed = replace(film, vertices=_relaxed(graph, positions, free))
        kept = np.flatnonzero(~free & (part | np.isin(np.arange(len(part)), held)))
        anchors = Anchors(kept, best.points.take(kept), np.ones(len(kept), dtype=np.bool_))
        trial = stick(relaxed, order, ground, anchors, radius)
        folds = folded(film.vertices, trial.points.of(ground.vertices), film.triangles)
        if folds.sum() < fewest.sum():
            laid = free | (part & best.adrift)
            best = Stuck(trial.points, np.where(free, trial.aside, best.aside), laid & np.where(free, trial.adrift, best.adrift))
            fewest = folds
        else:
            rings += 1
    return best


def _around(graph: sparse.csr_matrix, triangles: Ints, rings: int) -> Flags:
    reached = np.zeros(graph.shape[0], dtype=np.bool_)
    reached[triangles] = True
    for _ in range(rings):
        reached |= np.asarray(graph @ reached.astype(np.float64) > 0)
    return reached


def _relaxed(graph: sparse.csr_matrix, positions: Floats, free: Flags) -> Floats:
    """Put free vertices at the mean of their neighbours, near ones weighing more, the others staying."""
    pull = graph.copy()
    pull.data = 1 / pull.data
    laplacian = sparse.diags(np.asarray(pull.sum(axis=1)).ravel()) - pull
    inside, border = np.flatnonzero(free), np.flatnonzero(~free)
    system = sparse.csc_matrix(laplacian[inside][:, inside])
    system += 1e-9 * sparse.diags(system.diagonal())  # a patch with no border would be free to float
    right = -laplacian[inside][:, border] @ positions[border] + 1e-9 * system.diagonal()[:, None] * positions[inside]
    relaxed = np.array(positions)
    relaxed[inside] = spsolve(system, right).reshape(-1, 3)
    return relaxed
