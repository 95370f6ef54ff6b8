"""Where lids meet on another face: between the edges that came to lie there, and over its eyeball.

The line on which two lids close is no part of the skin; it lies in the open eye.  What
is known of it is where it is between the lids' edges, as a share of the way around the
ball, and how far off the ball.  And a face's own edges may reach farther into the open
eye than the edges that were laid on it: they follow the muscles fully too, or a slit
would stay.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mien.core import Muscle
from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.muscles import drawn
from mien.geometry.surface import unit
from mien.rigging.dense import DenseFit
from mien.rigging.structure import Structure

FULLY = 0.99
"""The edge of a lid is what follows its muscle at least this fully."""
DEGREE = 5
"""How the line was moved is smoothed to a polynomial of this degree in the way from corner to corner of the eye."""
OVER = 0.01
"""Closed lids stay this far off the eyeball, as a share of its radius …"""
BESIDE = 0.92
"""… and so much of it is looked at beneath each of their places: the cosine to its border …"""
CORNER = 0.16
"""… but for the corners of the eye, which lie deeper: so much of the seam, and as much again in between."""
ON_BALL = (0.85, 1.3)
"""Skin in the open eye is lid if its distance from the centre is between these shares of the eyeball's radius."""
BEYOND = 0.995
"""Skin reaches beyond its lid's edge if this share of the edge's way to the seam is left to it."""
THICK = (0.07, 0.15)
"""Where the correspondence is unsure, what is this little behind the edge follows too, less and less [rad]."""
FEWEST = 12
"""With fewer vertices nothing is known about an eyeball."""


class Edge(NamedTuple):
    """A lid's edge from corner to corner: how far along the seam, and where it is on the source and on the target."""

    along: Floats
    source: Floats
    target: Floats

    def at(self, along: Floats) -> tuple[Floats, Floats]:
        """Return the places this far along, on the source and on the target."""
        return _between(self.along, self.source, along), _between(self.along, self.target, along)


@dataclass(frozen=True, eq=False)
class Lids:
    """Two lids on another face.

    Attributes:
        seam: `(S, 3)` where they meet there.
        pivot: `(3,)` the centre of the ball they slide over.
        partner: the muscle that closes the other lid.
        radius: of the ball.
        own, other: `(S, 3)` where the edge of the lid that is asked about, and of the other one, lie there.
    """

    seam: Floats
    pivot: Floats
    partner: Muscle
    radius: float
    own: Floats
    other: Floats

    @classmethod
    def of(
        cls,
        muscle: Muscle,
        muscles: tuple[Muscle, ...],
        fit: DenseFit,
        structure: Structure,
        parts: Floats,
        pivot: Floats,
    ) -> Lids | None:
        """Find the lids of a muscle that closes one of them around a ball; None if it closes none.

        Args:
            muscle: a ring over a ball.
            muscles: all of the rig's; the one that closes onto the same seam moves the other lid.
            fit: the correspondence.
            structure: the warp of what lies under the skin.
            parts: `(P, 3)` vertices of the target that are not skin.
            pivot: the ball's centre on the target.
        """
        seam, centre = muscle.seam, muscle.pivot
        if seam is None or centre is None:
            return None
        pair = [m for m in muscles if m.seam is not None and np.array_equal(m.seam, seam)]
        if len(pair) != 2:
            return None
        first, second = (_edge(one, seam, fit) for one in pair)
        if min(len(first.along), len(second.along)) < 4:
            return None
        along = (seam - seam[0]) @ unit(seam[-1] - seam[0])
        (here_first, there_first), (here_second, there_second) = first.at(along), second.at(along)
        share = _share(here_first, here_second, seam, centre)
        here = here_first + drawn(here_first, here_second, share, centre)
        there = there_first + drawn(there_first, there_second, share, pivot)
        # what the seam is off the edges' way is kept, so that a face laid on itself keeps its seam
        turn, scale = structure.around(centre)
        plain = scale * (seam - seam[0]) @ turn.T
        basis = np.polynomial.legendre.legvander(2 * (along - along[0]) / (along[-1] - along[0]) - 1, DEGREE)
        goal = there + scale * (seam - here) @ turn.T - plain
        line = plain + basis @ np.linalg.lstsq(basis, goal, rcond=None)[0]
        ball, grown = _radius(fit.source.vertices[~fit.source_skin], here, centre), _radius(parts, there, pivot)
        if ball is not None and grown is not None:
            off = np.linalg.norm(seam - centre, axis=1) * grown / ball
            line = _clear_of(pivot + off[:, None] * unit(line - pivot), parts, pivot, grown)
        radius = grown if grown is not None else float(np.median(np.linalg.norm(line - pivot, axis=1)))
        if pair[0] is muscle:
            return cls(line, pivot, pair[1], radius, there_first, there_second)
        return cls(line, pivot, pair[0], radius, there_second, there_first)

    def weights(self, points: Floats, own: Floats, other: Floats, unsure: Flags) -> Floats:
        """Return how fully points follow the muscle of the lid that was asked about.

        What reaches beyond a lid's edge into the open eye follows that lid fully.  Where
        the correspondence is unsure, a point follows the lid on whose side of the seam it is.

        Args:
            points: `(N, 3)` the target's skin.
            own, other: `(N,)` the weights of both muscles as they were carried.
            unsure: `(N,)` where these may be of the wrong lid.
        """
        way = unit(self.seam[-1] - self.seam[0])
        walked, along = np.maximum.accumulate((self.seam - self.seam[0]) @ way), (points - self.seam[0]) @ way
        arms = points - self.pivot
        far = np.linalg.norm(arms, axis=1) / self.radius
        near = np.flatnonzero((far > ON_BALL[0]) & (far < ON_BALL[1]) & (along > 0) & (along < walked[-1]))
        seam, mine, theirs = (unit(_between(walked, line - self.pivot, along[near])) for line in self._lines)
        here = unit(arms[near])
        above = ((here - seam) * (mine - theirs)).sum(axis=1) > 0
        edge = np.where(above[:, None], mine, theirs)
        left, opening = (np.arccos(np.clip((arm * seam).sum(axis=1), -1, 1)) for arm in (here, edge))
        inside = left < BEYOND * opening
        result = np.array(own)
        at_edge = np.clip((THICK[1] - (left - opening)) / (THICK[1] - THICK[0]), 0, 1)
        both = np.maximum(np.clip(own + other, 0, 1)[near], at_edge)
        result[near[unsure[near]]] = np.where(above, both, 0.0)[unsure[near]]
        result[near[inside]] = above[inside]
        return result

    @property
    def _lines(self) -> tuple[Floats, Floats, Floats]:
        return self.seam, self.own, self.other


