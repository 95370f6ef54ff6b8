"""Eyes, teeth, tongue and lashes: parts of a head that are not its skin.

A part that has a counterpart on the source moves as that does: rigidly where the
counterpart moves rigidly (an eyeball turns about its own centre, teeth go with the jaw),
point by point where it bends (a tongue).  A part without one, or one that lies on the
skin, such as lashes and tear film, rides on the skin under it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mien.core import Note
from mien.core.arrays import Flags, Floats, Ints
from mien.core.units import human_centimetre
from mien.geometry.align import rigid, transform
from mien.rigging.dense import DenseFit
from mien.rigging.maps import overall, stretch

OVERLAP = 0.25
"""Two parts are counterparts if their boxes share this much of what they cover together …"""
AS_GOOD = 0.98
"""… and no other part of the source shares clearly more."""
INSIDE = 0.6
"""A part belongs to a larger one if this share of its box lies in the other's."""
ON_SKIN_CM = 0.15
"""A part without a counterpart of its own size rides on the skin if its vertices are mostly this close to it."""
SAME_SIZE = 1.25
"""Parts whose sizes differ by no more than this factor are laid on each other before points are compared."""
BENDING = 0.15
"""A motion is rigid if what a rigid fit leaves over is below this share of it, root mean square."""
ROUND = 0.08
"""A part is a ball if its vertices are this close to a sphere, as a share of its radius."""
NEIGHBOURS = 4
"""Points that are averaged where a part takes its motion point by point."""


class Box(NamedTuple):
    """The axis-aligned box of some points."""

    low: Floats
    high: Floats

    @classmethod
    def of(cls, points: Floats) -> Box:
        """Return the box of points `(M, 3)`, never quite flat."""
        low, high = points.min(axis=0), points.max(axis=0)
        slack = 1e-3 * float((high - low).max()) + 1e-12
        return cls(low - slack, high + slack)

    @property
    def volume(self) -> float:
        """The volume."""
        return float(np.prod(np.maximum(self.high - self.low, 0)))

    def shared(self, other: Box) -> float:
        """Return the volume that lies in both."""
        return Box(np.maximum(self.low, other.low), np.minimum(self.high, other.high)).volume


@dataclass(frozen=True, eq=False)
class Attachment:
    """What one part of the target follows.

    Attributes:
        vertices: `(P,)` of the part.
        weights: `(P, N)` means over the vertices it follows: the source's if `counterpart`, else the target's skin.
        counterpart: whether it follows a part of the source.
        followed: `(Q,)` vertices of the source it follows; empty for the skin.
    """

    vertices: Ints
    weights: sparse.csr_matrix
    counterpart: bool
    followed: Ints


def attachments(fit: DenseFit) -> tuple[Attachment, ...]:
    """Find for every part of the target what it follows."""
    target, warped = fit.target.vertices, fit.warped
    skin = np.flatnonzero(fit.target_skin)
    to_skin = cKDTree(target[skin])
    sources = pieces(fit.source.triangles, ~fit.source_skin)
    parts = pieces(fit.target.triangles, ~fit.target_skin)
    shares = Shares.of([Box.of(target[ids]) for ids in parts], [Box.of(warped[ids]) for ids in sources])
    close = ON_SKIN_CM * human_centimetre(fit.warp(fit.warp.centres))
    found = []
    for row, part in enumerate(parts):
        group = shares.counterparts(row)
        if not group and (off := float(np.median(to_skin.query(target[part])[0]))) > close:
            around = shares.tightest_around(row)
            # lashes lie within the box of an eyeball too, but nearer to the lid
            group = [g for g in around if np.median(cKDTree(warped[sources[g]]).query(target[part])[0]) < off]
        if group:
            followed = np.concatenate([sources[g] for g in group])
            weights = _nearest(_fitted(warped[followed], target[part]), target[part], followed, len(warped))
        else:
            followed = np.empty(0, np.int64)
            weights = _nearest(target[skin], target[part], skin, len(target))
        found.append(Attachment(part, weights, bool(group), followed))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Shares:
    """How much the boxes of parts of the target and of the source have in common.

    Attributes:
        both: `(P, S)` volume in both boxes.
        target, source: `(P,)` and `(S,)` volumes.
        boxes: of the source's parts.
        wholes: of the target's parts.
    """

    both: Floats
    target: Floats
    source: Floats
    wholes: list[Box]
    boxes: list[Box]

    @classmethod
    def of(cls, wholes: list[Box], boxes: list[Box]) -> Shares:
        """Compare boxes of the target's parts with boxes of the source's."""
        (low, high), (low_other, high_other) = (
            np.array([[box.low, box.high] for box in some]).reshape(-1, 2, 3).swapaxes(0, 1) for some in (wholes, boxes)
        )
        both = np.minimum(high[:, None], high_other) - np.maximum(low[:, None], low_other)
        both = np.prod(np.maximum(both, 0), axis=2)
        return cls(both, np.array([a.volume for a in wholes]), np.array([b.volume for b in boxes]), wholes, boxes)

    def counterparts(self, row: int) -> list[int]:
        """Return the parts of the source that a part of the target stands for: one, or several that make it up."""
        if not self.boxes:
            return []
        alike = self.both[row] / (self.target[row] + self.source - self.both[row])
        single = float(alike.max())
        mine = (self.both[row] > INSIDE * self.source) & (self.both.argmax(axis=0) == row)
        within = np.flatnonzero(mine).tolist()
        if within:
            low, high = (np.array([self.boxes[g][i] for g in within]) for i in (0, 1))
            union = Box(low.min(axis=0), high.max(axis=0))
            shared = union.shared(self.wholes[row])
            together = shared / (union.volume + self.target[row] - shared)
            if together > max(single, OVERLAP):
                return within
        return np.flatnonzero(alike >= AS_GOOD * single).tolist() if single > OVERLAP else []

    def tightest_around(self, row: int) -> list[int]:
        """Return the smallest part of the source that a part of the target lies within, if there is one."""
        around = np.flatnonzero(self.both[row] > INSIDE * self.target[row])
        return [int(around[self.source[around].argmin()])] if len(around) else []


