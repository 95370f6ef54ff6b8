"""The landmarks that pair two faces, and whether they can be trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from mien.core import InputError, Mesh, Note, Rig, SurfacePoints
from mien.core.arrays import Flags, Floats
from mien.core.units import face_radius
from mien.geometry.align import similarity
from mien.geometry.surface import closest_points
from mien.rigging.dense import DenseFit
from mien.vocabularies.anthropometry import PAIRED, same_landmarks

FEWEST = 4
FLAT = 0.02
"""Landmarks whose extent in the third direction is below this share of the first's lie in one plane."""
MIRRORED = 0.6
"""Landmarks are taken for mirrored if a mirror image fits them this much better."""
OFF_SURFACE = 0.02
"""A landmark this share of the face's radius from the surface is not on it."""
AROUND = 0.5
"""Whether a mesh is a face is judged from the skin within this share of the radius from a landmark."""
NOT_A_FACE = 0.3
"""A mesh on which the warped face must move this share of its radius to touch the surface is no face …"""
UNCOVERED = 0.05
"""… nor is one on which this share of the face finds nothing that looks the same way: heads, toons and animals
leave up to 0.015, cubes, spheres and rings 0.1 to 0.35, whichever landmarks are put on them."""


@dataclass(frozen=True, eq=False)
class LandmarkPairs:
    """The same landmarks on two faces.

    Attributes:
        names: `L` pairs of names, source and target.
        source, target: `L` points on each.
        notes: what was left out.
    """

    names: tuple[tuple[str, str], ...]
    source: SurfacePoints
    target: SurfacePoints
    notes: tuple[Note, ...] = ()


def paired_landmarks(source: Rig, target: Rig) -> LandmarkPairs:
    """Pair the landmarks of two faces across vocabularies and check them.

    Raises:
        InputError: fewer than 4 are shared, two are at the same place, all lie in one
            plane, or left and right are swapped.
    """
    names = same_landmarks(source.landmarks, target.landmarks)
    if len(names) < FEWEST:
        raise InputError(
            f"{source.name} and {target.name} share {len(names)} landmarks; at least {FEWEST} are needed, not all in one "
            f"plane. {source.name} has {_some(source.landmarks)}; {target.name} has {_some(target.landmarks)}."
        )
    mine = _joined([source.landmarks[a] for a, _ in names])
    theirs = _joined([target.landmarks[b] for _, b in names])
    for rig, marks, column in ((source, mine, 0), (target, theirs, 1)):
        _check_on_surface(rig, [pair[column] for pair in names], marks)
    here, there = mine.of(source.neutral.vertices), theirs.of(target.neutral.vertices)
    for rig, points, column in ((source, here, 0), (target, there, 1)):
        _check_apart(rig.name, [pair[column] for pair in names], points)
        _check_spread(rig.name, points)
    _check_sides(names, here, there, target.name)
    unused = [name for name in target.landmarks if name not in {b for _, b in names}]
    notes: tuple[Note, ...] = ()
    if unused:
        text = (
            f"{len(unused)} landmarks of {target.name} have no counterpart on {source.name}: {', '.join(unused[:12])}."
        )
        notes = (Note("landmarks-unused", text),)
    return LandmarkPairs(names, mine, theirs, notes)


def check_is_face(fit: DenseFit, name: str) -> None:
    """Refuse a mesh on which the source does not come to lie like a face.

    Raises:
        InputError: the warped source is far from the surface, or much of it finds no counterpart there.
    """
    marks = fit.warp.centres
    radius = face_radius(fit.warp(marks))
    near = cKDTree(marks).query(fit.source.vertices)[0] < AROUND * face_radius(marks)
    face = fit.source_skin & near
    moved = np.linalg.norm(fit.stuck - fit.warped, axis=1)[face & fit.paired]
    off = float(np.sqrt((moved**2).mean())) / radius if len(moved) else np.inf
    lost = 1 - float(fit.paired[face].mean())
    if off > NOT_A_FACE or lost > UNCOVERED:
        raise InputError(
            f"{name} does not look like the face its landmarks describe: after the warp the surface is still {100 * off:.0f} % "
            f"of the face's radius away (at most {100 * NOT_A_FACE:.0f} % for a face), and {100 * lost:.0f} % of the face finds "
            f"nothing that looks its way (at most {100 * UNCOVERED:.0f} %). Check that the landmarks are those of this mesh."
        )


