"""Every point of one face found on another: the correspondence that all of rig transfer rests on.

A source face is laid on a target face by a few landmarks (Orvalho et al., eq. 1-4): the
thin-plate warp brings every feature near its counterpart, and sticking puts every vertex on
the target's surface.  What carries no landmark (eyes, teeth, lashes) is not skin and is left
where the warp brings it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from mien.core import Mesh, Note, SurfacePoints
from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import closest_points, triangle_normals
from mien.geometry.tps import ThinPlate, fit_thin_plate


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
    back: SurfacePoints
    back_distance: Floats
    folds_before: int
    folds_after: int
    notes: tuple[Note, ...] = ()


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
    source_skin = skin_of(source, source_landmarks)
    target_skin = skin_of(target, target_landmarks)
    warp = fit_thin_plate(source_landmarks.of(source.vertices), target_landmarks.of(target.vertices))
    warped = warp(source.vertices)
    faces = target.triangles[target_skin[target.triangles].all(axis=1)]
    points, _, _ = closest_points(target.vertices, faces, warped)
    stuck = np.where(source_skin[:, None], points.of(target.vertices), warped)
    own = source.triangles[source_skin[source.triangles].all(axis=1)]
    back, distance, _ = closest_points(stuck, own, target.vertices)
    folds = count_folds(warped, stuck, own)
    return DenseFit(
        source, target, source_skin, target_skin, warp, warped, points, stuck, back, distance, folds, folds
    )


def skin_of(mesh: Mesh, landmarks: SurfacePoints) -> Flags:
    """Return which vertices are connected to a landmark `(N,)`."""
    n = len(mesh.vertices)
    a, b = np.concatenate([mesh.triangles[:, [i, (i + 1) % 3]] for i in range(3)]).T
    _, part = connected_components(csr_matrix((np.ones(len(a)), (a, b)), shape=(n, n)), directed=False)
    return np.asarray(np.isin(part, part[landmarks.corners]))


def count_folds(before: Floats, after: Floats, triangles: Ints) -> int:
    """Count the triangles whose orientation flips."""
    return int(((triangle_normals(before, triangles) * triangle_normals(after, triangles)).sum(axis=1) < 0).sum())
