"""From a few landmarks to many pairs, each on its own side of lips and lids.

The actor's points are carried onto the character by the thin-plate warp of the
landmarks and put on the nearest surface (Orvalho et al., eq. 1-4).  Nearest in space
can mean the wrong lip: lips that touch are neighbours in space and strangers along
the skin.  Two checks keep each point on its own side, and where one fails the search
is repeated on the part of the surface that passes:

- the surface must face the way the warped surface faced;
- *seams*: where two landmarks are close in space but far along the skin (upper and
  lower lip, upper and lower lid), a point nearer one of them along the actor's face
  must end nearer the same one along the character's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from mien.core.arrays import Flags, Floats, Ints
from mien.core.errors import InputError
from mien.core.mesh import Mesh, SurfacePoints
from mien.core.units import face_radius
from mien.geometry.surface import closest_points, distances_along, triangle_normals, unit, vertex_normals, visible_from
from mien.geometry.tps import fit_thin_plate

SEAM_RATIO = 1.8
"""Two landmarks face each other over a seam if the way along the skin is longer by this factor."""
SEAM_DETOUR = 0.12
"""… the way along is longer by this share of the face's radius (an edge path zigzags over short distances)"""
SEAM_REACH = 0.35
"""… and they are nearer in space than this share of the face's radius."""
SIDE_REACH = 0.5
"""Points farther than this share of the face's radius from a seam are not held to a side of it."""
SIDE_MARGIN = 0.2
"""A side counts only if one landmark is nearer than the other by this share of the way between them."""


@dataclass(frozen=True, eq=False)
class ActorPoints:
    """The points to place on a character.

    Attributes:
        positions: `(M, 3)` on the actor's neutral face.
        to_landmarks: `(M, L)` distances to the landmarks: along the skin if there is a mesh.
        landmark: `(M,)` the landmark a point is, -1 for none; such points need no search.
        normals: `(M, 3)` outward normals, or None for markers without a surface.
    """

    positions: Floats
    to_landmarks: Floats
    landmark: Ints
    normals: Floats | None = None


@dataclass(frozen=True, eq=False)
class Placement:
    """Where the points ended on the character.

    Attributes:
        points: the surface points.
        confidence: `(M,)` 1 where the warped point already lay on the surface, falling with distance.
        moved_aside: indices of points whose nearest surface was on the wrong side.
        lost: indices of points for which no surface passed the checks; the nearest was taken.
    """

    points: SurfacePoints
    confidence: Floats
    moved_aside: tuple[int, ...]
    lost: tuple[int, ...]


def place(actor: ActorPoints, actor_landmarks: Floats, target: Mesh, target_landmarks: SurfacePoints) -> Placement:
    """Put an actor's points on a character.

    Args:
        actor: the points.
        actor_landmarks: `(L, 3)` landmarks of the actor's neutral face.
        target: the character's neutral.
        target_landmarks: the same `L` landmarks on it.

    Raises:
        InputError: fewer than 4 landmarks, in one plane, or coinciding.
    """
    landmarks = target_landmarks.of(target.vertices)
    radius = face_radius(landmarks)
    warp = fit_thin_plate(actor_landmarks, landmarks)
    warped = warp(actor.positions)
    points, distance, where = closest_points(target.vertices, target.triangles, warped)

    along = distances_along(target, _nearest_corner(target_landmarks))
    seams = seam_pairs(landmarks, along[:, _nearest_corner(target_landmarks)], radius)
    sides = _sides(actor.to_landmarks, seams, landmarks, radius)
    reached = np.asarray(np.isfinite(along).any(axis=0))  # not eyeballs, teeth or lashes: parts without a landmark
    along = np.where(reached, along, 0.0)
    corner_side = np.sign(along[seams[:, 1]] - along[seams[:, 0]])
    skin = reached[target.triangles].all(axis=1)
    facing = None if actor.normals is None else _warped_normals(warp.jacobian(actor.positions), actor.normals)
    normals = triangle_normals(target.vertices, target.triangles)

    def passing(i: int) -> Flags:
        ok = np.array(skin)
        if facing is not None:
            ok &= normals @ facing[i] > 0.2
        for s in np.flatnonzero(sides[i]):
            ok &= (corner_side[s][target.triangles] == sides[i, s]).all(axis=1)
        return ok

    corners, weights = points.corners.copy(), points.weights.copy()
    aside, lost = [], []
    for i in np.flatnonzero(actor.landmark < 0).tolist():
        ok = passing(i)
        if ok[where[i]]:
            continue
        if not ok.any():
            lost.append(i)
            continue
        near, d, _ = closest_points(target.vertices, target.triangles[ok], warped[i : i + 1])
        if d[0] > distance[i] + 0.5 * radius:
            lost.append(i)
            continue
        corners[i], weights[i], distance[i] = near.corners[0], near.weights[0], d[0]
        aside.append(i)
    confidence = np.exp(-((distance / (0.1 * radius)) ** 2))
    confidence[lost] = 0
    known = np.flatnonzero(actor.landmark >= 0)
    corners[known] = target_landmarks.corners[actor.landmark[known]]
    weights[known] = target_landmarks.weights[actor.landmark[known]]
    confidence[known] = 1
    return Placement(SurfacePoints(corners, weights), confidence, tuple(aside), tuple(lost))