def _check_on_surface(rig: Rig, names: Sequence[str], marks: SurfacePoints) -> None:
    mesh = rig.neutral
    absent = marks.corners.max(axis=1) >= len(mesh.vertices)
    if absent.any():
        row = int(np.argmax(absent))
        raise InputError(
            f"the landmark {names[row]!r} of {rig.name} is at vertex {marks.corners[row].max()}, but the mesh has "
            f"{len(mesh.vertices)} vertices; it belongs to another mesh."
        )
    points = marks.of(mesh.vertices)
    away, elsewhere = np.zeros(len(marks)), ~_at_vertices(marks, mesh)
    if elsewhere.any():  # a tree of a large mesh takes longer to build than everything else here
        away[elsewhere] = closest_points(mesh.vertices, mesh.triangles, points[elsewhere])[1] / face_radius(points)
    if away.max() > OFF_SURFACE:
        row = int(np.argmax(away))
        raise InputError(
            f"the landmark {names[row]!r} of {rig.name} is off the surface by {100 * away[row]:.0f} % of the face's radius; "
            "place it on the skin."
        )


def _at_vertices(marks: SurfacePoints, mesh: Mesh) -> Flags:
    """Tell which landmarks `(L,)` are vertices of some triangle, and so on the surface."""
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[mesh.triangles] = True
    heaviest = marks.corners[np.arange(len(marks)), marks.weights.argmax(axis=1)]
    return np.asarray((marks.weights.max(axis=1) == 1) & used[heaviest])


def _check_apart(rig: str, names: Sequence[str], points: Floats) -> None:
    apart = cdist(points, points) + np.eye(len(points)) * np.ptp(points)
    i, j = divmod(int(np.argmin(apart)), len(points))
    if apart[i, j] < 1e-6 * float(np.ptp(points, axis=0).max()):
        raise InputError(
            f"the landmarks {names[i]!r} and {names[j]!r} of {rig} are at the same place; correct one of them."
        )


def _check_spread(rig: str, points: Floats) -> None:
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extent[2] < FLAT * extent[0]:
        raise InputError(
            f"the {len(points)} landmarks of {rig} that both faces have lie in one plane; add one off it, such as the tip of the nose."
        )


def _check_sides(names: Sequence[tuple[str, str]], here: Floats, there: Floats, target: str) -> None:
    fitted = similarity(here, there)
    if fitted.mirrored_residual < MIRRORED * fitted.residual:
        raise InputError(
            f"the landmarks of {target} are a mirror image: left and right are swapped. Left is the subject's left; swap the names."
        )
    place = {a: i for i, (a, _) in enumerate(names)}
    swapped = []
    for left, right in _sides(place):
        i, j = place[left], place[right]
        if ((here[i] - here[j]) @ fitted.rotation.T) @ (there[i] - there[j]) < 0:
            swapped.append(f"{names[i][1]} and {names[j][1]}")
    if swapped:
        raise InputError(f"left and right are swapped on {target}: {'; '.join(swapped)}. Left is the subject's left.")


def _sides(names: Mapping[str, int]) -> list[tuple[str, str]]:
    """Return the pairs of left and right among names of either vocabulary."""
    pairs = [(name, name[:-4] + "right") for name in names if name.endswith("left")]
    pairs += [(left.other, right) for left, right in PAIRED.values() if left.other is not None and right is not None]
    return [(a, b) for a, b in dict.fromkeys(pairs) if a in names and b in names]


def _joined(points: Sequence[SurfacePoints]) -> SurfacePoints:
    return SurfacePoints(np.vstack([p.corners for p in points]), np.vstack([p.weights for p in points]))


def _some(names: Mapping[str, SurfacePoints]) -> str:
    return ", ".join(list(names)[:8]) + (" …" if len(names) > 8 else "") or "none"
