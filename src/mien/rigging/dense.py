"""Every point of one face found on another: the correspondence that all of rig transfer rests on.

A source face is laid on a target face by a few landmarks (Orvalho et al., eq. 1-4): the
thin-plate warp brings every feature near its counterpart, and sticking puts every vertex on
the target's surface.  What carries no landmark (eyes, teeth, lashes) is not skin and is left
where the warp brings it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mien.core import Mesh, Note, SurfacePoints
from mien.core.arrays import Flags, Floats, Ints
from mien.core.units import face_radius
from mien.geometry.tps import ThinPlate, fit_thin_plate
from mien.rigging.warp_and_stick.confirm import confirmed
from mien.rigging.warp_and_stick.folds import folded, smooth_out
from mien.rigging.warp_and_stick.sheet import Sheet, skin_of, twins_of
from mien.rigging.warp_and_stick.sides import Slit, righted, sides, slits_of
from mien.rigging.warp_and_stick.stick import Anchors, stick

NEAR_SEAM = 0.15
"""Within this share of the face's radius from a seam, the way back is compared with the way there."""
ENOUGH = 1000
"""So many points of a face tell whether another is inside out."""


@dataclass(frozen=True, eq=False)
class DenseFit:
    """A source face laid on a target face (Orvalho et al., eq. 1-4).

    Attributes:
        source, target: the two meshes.
        source_skin: `(Ns,)` which vertices are skin: connected to a landmark.
        target_skin: `(Nt,)` the same of the target.
        warp: the thin-plate warp of the landmarks.
        warped: `(Ns, 3)` the source after the warp.
        points: where each source vertex is on the target; of no meaning off the skin.
        stuck: `(Ns, 3)` those points' positions; off the skin, the warped positions.
        paired: `(Ns,)` skin that has a counterpart: not so the inside of a mouth on a face without one.
        back: where each target vertex is on the source; of no meaning off the skin.
        back_distance: `(Nt,)` how far each target vertex is from the stuck source [m].
        folds_before, folds_after: triangles of the source turned over by sticking, before and after repair.
        notes: what was repaired.
    """

    source: Mesh
    target: Mesh
    source_skin: Flags
    target_skin: Flags
    warp: ThinPlate
    warped: Floats
    points: SurfacePoints
    stuck: Floats
    paired: Flags
    back: SurfacePoints
    back_distance: Floats
    folds_before: int
    folds_after: int
    notes: tuple[Note, ...] = ()


@dataclass(frozen=True, eq=False)
class _Side:
    """One face as both directions of sticking need it."""

    mesh: Mesh
    landmarks: SurfacePoints
    twins: Ints
    skin: Flags
    sheet: Sheet
    radius: float
    order: Floats

    @classmethod
    def of(cls, mesh: Mesh, landmarks: SurfacePoints) -> _Side:
        twins = twins_of(mesh.vertices, mesh.triangles)
        carrying = landmarks.corners[landmarks.weights > 1e-9]
        skin = skin_of(mesh.triangles, twins, len(mesh.vertices), carrying)
        triangles = mesh.triangles[skin[mesh.triangles].all(axis=1)]
        sheet = Sheet.of(mesh.vertices, triangles, twins)
        radius = face_radius(landmarks.of(mesh.vertices))
        return cls(mesh, landmarks, twins, skin, sheet, radius, sheet.order(radius, carrying))

    def turned(self) -> _Side:
        """Return the face with its other side out."""
        triangles = self.sheet.triangles[:, ::-1]
        return replace(self, sheet=Sheet.of(self.mesh.vertices, triangles, self.twins))

    def sides(self, slits: list[Slit]) -> Floats:
        """Return the sides of slits `(S, N)`."""
        return sides(self.sheet, self.landmarks, slits, self.radius)

    def anchors(self, places: SurfacePoints) -> Anchors:
        """Pair the corners of the landmarks with where the landmarks are on the other face."""
        rows, corners = np.nonzero(self.landmarks.weights > 1e-9)
        exact = self.landmarks.weights[rows, corners] > 1 - 1e-9
        return Anchors(self.landmarks.corners[rows, corners], places.take(rows), exact)