def _edge(muscle: Muscle, seam: Floats, fit: DenseFit) -> Edge:
    """Return the edge of the lid that a muscle closes, with the corners of the eye at its ends."""
    edge, skin = np.flatnonzero((muscle.weights >= FULLY) & fit.paired), np.flatnonzero(fit.paired)
    corners = [int(skin[((fit.source.vertices[skin] - end) ** 2).sum(axis=1).argmin()]) for end in seam[[0, -1]]]
    ids: Ints = np.unique(np.concatenate([edge, corners]))
    along = (fit.source.vertices[ids] - seam[0]) @ unit(seam[-1] - seam[0])
    order = np.argsort(along, kind="stable")
    return Edge(along[order], fit.source.vertices[ids[order]], fit.stuck[ids[order]])


def _between(along: Floats, places: Floats, wanted: Floats) -> Floats:
    """Return the points of a line `(P, 3)` that are this far along it."""
    return np.stack([np.interp(wanted, along, places[:, axis]) for axis in range(3)], axis=1)


def _share(start: Floats, end: Floats, places: Floats, pivot: Floats) -> Floats:
    """Return at which share of the way around a ball from start to end places lie, `(S,)`."""
    a, b, p = (unit(points - pivot) for points in (start, end, places))
    whole = np.arccos(np.clip((a * b).sum(axis=1), -1, 1))
    first = np.arccos(np.clip((a * p).sum(axis=1), -1, 1))
    return np.asarray(np.clip(np.divide(first, whole, out=np.full(len(whole), 0.5), where=whole > 1e-6), 0, 1))


def _radius(parts: Floats, edge: Floats, pivot: Floats) -> float | None:
    """Return the radius of the eyeball around a pivot, beneath a lid's edge; None if there is none."""
    height = np.linalg.norm(parts - pivot, axis=1)
    height = height[height < ON_BALL[1] * np.median(np.linalg.norm(edge - pivot, axis=1))]
    return float(np.median(height)) if len(height) >= FEWEST else None


def _clear_of(seam: Floats, parts: Floats, pivot: Floats, radius: float) -> Floats:
    """Return a seam `(S, 3)` that lies outside of the eyeball, a bulging cornea included."""
    arms, own = seam - pivot, parts - pivot
    height = np.linalg.norm(own, axis=1)
    own, height = own[height < ON_BALL[1] * radius], height[height < ON_BALL[1] * radius]
    beneath = unit(arms) @ unit(own).T > BESIDE
    least = (1 + OVER) * np.where(beneath, height, 0).max(axis=1, initial=0.0)
    along = np.linspace(0, 1, len(seam))
    inward = np.clip((np.minimum(along, 1 - along) - CORNER) / CORNER, 0, 1)
    raised = np.maximum(1, least / np.linalg.norm(arms, axis=1)) - 1
    return np.asarray(pivot + (1 + inward * raised)[:, None] * arms)
