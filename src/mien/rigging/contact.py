"""Lids that close and lips that meet on the source do so on the target.

Correspondence and deltas are each good to a fraction of a millimetre at best, and a slit
shows every part of it.  So the pairs of points that touch in a source's pose are found,
carried to the target, and what is missing between them is made up there by smooth bumps
around the points, each side meeting the other.  A bump fades with the distance in space,
so that the layers of a lid move as one; and with the way along the skin, so that it ends
at the slit: upper and lower lip are close in space and far from each other along the skin.
Beyond a bump's reach nothing changes at all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial import cKDTree

from mien.core.arrays import Flags, Floats, Ints
from mien.core.mesh import SurfacePoints
from mien.core.units import human_centimetre
from mien.geometry.surface import unit
from mien.rigging.dense import DenseFit
from mien.rigging.maps import overall, stretch
from mien.rigging.touching import MEET_CM, Contacts, Touching, edge_lengths, ways_of
from mien.rigging.warp_and_stick.walk import surroundings

REACH_CM = 1.2
"""A bump ends this far from its point in space, on a human face …"""
ALONG_CM = (0.8, 1.6)
"""… and fades over these distances along the skin."""
FAR_CM = 0.4
"""Points that are this much farther from touching, or on this much another way to it, than those around them are no
pair on this face: they stay as they are, and are counted."""
FARTHEST_CM = 1.6
"""So are all that are farther than this from touching."""
ENOUGH = 0.05
"""Poses in which nothing is off by more than this share of what counts as touching are left as they are."""
SHUT = 0.1
"""A pose that leaves less than this share of the gap between points that almost touch at rest closes it."""
SOFT = 1e-3
"""How much contacts that contradict each other give way, relative to what a single one feels."""
NEXT = 6
"""Contacts next to one another along a slit tell which way it runs."""


@dataclass(frozen=True)
class Closing:
    """What correcting one pose did to its gaps [m], the largest across the slit.

    Attributes:
        name: of the pose.
        contacts: how many pairs of points touch.
        strays: how many more were too far from each other to be made to.
        before, after: how far the pairs were, and are, from touching as on the source.
    """

    name: str
    contacts: int
    strays: int
    before: float
    after: float


@dataclass(frozen=True, eq=False)
class Meeting:
    """The contacts of a pose, carried to the target.

    Attributes:
        name: of the pose.
        shapes: the rows of the blendshapes that make it up.
        changed: the row that a correction goes to.
        difference: `(C, N)`; applied to positions it gives the gaps.
        goal: `(C, 3)` the gaps as they should be in the pose.
        places: `(C, 3)` of the source, where its points touch.
        across: `(C, 3, 3)` projections onto what counts: the way the sides stand apart at rest or, of points that
            touch at rest, everything across the slit.
        apart: `(C, 3)` the target's gaps at rest, zero where the points touch at rest on the source.
    """

    name: str
    shapes: tuple[int, ...]
    changed: int
    difference: sparse.csr_matrix
    goal: Floats
    places: Floats
    across: Floats
    apart: Floats

    def missing(self, posed: Floats) -> Floats:
        """Return what is missing `(C, 3)` in a pose `(N, 3)`."""
        return np.asarray(np.einsum("cab,cb->ca", self.across, self.goal - self.difference @ posed))

    def open(self, missing: Floats) -> Flags:
        """Return `(C,)` where the sides have not met: not where one has come to lie over the other."""
        return np.asarray((missing * self.apart).sum(axis=1) <= 0)

    def pressed(self, posed: Floats) -> Flags:
        """Return `(C,)` where points that touch at rest are closer together than they should be, but not yet through."""
        gaps = np.asarray(self.difference @ posed)
        short, long = (np.linalg.norm(np.einsum("cab,cb->ca", self.across, v), axis=1) for v in (gaps, self.goal))
        return np.asarray(~self.apart.any(axis=1) & (short < long) & ((gaps * self.goal).sum(axis=1) > 0))

    def alike(self, missing: Floats, most: float, within: float) -> Flags:
        """Return `(C,)` where what is missing is about the median of what is missing around it: within `most` or half."""
        count = min(NEXT, len(missing))
        which = cKDTree(self.places).query(self.places, count, distance_upper_bound=within)[1]
        around = np.vstack([missing, np.full((1, 3), np.nan)])[which.reshape(len(missing), count)]
        middle = np.nanmedian(around, axis=1)
        least = np.maximum(most, 0.5 * np.linalg.norm(middle, axis=1))
        return np.asarray(np.linalg.norm(missing - middle, axis=1) <= least)

    def take(self, rows: Ints) -> Meeting:
        """Keep some of the pairs."""
        return replace(
            self,
            difference=self.difference[rows],
            goal=self.goal[rows],
            places=self.places[rows],
            across=self.across[rows],
            apart=self.apart[rows],
        )


def close(
    deltas: Floats, moved: Floats, poses: Mapping[str, tuple[int, ...]], fit: DenseFit
) -> tuple[Floats, tuple[Closing, ...]]:
    """Correct a target's shapes so that what touches on the source touches on the target.

    Args:
        deltas: `(K, Ns, 3)` the source's shapes.
        moved: `(K, Nt, 3)` the target's.
        poses: the rows of the shapes that make up each pose, by its name; the last is the one to correct.
        fit: the correspondence.

    Returns:
        The corrected `(K, Nt, 3)`, and what was done pose by pose.
    """
    touching = Touching(fit.source, fit.source_skin, human_centimetre(fit.warp.centres))
    meetings, place = [], _rows(fit.points, len(fit.target.vertices))
    for name, rows in poses.items():
        displacement = deltas[list(rows)].sum(axis=0)
        contacts = touching.contacts(displacement)
        contacts = contacts.take(fit.paired[contacts.vertices] & fit.paired[contacts.opposite.corners].all(axis=1))
        if len(contacts):
            meetings.append(_carried(name, rows, contacts, fit.source.vertices + displacement, fit, place))
    result = np.array(moved)
    if not meetings:
        return result, ()
    bumps = Bumps(fit, meetings)
    centimetre = human_centimetre(fit.warp(fit.warp.centres))
    account = []
    for meeting in meetings:
        posed = fit.target.vertices + result[list(meeting.shapes)].sum(axis=0)
        missing = meeting.missing(posed)
        wanting = meeting.open(missing) & ~meeting.pressed(posed)
        near = meeting.alike(missing, FAR_CM * centimetre, REACH_CM * touching.centimetre)
        near &= np.linalg.norm(missing, axis=1) <= FARTHEST_CM * centimetre
        pairs, missing = meeting.take(np.flatnonzero(wanting & near)), missing[wanting & near]
        before = float(np.linalg.norm(missing, axis=1).max(initial=0.0))
        if before <= ENOUGH * MEET_CM * centimetre:
            continue
        change = bumps.change(pairs, missing)
        result[meeting.changed] += change
        left = pairs.missing(posed + change)
        after = float(np.linalg.norm(left[pairs.open(left)], axis=1).max(initial=0.0))
        account.append(Closing(meeting.name, len(missing), int((wanting & ~near).sum()), before, after))
    return result, tuple(account)


def _rows(points: SurfacePoints, count: int) -> sparse.csr_matrix:
    """Return the `(P, count)` matrix that interpolates values of vertices at points."""
    ends = np.arange(0, 3 * len(points) + 1, 3)
    return sparse.csr_matrix((points.weights.ravel(), points.corners.ravel(), ends), shape=(len(points), count))


def _carried(
    name: str, rows: tuple[int, ...], contacts: Contacts, posed: Floats, fit: DenseFit, place: sparse.csr_matrix
) -> Meeting:
    """Carry contacts of the source, posed as `(Ns, 3)`, to the target; `place` takes the target's vertices to them."""
    difference = (place[contacts.vertices] - _rows(contacts.opposite, len(fit.points)) @ place).tocsr()
    source, turn = fit.source.vertices, overall(fit).rotation
    enlarged = stretch(fit, source[contacts.vertices])[:, None]
    goal = enlarged * contacts.gaps @ turn.T
    # what touches at rest keeps the target's own gap there, and only its change is the source's, unless that closes it
    resting = source[contacts.vertices] - contacts.opposite.of(source)
    gap, apart_by = np.linalg.norm(contacts.gaps, axis=1), np.linalg.norm(resting, axis=1)
    closing = (gap < SHUT * apart_by) & (apart_by > 0.5 * MEET_CM * human_centimetre(fit.warp.centres))
    met = contacts.met & ~closing
    apart = difference @ fit.target.vertices
    goal += np.where(met[:, None], apart - enlarged * resting @ turn.T, 0.0)
    apart[met] = 0
    way = unit(apart)
    across = _across(posed[contacts.vertices], turn)
    across[~met] = (way[:, :, None] * way[:, None, :])[~met]
    return Meeting(name, rows, rows[-1], difference, goal, posed[contacts.vertices], across, apart)