def lay(
    source: Mesh,
    source_landmarks: SurfacePoints,
    target: Mesh,
    target_landmarks: SurfacePoints,
    *,
    repair: bool = True,
) -> DenseFit:
    """Lay a source face on a target face.

    Args:
        source: the face that brings something along.
        source_landmarks: `L` landmarks on it.
        target: the face that receives it.
        target_landmarks: the same landmarks on the target.
        repair: whether folds are relaxed.

    Raises:
        InputError: fewer than 4 landmarks, landmarks in one plane, or coinciding.
    """
    warp = fit_thin_plate(source_landmarks.of(source.vertices), target_landmarks.of(target.vertices))
    warped = warp(source.vertices)
    from_side = _Side.of(source, source_landmarks)
    film = from_side.sheet.at(warped)
    to_side = _Side.of(target, target_landmarks)
    inside_out = _faces_away(film, to_side.sheet)
    if inside_out:
        to_side = to_side.turned()
    anchors = from_side.anchors(target_landmarks)
    stuck = stick(film, from_side.order, to_side.sheet, anchors, to_side.radius)
    slits = slits_of(from_side.sheet, source_landmarks, from_side.radius)
    here, there = (side.sides(slits) for side in (from_side, to_side))
    loose = from_side.skin.copy()
    loose[anchors.vertices[anchors.exact]] = False
    points, there_again = righted(film, here, to_side.sheet, there, stuck.points, loose)
    before = int(folded(warped, points.of(target.vertices), film.triangles).sum())
    after = before
    if repair and before:
        exact = anchors.vertices[anchors.exact]
        points = smooth_out(film, from_side.twins, to_side.sheet, points, exact, to_side.radius)
        after = int(folded(warped, points.of(target.vertices), film.triangles).sum())
    positions = np.where(from_side.skin[:, None], points.of(target.vertices), warped)
    paired = from_side.skin & ~stuck.adrift

    ground = from_side.sheet.at(positions, np.asarray(paired[film.triangles].all(axis=1)))
    back = stick(to_side.sheet, to_side.order, ground, to_side.anchors(source_landmarks), to_side.radius)
    seams = to_side.skin & (to_side.order < NEAR_SEAM * to_side.radius)
    ways_back, _ = confirmed(to_side.sheet, points, ground, back.points, seams)
    ways_back, back_again = righted(to_side.sheet, there, ground, here, ways_back, to_side.skin)
    back_distance = np.linalg.norm(ways_back.of(positions) - target.vertices, axis=1)
    return DenseFit(
        source,
        target,
        from_side.skin,
        to_side.skin,
        warp,
        warped,
        points,
        positions,
        paired,
        ways_back,
        back_distance,
        before,
        after,
        _notes(inside_out, before, after, int(stuck.adrift.sum()), there_again + back_again),
    )


def _faces_away(film: Sheet, ground: Sheet) -> bool:
    """Tell whether the target's triangles are turned the other way than the source's."""
    some = film.used[:: 1 + len(film.used) // ENOUGH]
    _, _, which = ground.ground.closest(film.vertices[some])
    return bool(np.median((ground.normals[which] * film.facing[some]).sum(axis=1)) < 0)


def _notes(inside_out: bool, before: int, after: int, adrift: int, astray: int) -> tuple[Note, ...]:
    notes = []
    if inside_out:
        notes.append(Note("inside-out", "the faces of the target are turned the other way than the source's."))
    if before > after:
        notes.append(Note("folds-repaired", f"{before - after} of {before} folds were smoothed out."))
    if adrift:
        notes.append(Note("without-counterpart", f"{adrift} points of the source have no counterpart on the target."))
    if astray:
        notes.append(Note("sides-kept", f"{astray} points were brought back to their own side of a lip or lid."))
    return tuple(notes)
