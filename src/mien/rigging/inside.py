"""Teeth, gums and tongue of the face's own: parts that are hidden inside its head.

Nothing on the outside says where they are, so the mouths of two faces are compared as
wholes: the parts inside one are laid on those inside the other, and each part follows
what it then lies on.  A part moves as one piece where what it follows does: teeth are
never torn between the jaws.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from mien.core import Mesh
from mien.core.arrays import Floats, Ints
from mien.geometry.surface import exposed, vertex_normals
from mien.rigging.dense import DenseFit
from mien.rigging.parts import Attachment, Box, pieces

HIDDEN = 0.9
"""A part lies inside if at least this share of its vertices cannot be seen from outside."""
MOSTLY = 0.5
"""A part follows one part of the source if this share of its vertices lies nearest to it, otherwise whatever is near."""
NEAREST = 4
"""Points that are averaged."""


def settled(fit: DenseFit, attached: tuple[Attachment, ...]) -> tuple[Attachment, ...]:
    """Return the attachments, those of the parts inside the mouth settled among each other."""
    others = pieces(fit.source.triangles, ~fit.source_skin)
    sources = hidden(fit.source, others, fit.warp.centres)
    owners = np.concatenate([np.empty(0, np.int64), *others])
    within = np.isin(owners, np.concatenate([owners[:0], *sources]))
    found = hidden(fit.target, [part.vertices for part in attached], fit.warp(fit.warp.centres))
    near = cKDTree(fit.warped[owners]) if len(owners) else None
    mine = {int(ids[0]) for ids in found if near is not None and within[near.query(fit.target.vertices[ids])[1]].mean() > 0.5}
    inner = [part for part in attached if int(part.vertices[0]) in mine]
    if not inner:
        return attached
    laid = _Laid.of(fit, sources, inner)
    return tuple(laid.attachment(part) if int(part.vertices[0]) in mine else part for part in attached)


def hidden(mesh: Mesh, parts: list[Ints], landmarks: Floats) -> list[Ints]:
    """Return those parts `(P,)` of a head that cannot be seen from in front of its face.

    Args:
        mesh: the head.
        parts: vertices of each.
        landmarks: `(L, 3)` places on the face; it looks where the skin does there.
    """
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[mesh.triangles] = True
    parts = [ids for ids in parts if used[ids].all()]
    if not parts:
        return []
    normals, every = vertex_normals(mesh.vertices, mesh.triangles), np.concatenate(parts)
    ahead = normals[used][cKDTree(mesh.vertices[used]).query(landmarks)[1]].mean(axis=0)
    seen = np.zeros(len(mesh.vertices), np.bool_)
    seen[every] = exposed(mesh, mesh.vertices[every], normals[every], ahead)
    return [ids for ids in parts if (~seen[ids]).mean() >= HIDDEN]


@dataclass(frozen=True, eq=False)
class _Laid:
    """The parts inside the source, laid on those inside the target.

    Attributes:
        fit: the correspondence.
        vertices: `(S,)` of the source's parts.
        part: `(S,)` which part each is of.
        places: `(S, 3)` where they come to lie.
    """

    fit: DenseFit
    vertices: Ints
    part: Ints
    places: Floats

    @classmethod
    def of(cls, fit: DenseFit, sources: list[Ints], targets: list[Attachment]) -> _Laid:
        vertices = np.concatenate(sources)
        part = np.repeat(np.arange(len(sources)), [len(ids) for ids in sources])
        own = fit.target.vertices[np.concatenate([target.vertices for target in targets])]
        warped, there = fit.warped[vertices], Box.of(own)
        here = Box.of(warped)
        filled = (warped - here.low) / (here.high - here.low) * (there.high - there.low) + there.low
        return cls(fit, vertices, part, min((warped, filled), key=lambda places: _apart(places, own)))

    def attachment(self, target: Attachment) -> Attachment:
        """Return what a part of the target follows."""
        own = self.fit.target.vertices[target.vertices]
        votes = np.bincount(self.part[cKDTree(self.places).query(own)[1]])
        near = np.arange(len(self.part))
        if votes.max() >= MOSTLY * votes.sum():
            near = np.flatnonzero(self.part == votes.argmax())
        followed = self.vertices[np.isin(self.part, np.flatnonzero(votes)) if len(near) == len(self.part) else near]
        weights = nearest_means(self.places[near], own, self.vertices[near], len(self.fit.source.vertices))
        return Attachment(target.vertices, weights, True, followed)


def _apart(some: Floats, others: Floats) -> float:
    """Return the mean distance between two sets of points, each to the nearest of the other."""
    there, back = cKDTree(others).query(some)[0], cKDTree(some).query(others)[0]
    return float(there.mean() + back.mean())


def nearest_means(points: Floats, queries: Floats, numbers: Ints, count: int) -> sparse.csr_matrix:
    """Return `(Q, count)` means over the nearest of some numbered points, by inverse squared distance."""
    k = min(NEAREST, len(points))
    apart, which = (np.reshape(found, (len(queries), k)) for found in cKDTree(points).query(queries, k))
    weights = 1 / np.maximum(apart, 1e-6 * float(np.ptp(points, axis=0).max()) + 1e-100) ** 2
    weights /= weights.sum(axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(queries)), k)
    return sparse.csr_matrix((weights.ravel(), (rows, numbers[which.ravel()])), shape=(len(queries), count))