def _across(points: Floats, turn: Floats) -> Floats:
    """Return for each contact `(C, 3)` the projection across the line that it and its neighbours form, turned."""
    count = min(NEXT, len(points))
    if count < 3:
        return np.tile(np.eye(3), (len(points), 1, 1))
    near = points[cKDTree(points).query(points, count)[1]]
    along = np.linalg.svd(near - near.mean(axis=1, keepdims=True))[2][:, 0] @ turn.T
    return np.asarray(np.eye(3) - along[:, :, None] * along[:, None, :])


class Bumps:
    """Smooth bumps around every point of the target that touches something in some pose.

    Attributes:
        handles: `(H,)` the vertices they stand around.
        height: `(N, H)` each bump at every vertex.
    """

    def __init__(self, fit: DenseFit, meetings: list[Meeting]) -> None:
        centimetre = human_centimetre(fit.warp(fit.warp.centres))
        vertices, reach = fit.target.vertices, REACH_CM * centimetre
        self.handles = np.unique(np.concatenate([meeting.difference.indices for meeting in meetings]))
        first, last = (centimetre * length for length in ALONG_CM)
        own = fit.target.triangles[fit.target_skin[fit.target.triangles].all(axis=1)]
        ends, near, along = surroundings(ways_of(edge_lengths(vertices, own)[0]), self.handles.astype(np.int64), last)
        distance = np.linalg.norm(vertices[near] - np.repeat(vertices[self.handles], np.diff(ends), axis=0), axis=1)
        distance, fade = np.minimum(distance / reach, 1), np.clip((last - along) / (last - first), 0, 1)
        # Wendland's C² function: smooth, and exactly zero beyond its reach
        height = (1 - distance) ** 4 * (4 * distance + 1) * fade * fade * (3 - 2 * fade)
        self.height = sparse.csc_matrix((height, near, ends), shape=(len(vertices), len(self.handles))).tocsr()

    def change(self, meeting: Meeting, missing: Floats) -> Floats:
        """Return the displacement `(N, 3)` that makes up what is missing `(C, 3)`, each side going its part."""
        c, pull = len(missing), meeting.difference[:, self.handles]
        felt = (pull @ self.height[self.handles] @ pull.T).toarray()
        across = meeting.across.reshape(3 * c, 3) @ meeting.across.transpose(1, 0, 2).reshape(3, 3 * c)
        system = across * felt.repeat(3, axis=0).repeat(3, axis=1)
        give = SOFT * float(np.abs(np.diag(felt)).mean()) ** 2
        definite = system @ system.T
        definite[np.diag_indices(3 * c)] += give
        force = system.T @ cho_solve(cho_factor(definite, overwrite_a=True), missing.ravel())
        return np.asarray(self.height @ (pull.T @ np.einsum("cab,cb->ca", meeting.across, force.reshape(c, 3))))