def seam_pairs(landmarks: Floats, along: Floats, radius: float) -> Ints:
    """Return `(S, 2)` pairs of landmarks that face each other over a slit in the skin.

    Args:
        landmarks: `(L, 3)`.
        along: `(L, L)` distances along the skin.
        radius: the face's radius.
    """
    apart: Floats = cdist(landmarks, landmarks)
    faces = (apart < SEAM_REACH * radius) & (along > SEAM_RATIO * apart) & np.isfinite(along)
    faces &= along - apart > SEAM_DETOUR * radius
    return np.asarray(np.argwhere(np.triu(faces, 1)))


def _sides(to_landmarks: Floats, seams: Ints, landmarks: Floats, radius: float) -> Ints:
    """`(M, S)`: +1 on the first landmark's side of a seam, -1 on the second's, 0 undecided or far."""
    first, second = to_landmarks[:, seams[:, 0]], to_landmarks[:, seams[:, 1]]
    width = np.linalg.norm(landmarks[seams[:, 0]] - landmarks[seams[:, 1]], axis=1)
    near = np.minimum(first, second) < SIDE_REACH * radius
    clear = np.abs(first - second) > np.maximum(SIDE_MARGIN * width, 0.02 * radius)
    return np.where(near & clear, np.sign(second - first), 0).astype(np.int64)


def _warped_normals(jacobian: Floats, normals: Floats) -> Floats:
    # a normal is a covector: it goes with the inverse transpose
    return unit(np.einsum("mac,ma->mc", np.linalg.pinv(jacobian), normals))


def _nearest_corner(points: SurfacePoints) -> Ints:
    return np.asarray(points.corners[np.arange(len(points)), np.argmax(points.weights, axis=1)])


def marker_points(markers: Floats, landmarks: Floats) -> ActorPoints:
    """Describe captured markers `(M, 3)` beside the actor's landmarks `(L, 3)`."""
    apart = cdist(markers, landmarks)
    return ActorPoints(markers, apart, _which_landmark(apart))


def mesh_points(mesh: Mesh, points: SurfacePoints, landmarks: SurfacePoints) -> ActorPoints:
    """Describe points on the actor's mesh, with distances along its skin."""
    along = distances_along(mesh, _nearest_corner(landmarks))
    normals = vertex_normals(mesh.vertices, mesh.triangles)
    flat = np.where(np.isfinite(along), along, 1e6 * face_radius(mesh.vertices))
    to_landmarks = np.einsum("lmi,mi->ml", flat[:, points.corners], points.weights)
    placed = points.of(mesh.vertices)
    which = _which_landmark(cdist(placed, landmarks.of(mesh.vertices)))
    return ActorPoints(placed, to_landmarks, which, unit(points.of(normals)))


def _which_landmark(apart: Floats) -> Ints:
    return np.where(apart.min(axis=1) == 0, apart.argmin(axis=1), -1)


def spread_points(mesh: Mesh, landmarks: SurfacePoints, count: int) -> SurfacePoints:
    """Choose vertices spread evenly over the part of a face that its landmarks cover.

    The landmarks come first, then always the vertex farthest from those chosen, among
    vertices on the outside of the skin and not far from a landmark.

    Raises:
        InputError: the mesh has fewer usable vertices than `count`.
    """
    placed = landmarks.of(mesh.vertices)
    radius = face_radius(placed)
    along = distances_along(mesh, _nearest_corner(landmarks)).min(axis=0)
    near = np.flatnonzero(along < 0.6 * radius)
    normals = vertex_normals(mesh.vertices, mesh.triangles)
    outside = visible_from(mesh, mesh.vertices[near], normals[near], _views(normals[_nearest_corner(landmarks)]))
    near = near[outside > 0.25]
    gap = cdist(mesh.vertices[near], placed).min(axis=1)
    chosen: list[int] = []
    for _ in range(max(0, count - len(placed))):
        if not len(gap) or gap.max() <= 1e-6 * radius:
            raise InputError(
                f"only {len(placed) + len(chosen)} distinct points of this face can be paired, {count} were asked for."
            )
        best = int(np.argmax(gap))
        chosen.append(int(near[best]))
        gap = np.minimum(gap, np.linalg.norm(mesh.vertices[near] - mesh.vertices[near[best]], axis=1))
    extra = SurfacePoints.at_vertices(np.array(chosen, dtype=np.int64))
    corners = np.vstack([landmarks.corners, extra.corners])[:count]
    return SurfacePoints(corners, np.vstack([landmarks.weights, extra.weights])[:count])


def _views(normals: Floats) -> Floats:
    """Nine viewing directions around the way the face looks."""
    ahead = unit(normals.mean(axis=0))
    across, up = np.linalg.svd(ahead[None])[2][1:]
    fan = [ahead + 0.8 * (i * across + j * up) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return unit(np.array(fan))
