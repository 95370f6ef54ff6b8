"""Where a correspondence is crumpled, and what it carried smoothed out there.

Lips, lids and what lies behind them are where two faces differ most.  A skin that had
to be crumpled to lie on another carries crumpled weights, and these tear an expression.
So where neighbours on the face come from places that are not neighbours alike, values
are relaxed along the face's own skin, never across a slit; where the correspondence is
clean they stay exactly what they were.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from mien.core.arrays import Flags, Floats, Ints, unique_numbers
from mien.core.units import human_centimetre
from mien.rigging.dense import DenseFit
from mien.rigging.warp_and_stick.sheet import twins_of

CLEAN, CRUMPLED = 0.45, 1.0
"""Spread of the logarithms of the stretches around a point below which it is clean, and above which it is crumpled."""
SPREAD_CM = 0.5
"""How far values are spread where the skin is crumpled, on a human face."""
COLLAPSED = 3.0
"""Logarithms of stretches beyond this count as this."""


@dataclass(frozen=True, eq=False)
class Smoothing:
    """Relaxes values on a face where the correspondence is crumpled.

    Attributes:
        rough: `(P,)` how crumpled it is at each point of the skin, 0 to 1.
        point: `(N,)` the point each vertex is: those doubled along a texture seam are one.
        first: `(P,)` a vertex of each point.
        moved: `(R,)` the points that are relaxed.
        pull: `(R, P)` how strongly each is drawn to others.
    """

    rough: Floats
    point: Ints
    first: Ints
    moved: Ints
    pull: sparse.csr_matrix

    @classmethod
    def of(cls, fit: DenseFit) -> Smoothing:
        """Find where a correspondence is crumpled."""
        point, first = points_of(fit)
        count = len(first)
        a, b = edges(point[fit.target.triangles[fit.target_skin[fit.target.triangles].all(axis=1)]], count)
        here, there = fit.target.vertices[first], fit.back.of(fit.source.vertices)[first]
        lengths = np.maximum(np.linalg.norm(here[a] - here[b], axis=1), 1e-300)
        stretch = np.log(np.maximum(np.linalg.norm(there[a] - there[b], axis=1) / lengths, 1e-300))
        rough = _roughness(a, b, stretch, count)
        near = neighbours(here, a, b)
        total = np.asarray(near.sum(axis=1)).ravel()
        edge = np.diff(near.indptr) / np.maximum(total, 1e-300)  # the harmonic mean of the edges around a point
        reach = SPREAD_CM * human_centimetre(fit.warp(fit.warp.centres)) * rough
        strength = np.divide(reach, edge, out=np.zeros(count), where=edge > 0) ** 2
        moved = np.flatnonzero(strength > 0)
        return cls(rough, point, first, moved, sparse.diags(strength[moved] / total[moved]) @ near[moved])

    def __call__(self, values: Floats) -> Floats:
        """Return values `(N,)` or `(N, C)`, relaxed."""
        if not len(self.moved):
            return values
        own = values[self.first]
        own[self.moved] = self._solver(own[self.moved] + self._drawn @ own)
        changed = self._changed
        return np.where(changed if values.ndim == 1 else changed[:, None], own[self.point], values)

    @cached_property
    def _solver(self) -> Callable[[Floats], Floats]:
        kept = sparse.diags(1 + np.asarray(self.pull.sum(axis=1)).ravel())
        solve: Callable[[Floats], Floats] = splu(sparse.csc_matrix(kept - self.pull[:, self.moved])).solve
        return solve

    @cached_property
    def _drawn(self) -> sparse.csr_matrix:
        """What is drawn in from the points that stay."""
        stays = np.ones(len(self.first))
        stays[self.moved] = 0
        return sparse.csr_matrix(self.pull @ sparse.diags(stays))

    @cached_property
    def _changed(self) -> Flags:
        return np.isin(self.point, self.moved)


def points_of(fit: DenseFit) -> tuple[Ints, Ints]:
    """Return which point of the target's skin each vertex is, and a vertex of each point."""
    count = len(fit.target.vertices)
    twins = twins_of(fit.target.vertices, fit.target.triangles)
    linked = sparse.csr_matrix((np.ones(len(twins)), (twins[:, 0], twins[:, 1])), shape=(count, count))
    _, point = connected_components(linked, directed=False)
    return point.astype(np.int64), np.unique(point, return_index=True)[1]


def edges(triangles: Ints, count: int) -> tuple[Ints, Ints]:
    """Return the ends of every edge of triangles `(T, 3)` between two of `count` points, once."""
    a, b = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]).T
    low, high = np.minimum(a, b), np.maximum(a, b)
    edge = unique_numbers((low * count + high)[low != high])
    return edge // count, edge % count


def neighbours(places: Floats, a: Ints, b: Ints) -> sparse.csr_matrix:
    """Return `(P, P)` how strongly points hold each other: those at the ends of an edge by one over its length."""
    lengths = np.maximum(np.linalg.norm(places[a] - places[b], axis=1), 1e-300)
    near = sparse.csr_matrix((1 / lengths, (a, b)), shape=(len(places), len(places)))
    return sparse.csr_matrix(near + near.T)


def _roughness(a: Ints, b: Ints, stretch: Floats, count: int) -> Floats:
    """Return from 0 to 1 how unlike the stretches (logarithms) of the edges around each point are."""
    clipped = np.clip(stretch - np.median(stretch), -COLLAPSED, COLLAPSED) if len(stretch) else stretch
    ends, both = np.concatenate([a, b]), np.concatenate([b, a])
    degree = np.maximum(np.bincount(ends, minlength=count), 1)
    moments = [np.bincount(ends, np.tile(clipped**power, 2), count) / degree for power in (1, 2)]
    mean, square = (np.bincount(ends, moment[both], count) / degree for moment in moments)
    spread = np.sqrt(np.maximum(square - mean**2, 0))
    return np.asarray(np.clip((spread - CLEAN) / (CRUMPLED - CLEAN), 0, 1))
