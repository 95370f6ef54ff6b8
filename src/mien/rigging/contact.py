"""Lids that close and lips that meet on the source do so on the target.

Correspondence and deltas are each good to a fraction of a millimetre at best, and a slit
shows every part of it.  So the pairs of points that touch in a source's pose are found,
carried to the target, and what is missing between them is made up there by the smoothest
small change of the delta: the minimum of `∫ |Δc|² + |c|²/ℓ⁴` over the target's own
surface.  Upper and lower lip are far apart along the surface, so one does not drag the
other; and beyond a few lengths `ℓ` nothing changes at all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from mien.core.arrays import Floats, Ints
from mien.core.units import human_centimetre
from mien.geometry.laplacian import cotangent_laplacian
from mien.rigging.blendshapes.maps import overall, stretch
from mien.rigging.dense import DenseFit
from mien.rigging.touching import MEET_CM, Contacts, Touching

SPREAD_CM = 0.5
"""The length `ℓ` over which a correction fades."""
REACH = 3.0
"""Beyond so many of these lengths from every contact nothing changes."""
ENOUGH = 0.1
"""Poses in which nothing is off by more than this share of what counts as touching are left as they are."""
SOFT = 1e-3
"""How much contacts that contradict each other give way, relative to the compliance of the surface."""
ALONG = 6
"""Contacts next to one another along a slit tell which way it runs."""
BATCH = 64
"""Columns solved at a time; it bounds the memory."""


@dataclass(frozen=True)
class Closing:
    """What correcting one pose did to its gaps [m], the largest across the slit.

    Attributes:
        name: of the pose.
        contacts: how many pairs of points touch.
        before, after: how far the pairs were, and are, from touching as on the source.
    """

    name: str
    contacts: int
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
        across: `(C, 3, 3)` projections across the slit: along it points may slide.
    """

    name: str
    shapes: tuple[int, ...]
    changed: int
    difference: sparse.csr_matrix
    goal: Floats
    across: Floats

    def missing(self, posed: Floats) -> Floats:
        """Return what is missing `(C, 3)` in a pose `(N, 3)`."""
        return np.asarray(np.einsum("cab,cb->ca", self.across, self.goal - self.difference @ posed))


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
    meetings = []
    for name, rows in poses.items():
        displacement = deltas[list(rows)].sum(axis=0)
        contacts = touching.contacts(displacement)
        if len(contacts):
            meetings.append(_carried(name, rows, contacts, fit.source.vertices + displacement, fit))
    result = np.array(moved)
    if not meetings:
        return result, ()
    sheet = Sheet(fit, meetings)
    enough = ENOUGH * MEET_CM * human_centimetre(fit.warp(fit.warp.centres))
    account = []
    for meeting in meetings:
        posed = fit.target.vertices + result[list(meeting.shapes)].sum(axis=0)
        missing = meeting.missing(posed)
        before = float(np.linalg.norm(missing, axis=1).max())
        if before <= enough:
            continue
        change = sheet.change(meeting, missing)
        result[meeting.changed] += change
        after = float(np.linalg.norm(meeting.missing(posed + change), axis=1).max())
        account.append(Closing(meeting.name, len(missing), before, after))
    return result, tuple(account)


def _carried(name: str, rows: tuple[int, ...], contacts: Contacts, posed: Floats, fit: DenseFit) -> Meeting:
    """Carry contacts of the source, posed as `(Ns, 3)`, to the target."""
    n, c = len(fit.target.vertices), len(contacts)
    place = sparse.csr_matrix(
        (fit.points.weights.ravel(), (np.repeat(np.arange(len(fit.points)), 3), fit.points.corners.ravel())),
        shape=(len(fit.points), n),
    )
    opposite = sparse.csr_matrix(
        (contacts.opposite.weights.ravel(), (np.repeat(np.arange(c), 3), contacts.opposite.corners.ravel())),
        shape=(c, len(fit.points)),
    )
    difference = (place[contacts.vertices] - opposite @ place).tocsr()
    source, turn = fit.source.vertices, overall(fit).rotation
    enlarged = stretch(fit, source[contacts.vertices])[:, None]
    goal = enlarged * contacts.gaps @ turn.T
    # what touches at rest keeps the target's own gap there, and only its change is the source's
    resting = source[contacts.vertices] - contacts.opposite.of(source)
    own = difference @ fit.target.vertices - enlarged * resting @ turn.T
    goal += np.where(contacts.met[:, None], own, 0.0)
    return Meeting(name, rows, rows[-1], difference, goal, _across(posed[contacts.vertices], turn))


def _across(points: Floats, turn: Floats) -> Floats:
    """Return for each contact `(C, 3)` the projection across the line that it and its neighbours form, turned."""
    count = min(ALONG, len(points))
    if count < 3:
        return np.tile(np.eye(3), (len(points), 1, 1))
    near = points[cKDTree(points).query(points, count)[1]]
    along = np.linalg.svd(near - near.mean(axis=1, keepdims=True))[2][:, 0] @ turn.T
    return np.asarray(np.eye(3) - along[:, :, None] * along[:, None, :])


class Sheet:
    """The target's skin around all contacts, as something that bends: factored once for all poses."""

    def __init__(self, fit: DenseFit, meetings: list[Meeting]) -> None:
        vertices = fit.target.vertices
        faces = fit.target.triangles[fit.target_skin[fit.target.triangles].all(axis=1)]
        length = SPREAD_CM * human_centimetre(fit.warp(fit.warp.centres))
        self.handles = np.unique(np.concatenate([m.difference.indices for m in meetings]))
        far, _ = cKDTree(vertices[self.handles]).query(vertices, distance_upper_bound=REACH * length)
        self.free = np.flatnonzero(np.isfinite(far) & np.isin(np.arange(len(vertices)), faces))
        laplacian = cotangent_laplacian(vertices, faces)
        area = _areas(vertices, faces)
        bending = laplacian[:, self.free]
        energy = bending.T @ sparse.diags(1 / area) @ bending + sparse.diags(area[self.free] / length**4)
        factor = splu(
            energy.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        where = np.searchsorted(self.free, self.handles)
        self.influence = np.empty((len(self.free), len(self.handles)))
        for first in range(0, len(self.handles), BATCH):
            unit = np.zeros((len(self.free), len(where[first : first + BATCH])))
            unit[where[first : first + BATCH], np.arange(unit.shape[1])] = 1
            self.influence[:, first : first + BATCH] = factor.solve(unit)
        self.compliance = self.influence[where]
        self.count = len(vertices)

    def change(self, meeting: Meeting, missing: Floats) -> Floats:
        """Return the smoothest displacement `(N, 3)` that makes up what is missing `(C, 3)`."""
        pull = meeting.difference[:, self.handles].toarray()
        flexible = pull @ self.compliance @ pull.T
        c = len(missing)
        system = np.einsum("iab,ij,jbd->iajd", meeting.across, flexible, meeting.across).reshape(3 * c, 3 * c)
        system += SOFT * np.trace(flexible) / c * np.eye(3 * c)
        force = np.linalg.solve(system, missing.ravel()).reshape(c, 3)
        change = np.zeros((self.count, 3))
        change[self.free] = self.influence @ (pull.T @ np.einsum("cab,cb->ca", meeting.across, force))
        return change


def _areas(vertices: Floats, faces: Ints) -> Floats:
    """`(N,)` a third of the area of the triangles around each vertex, never quite zero."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
    shares = np.bincount(faces.ravel(), np.repeat(area, 3), minlength=len(vertices))
    return np.asarray(np.maximum(shares, 1e-3 * area.mean()))
