"""Attributes of the skin on a face of other triangulation (Orvalho et al., §4.5 and §4.6).

Every vertex of the face takes the value of its point on the generic skin that was stuck
to it.  Numbers are interpolated, labels never; what is not skin takes the value of the
part it follows, and what was brought along keeps its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from mien.core import Labels, Skin
from mien.core.arrays import Flags, Floats, Ints
from mien.core.units import human_centimetre
from mien.geometry.surface import exposed, vertex_normals
from mien.rigging.brought import Brought
from mien.rigging.dense import DenseFit
from mien.rigging.parts import Attachment
from mien.rigging.roughness import Smoothing

FAINT = 1e-9
"""Shares below this are rounding errors of the smoothing."""
BLOCK = 4_000_000
"""So many values are carried at a time; it bounds the memory."""
FADE_CM = (0.3, 0.8)
"""Hidden skin follows muscles less and less over these distances from what was laid on it, on a human face."""


@dataclass(frozen=True, eq=False)
class Carrier:
    """Takes values of the source's vertices to the face's, and to those brought along behind them.

    Attributes:
        fit: the correspondence.
        attached: what the parts of the face follow.
        brought: `(B,)` vertices of the source that were brought along.
        places: `(B, 3)` where they are on the face.
        smoothing: relaxes what was carried where the correspondence is crumpled.
    """

    fit: DenseFit
    attached: tuple[Attachment, ...]
    brought: Ints
    places: Floats
    smoothing: Smoothing

    @classmethod
    def of(cls, fit: DenseFit, attached: tuple[Attachment, ...], brought: Brought) -> Carrier:
        """Make ready to carry values."""
        return cls(fit, attached, brought.vertices, brought.places, Smoothing.of(fit))

    @property
    def parts(self) -> Floats:
        """`(P, 3)` vertices of everything that is not skin and does not ride on it."""
        own = [self.fit.target.vertices[part.vertices] for part in self.attached if part.counterpart]
        return np.concatenate([*own, self.places])

    def values(self, values: Floats) -> Floats:
        """Interpolate values `(Ns,)` or `(Ns, C)`."""
        skin = self.smoothing(np.asarray(self._laid @ values))
        result = np.array(skin)
        for part in self.attached:
            result[part.vertices] = part.weights @ (values if part.counterpart else skin)
        return np.concatenate([result, values[self.brought]])

    def shares(self, values: Floats) -> Floats:
        """Interpolate shares `(Ns,)` between 0 and 1, which they stay."""
        shares = np.clip(self.values(values), 0.0, 1.0)
        return np.where(shares < FAINT, 0.0, shares)

    def pulls(self, values: Floats) -> Floats:
        """Interpolate how fully skin follows muscles `(M, Ns)`: not at all where it lies hidden and has no counterpart."""
        count = len(self.fit.back)
        known = np.append(np.where(self.fit.target_skin, self.known, 1.0), np.ones(len(self.brought)))
        result, at_once = np.empty((len(values), len(known))), 1 + BLOCK // count
        for first in range(0, len(values), at_once):
            some = slice(first, first + at_once)
            result[some] = self.shares(values[some].T).T * known
        return result

    @cached_property
    def _laid(self) -> sparse.csr_matrix:
        """The `(Nt, Ns)` matrix that interpolates the source's values on the face."""
        back, count = self.fit.back, len(self.fit.source.vertices)
        ends = np.arange(0, 3 * len(back) + 1, 3)
        return sparse.csr_matrix((back.weights.ravel(), back.corners.ravel(), ends), shape=(len(back), count))

    @cached_property
    def known(self) -> Floats:
        """`(Nt,)` from 1 to 0: less where skin that cannot be seen, as in a socket, is far from all that was laid on it."""
        mesh = self.fit.target
        first, last = (length * human_centimetre(self.fit.warp(self.fit.warp.centres)) for length in FADE_CM)
        known = np.clip((last - self.fit.back_distance) / (last - first), 0, 1)
        doubtful = np.flatnonzero((known < 1) & self.fit.target_skin)
        normals = vertex_normals(mesh.vertices, mesh.triangles)[doubtful]
        known[doubtful[exposed(mesh, mesh.vertices[doubtful], normals)]] = 1
        return np.asarray(known)

    @property
    def unsure(self) -> Flags:
        """`(Nt,)` skin that is not where its counterpart was laid, or where that is crumpled."""
        off = self.fit.back_distance > FADE_CM[0] / 3 * human_centimetre(self.fit.warp(self.fit.warp.centres))
        return np.asarray(off | (self.smoothing.rough[self.smoothing.point] > 0))

    def labels(self, labels: Labels) -> Labels:
        """Give every vertex the label of the source vertex that weighs most in its mean."""
        back = self.fit.back
        strongest = back.corners[np.arange(len(back)), back.weights.argmax(axis=1)]
        own = np.array(strongest)
        for part in self.attached:
            chosen = _strongest(part.weights)
            own[part.vertices] = chosen if part.counterpart else strongest[chosen]
        return replace(labels, of=labels.of[np.concatenate([own, self.brought])])

    def skin(self, skin: Skin, influences: int) -> tuple[Ints, Floats]:
        """Interpolate skin weights and keep the strongest, see `strongest_joints`.

        Returns:
            `(Nt, I)` joints and weights; each row is non-negative and sums to 1.
        """
        count = len(skin.inverse_bind)
        spread = np.zeros((len(skin.joints), count))
        np.add.at(spread, (np.arange(len(skin.joints))[:, None], skin.joints), skin.weights)
        return strongest_joints(self.values(spread), min(influences, count))


def strongest_joints(weights: Floats, kept: int) -> tuple[Ints, Floats]:
    """Keep the strongest of the weights `(N, J)` of each vertex.

    Each is lessened by the strongest that is left out: a joint must fade before it goes, or
    the skin tears where neighbours keep others.

    Returns:
        `(N, kept)` joints and weights; each row is non-negative and sums to 1.
    """
    order = np.argsort(-weights, axis=1, kind="stable")
    ordered = np.maximum(np.take_along_axis(weights, order[:, : kept + 1], axis=1), 0)
    strongest: Floats = ordered[:, :kept]
    if kept < weights.shape[1]:
        faded = strongest - ordered[:, kept:]
        alike = faded.sum(axis=1, keepdims=True) <= FAINT
        strongest = np.where(alike, strongest, faded)
    return order[:, :kept], strongest / strongest.sum(axis=1, keepdims=True)


def _strongest(weights: sparse.csr_matrix) -> Ints:
    """Return the column of the largest entry of every row."""
    rows = np.repeat(np.arange(weights.shape[0]), np.diff(weights.indptr))
    order = np.lexsort((weights.data, rows))
    return np.asarray(weights.indices[order[weights.indptr[1:] - 1]], dtype=np.int64)
