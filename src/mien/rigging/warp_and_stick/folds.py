"""Folds of a stuck skin, and smoothing them out (Orvalho et al., §4.3, leave this open).

A triangle is folded if sticking turned it over.  Around each fold the skin is relaxed to
where its neighbours pull it, and stuck again; what does not improve is left as it was.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve

from mien.core import SurfacePoints
from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import triangle_normals
from mien.rigging.warp_and_stick.sheet import Sheet
from mien.rigging.warp_and_stick.stick import Anchors, Stuck, stick

ROUNDS = 5
"""The skin is relaxed this far around a fold, in edges, one more each time."""
MOST_MOVED = 0.4
"""A patch in which a vertex moves by more than this share of the face's radius is left as it was."""


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
    laid = np.zeros(len(film.vertices), dtype=np.bool_)
    laid[film.triangles] = True
    movable = laid.copy()
    movable[held] = False
    for rings in range(1, ROUNDS + 1):
        folds = folded(film.vertices, stuck.points.of(ground.vertices), film.triangles)
        if not folds.any():
            break
        free = _around(graph, film.triangles[folds], rings) & movable
        relaxed = replace(film, vertices=_relaxed(graph, stuck.points.of(ground.vertices), free))
        kept = np.flatnonzero(laid & ~free)
        anchors = Anchors(kept, stuck.points.take(kept), np.ones(len(kept), dtype=np.bool_))
        trial = stick(relaxed, order, ground, anchors, radius)
        after = folded(film.vertices, trial.points.of(ground.vertices), film.triangles)
        moved = np.linalg.norm(trial.points.of(ground.vertices) - stuck.points.of(ground.vertices), axis=1)
        worse = (moved > MOST_MOVED * radius) | (trial.adrift & ~stuck.adrift)
        stuck = _merged(stuck, trial, _improved(graph, free, film.triangles, folds, after, worse))
    return stuck


def _improved(
    graph: sparse.csr_matrix, free: Flags, triangles: Ints, before: Flags, after: Flags, worse: Flags
) -> Flags:
    """Return the vertices of those patches that have fewer folds than before, and none `worse` `(N,)`."""
    inside = np.flatnonzero(free)
    count, part = connected_components(graph[inside][:, inside], directed=False)
    patch_of = np.full(len(free), -1, dtype=np.int64)
    patch_of[inside] = part
    owner = patch_of[triangles].max(axis=1)  # a triangle's free corners are neighbours, so in one patch
    touched = owner >= 0
    gain = np.bincount(owner[touched], before[touched].astype(np.float64) - after[touched], minlength=count)
    spoilt = np.bincount(part, worse[inside], minlength=count) > 0
    return np.asarray(((gain > 0) & ~spoilt)[patch_of] & free)


def _merged(old: Stuck, new: Stuck, taken: Flags) -> Stuck:
    return Stuck(
        SurfacePoints(
            np.where(taken[:, None], new.points.corners, old.points.corners),
            np.where(taken[:, None], new.points.weights, old.points.weights),
        ),
        np.where(taken, new.aside, old.aside),
        np.where(taken, new.adrift, old.adrift),
    )


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
