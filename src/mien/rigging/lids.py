"""Where lids meet on another face: between the edges that came to lie there, and over its eyeball.

The line on which two lids close is no part of the skin; it lies in the open eye.  What
is known of it is where it is between the lids' edges, as a share of the way around the
ball, and the edges themselves lie on the face.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mien.core import Muscle
from mien.core.arrays import Floats, Ints
from mien.geometry.muscles import drawn
from mien.geometry.surface import unit
from mien.rigging.dense import DenseFit
from mien.rigging.structure import Structure

FULLY = 0.99
"""The edge of a lid is what follows its muscle at least this fully."""
DEGREE = 5
"""How the line was moved is smoothed to a polynomial of this degree in the way from corner to corner of the eye."""
OVER = 0.01
"""Closed lids stay this far off the ball, as a share of its radius …"""
AROUND = 1.4
"""… no farther from its centre than this many times the lids …"""
CORNER = 0.16
"""… but for the corners of the eye, which lie deeper: so much of the seam, and as much again in between …"""
BESIDE = 0.92
"""… and so much of the ball is looked at beneath each of their places: the cosine to its border."""


class Edge(NamedTuple):
    """A lid's edge: how far along the seam each vertex is, and where it is on the source and on the target."""

    along: Floats
    source: Floats
    target: Floats

    def at(self, along: Floats) -> tuple[Floats, Floats]:
        """Return the places this far along, on the source and on the target."""
        here, there = (
            np.stack([np.interp(along, self.along, places[:, axis]) for axis in range(3)], axis=1)
            for places in (self.source, self.target)
        )
        return here, there


def closing_line(
    muscle: Muscle, muscles: tuple[Muscle, ...], fit: DenseFit, structure: Structure, pivot: Floats
) -> Floats | None:
    """Return the `(S, 3)` seam on the target of a muscle that closes a lid around a ball, None if it closes none.

    Args:
        muscle: a ring over a ball.
        muscles: all of the rig's; the one that closes onto the same seam moves the other lid.
        fit: the correspondence.
        structure: the warp of what lies under the skin.
        pivot: the ball's centre on the target.
    """
    seam, centre = muscle.seam, muscle.pivot
    if seam is None or centre is None:
        return None
    pair = [m for m in muscles if m.seam is not None and m.pivot is not None and np.array_equal(m.seam, seam)]
    edges = [_edge(one, fit) for one in pair]
    if len(edges) != 2 or min(len(edge.along) for edge in edges) < 4:
        return None
    along = (seam - seam[0]) @ unit(seam[-1] - seam[0])
    (upper, above), (lower, below) = (edge.at(along) for edge in edges)
    share = _share(upper, lower, seam, centre)
    here = upper + drawn(upper, lower, share, centre)
    there = above + drawn(above, below, share, pivot)
    # how the seam lay off the edges' way is kept, so that a face laid on itself keeps its seam
    turn, scale = structure.around(centre)
    off = scale * (seam - here) @ turn.T
    plain = scale * (seam - seam[0]) @ turn.T
    basis = np.polynomial.legendre.legvander(2 * (along - along[0]) / (along[-1] - along[0]) - 1, DEGREE)
    return np.asarray(plain + basis @ np.linalg.lstsq(basis, there + off - plain, rcond=None)[0])


def clear_of(seam: Floats, parts: Floats, pivot: Floats) -> Floats:
    """Return a seam `(S, 3)` that lies outside of the eyeball, a bulging cornea included.

    Args:
        seam: the line on which lids meet.
        parts: `(E, 3)` vertices of what is not skin; what is far from the ball does not count.
        pivot: the ball's centre.
    """
    arms, own = seam - pivot, parts - pivot
    height = np.linalg.norm(own, axis=1)
    height = np.where(height < AROUND * np.linalg.norm(arms, axis=1).mean(), height, 0)
    beneath = unit(arms) @ unit(own).T > BESIDE
    least = (1 + OVER) * np.where(beneath, height, 0).max(axis=1, initial=0.0)
    length = np.linalg.norm(arms, axis=1)
    along = np.linspace(0, 1, len(seam))
    inward = np.clip((np.minimum(along, 1 - along) - CORNER) / CORNER, 0, 1)
    return np.asarray(pivot + (1 + inward * (np.maximum(1, least / length) - 1))[:, None] * arms)


def _edge(muscle: Muscle, fit: DenseFit) -> Edge:
    """Return the edge of the lid that a muscle closes, with the corners of the eye at its ends."""
    assert muscle.seam is not None
    edge = np.flatnonzero((muscle.weights >= FULLY) & fit.paired)
    skin = np.flatnonzero(fit.paired)
    corners = [int(skin[((fit.source.vertices[skin] - end) ** 2).sum(axis=1).argmin()]) for end in muscle.seam[[0, -1]]]
    ids: Ints = np.unique(np.concatenate([edge, corners]))
    along = (fit.source.vertices[ids] - muscle.seam[0]) @ unit(muscle.seam[-1] - muscle.seam[0])
    order = np.argsort(along, kind="stable")
    return Edge(along[order], fit.source.vertices[ids[order]], fit.stuck[ids[order]])


def _share(start: Floats, end: Floats, places: Floats, pivot: Floats) -> Floats:
    """Return at which share of the way around a ball from start to end places lie, `(S,)`."""
    a, b, p = (unit(points - pivot) for points in (start, end, places))
    whole = np.arccos(np.clip((a * b).sum(axis=1), -1, 1))
    first = np.arccos(np.clip((a * p).sum(axis=1), -1, 1))
    return np.asarray(np.clip(np.divide(first, whole, out=np.full(len(whole), 0.5), where=whole > 1e-6), 0, 1))