def move_parts(
    deltas: Floats, skin: Floats, fit: DenseFit, attached: tuple[Attachment, ...]
) -> tuple[Floats, tuple[Note, ...]]:
    """Fill in the displacements of the parts that are not skin.

    Args:
        deltas: `(K, Ns, 3)` the source's shapes.
        skin: `(K, Nt, 3)` the target's, right on its skin.
        fit: the correspondence.
        attached: what the parts follow.

    Returns:
        `(K, Nt, 3)`, and a note on the parts that ride on the skin.
    """
    moved = np.array(skin)
    riding = 0
    for part in attached:
        riding += not part.counterpart
        moved[:, part.vertices] = follow(part, deltas, fit) if part.counterpart else [part.weights @ s for s in skin]
    if not riding:
        return moved, ()
    text = f"{riding} parts of the target have no counterpart on the source and ride on the skin under them"
    return moved, (Note("parts-ride-on-skin", text),)


def follow(part: Attachment, deltas: Floats, fit: DenseFit) -> Floats:
    """Return the displacements `(K, P, 3)` of a part whose counterpart moves by `deltas` `(K, Ns, 3)`.

    A rigid motion of the counterpart is conjugated to the part: the same turn, seen from
    the target, about the part's own centre, and the centre's shift scaled as the face is.
    """
    own, used = fit.target.vertices[part.vertices], np.unique(part.weights.indices)
    rest, there = fit.source.vertices[used], overall(fit).rotation
    centre = centre_of(fit.source.vertices[part.followed])
    scale = float(stretch(fit, centre[None])[0])
    result = np.zeros((len(deltas), len(own), 3))
    shifts = deltas[:, used]
    active = np.flatnonzero(shifts.any(axis=(1, 2)))
    if not len(active):
        return result
    shifts = shifts[active]
    moved = rest + shifts
    motion = rigid(rest, moved, np.ones(moved.shape[:2]))
    turn, shift = motion[:, :3, :3], motion[:, :3, :3] @ centre + motion[:, :3, 3] - centre
    left_over = moved - transform(motion, rest)
    bends = (left_over**2).sum(axis=(1, 2)) > BENDING**2 * (shifts**2).sum(axis=(1, 2))
    arm = own - centre_of(own)
    result[active] = arm @ np.swapaxes(there @ turn @ there.T - np.eye(3), 1, 2) + (scale * shift @ there.T)[:, None]
    for k in active[bends]:
        result[k] = scale * (part.weights @ deltas[k]) @ there.T
    return result


def pieces(triangles: Ints, wanted: Flags) -> list[Ints]:
    """Return the vertices of each connected piece of a mesh that is wholly `wanted`."""
    count = len(wanted)
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    linked = sparse.csr_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    label = connected_components(linked, directed=False)[1][wanted]
    order = np.argsort(label, kind="stable")
    cuts = np.flatnonzero(np.diff(label[order])) + 1
    return [ids for ids in np.split(np.flatnonzero(wanted)[order], cuts) if len(ids)]


def _fitted(points: Floats, onto: Floats) -> Floats:
    """Move and scale points to the place of others of nearly their size; leave them if the sizes differ."""
    here, there = Box.of(points), Box.of(onto)
    size = float(np.linalg.norm(there.high - there.low) / np.linalg.norm(here.high - here.low))
    if not 1 / SAME_SIZE < size < SAME_SIZE:
        return points
    return np.asarray((points - (here.low + here.high) / 2) * size + (there.low + there.high) / 2)


def _nearest(points: Floats, queries: Floats, numbers: Ints, count: int) -> sparse.csr_matrix:
    """`(Q, count)` means over the nearest points, by inverse squared distance."""
    k = min(NEIGHBOURS, len(points))
    apart, which = (np.reshape(found, (len(queries), k)) for found in cKDTree(points).query(queries, k))
    weights = 1 / np.maximum(apart, 1e-6 * float(np.ptp(points, axis=0).max()) + 1e-100) ** 2
    weights /= weights.sum(axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(queries)), k)
    return sparse.csr_matrix((weights.ravel(), (rows, numbers[which.ravel()])), shape=(len(queries), count))


def centre_of(points: Floats) -> Floats:
    """Return the centre of the sphere that points lie on, or of their box if they lie on none."""
    box = Box.of(points)
    middle = (box.low + box.high) / 2
    arms = points - middle
    system = np.column_stack([2 * arms, np.ones(len(arms))])
    solved = np.linalg.lstsq(system, (arms**2).sum(axis=1), rcond=None)[0]
    lengths = np.linalg.norm(arms - solved[:3], axis=1)
    return np.asarray(middle + solved[:3] if lengths.std() < ROUND * lengths.mean() else middle)
