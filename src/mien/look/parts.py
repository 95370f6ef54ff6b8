"""Which part of a face each vertex is, told by names where they say it and by shape where they do not.

Rigs often arrive as one mesh called "head".  A performance can still only be judged
if eyes look like eyes, so loose pieces are told apart by their shape: balls are eyes,
thin open sheets in front of them (tear film, lashes, shadow planes made for a renderer
with transparency) are left out, the rest inside the head is tongue or teeth.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from mien.core import InputError, Mesh, Rig
from mien.core.arrays import Floats, Ints
from mien.core.errors import unknown
from mien.look.shade import SKIN, encoded, linear

COLOURS: Mapping[str, Floats] = {
    "skin": SKIN,
    "eye": np.array([0.93, 0.92, 0.90]),
    "iris": np.array([0.30, 0.38, 0.42]),
    "pupil": np.array([0.06, 0.06, 0.07]),
    "teeth": np.array([0.90, 0.87, 0.80]),
    "tongue": np.array([0.68, 0.38, 0.37]),
    "hair": np.array([0.32, 0.25, 0.21]),
    "lips": np.array([0.82, 0.57, 0.52]),
    "mouth": np.array([0.43, 0.20, 0.20]),
}

WORDS: Mapping[str, tuple[str, ...]] = {
    "hidden": ("cornea", "occlusion", "tear", "tearline", "lacrimal", "lash", "lashes", "eyelash", "eyelashes", "wet"),
    "pupil": ("pupil", "pupils"),
    "iris": ("iris", "irises"),
    "teeth": ("tooth", "teeth", "denture"),
    "tongue": ("tongue", "gum", "gums"),
    "hair": ("hair", "brow", "brows", "eyebrow", "eyebrows", "beard"),
    "eye": ("eye", "eyes", "eyeball", "eyeballs", "sclera"),
    "skin": ("lid", "lids", "eyelid", "eyelids", "socket"),
    "lips": ("lip", "lips"),
    "mouth": ("mouth", "pocket", "inside"),
}
"""Words in group names, asked in this order."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh made ready to be pictured.

    Attributes:
        triangles: `(T, 3)` those worth drawing.
        colours: `(N, 3)` sRGB of each vertex.
        gaze: `(N, 3)` direction from its eye's centre at rest, on eyeballs without an iris; elsewhere zero.
        same: `(N,)` the first of the vertices that lie and move together: seams share their normals.
    """

    triangles: Ints
    colours: Floats
    gaze: Floats
    same: Ints


def surface_of(rig: Rig, paint: Mapping[str, tuple[float, float, float]] | None = None) -> Surface:
    """Return a rig's surface with each part in its colour.

    Args:
        rig: whose surface.
        paint: linear red, green and blue of vertex groups, later ones over earlier, instead of what their names tell.

    Raises:
        InputError: the rig has no group of that name.
    """
    mesh = rig.neutral
    if paint is not None:
        colours = np.tile(SKIN, (len(mesh.vertices), 1))
        for group, colour in paint.items():
            if group not in mesh.groups:
                raise InputError(unknown("vertex group", group, mesh.groups))
            colours[mesh.groups[group]] = encoded(np.array(colour))
        return Surface(mesh.triangles, colours, np.zeros(mesh.vertices.shape), _moving_together(rig))
    same = _moving_together(rig)
    piece = _pieces(mesh, same)
    part = _told_by_name(mesh)
    if (part == "").all():
        part = _told_by_shape(mesh, piece)
    colours = np.array([COLOURS.get(name, SKIN) for name in part]).reshape(-1, 3)
    drawn = ~(part == "hidden")[mesh.triangles].any(axis=1)
    return Surface(mesh.triangles[drawn], colours, _gaze(mesh, piece, part), same)


def _told_by_name(mesh: Mesh) -> NDArray[np.str_]:
    """Return the part per vertex that its group's name speaks of, or an empty string."""
    part = np.full(len(mesh.vertices), "", dtype="<U8")
    for group in _large_first(mesh.groups):
        if word := part_named(group):
            part[mesh.groups[group]] = word
    return part


def named_parts(mesh: Mesh) -> dict[str, Ints]:
    """Return the vertices of each part that groups' names speak of, to be painted over one another in this order."""
    found: dict[str, list[Ints]] = {}
    for group, vertices in mesh.groups.items():
        if word := part_named(group):
            found.setdefault(word, []).append(vertices)
    joined = {word: np.unique(np.concatenate(pieces)) for word, pieces in found.items()}
    return {word: joined[word] for word in _large_first(joined)}


def part_colour(part: str) -> tuple[float, float, float]:
    """Return a part's linear red, green and blue."""
    red, green, blue = linear(COLOURS.get(part, SKIN)).tolist()
    return red, green, blue


def _large_first(groups: Mapping[str, Ints]) -> list[str]:
    """Return names so that where groups overlap, the smaller and so more specific one comes later."""
    return sorted(groups, key=lambda name: -len(groups[name]))


def part_named(group: str) -> str:
    """Return the part a group's name speaks of, or an empty string."""
    words = re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", group).lower())
    return next((part for part, known in WORDS.items() if any(word in known for word in words)), "")


def _moving_together(rig: Rig) -> Ints:
    """Return for each vertex the first one at the same place with the same movement."""
    mix = np.cos(np.arange(1, len(rig.blendshapes) + 1))
    movement = np.einsum("k,kna->na", mix, rig.blendshapes.deltas)
    span = np.ptp(rig.neutral.vertices, axis=0).max() or 1.0
    keys = np.round(np.concatenate([rig.neutral.vertices, movement], axis=1) / (1e-6 * span)).astype(np.int64)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[inverse.ravel()])


def _pieces(mesh: Mesh, same: Ints) -> Ints:
    """Return the number of each vertex's connected piece, sewn up along seams.

    Only open borders are sewn to open borders: a tear film that starts on the rim of a
    lid shares its places with the skin and is still another piece.
    """
    edges = np.sort(
        np.concatenate([mesh.triangles[:, [0, 1]], mesh.triangles[:, [1, 2]], mesh.triangles[:, [2, 0]]]), axis=1
    )
    once, uses = np.unique(edges, axis=0, return_counts=True)
    border = once[uses == 1]
    border = np.take_along_axis(border, np.argsort(same[border], axis=1), axis=1)
    _, first, place = np.unique(same[border], axis=0, return_index=True, return_inverse=True)
    twin = border[first[place.ravel()]]
    rows = np.concatenate([once[:, 0], border.ravel()])
    columns = np.concatenate([once[:, 1], twin.ravel()])
    links = coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), (len(same), len(same)))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _told_by_shape(mesh: Mesh, piece: Ints) -> NDArray[np.str_]:
    part = np.full(len(piece), "skin", dtype="<U8")
    counts = np.bincount(piece)
    loose = [np.flatnonzero(piece == p) for p in np.flatnonzero(counts >= 12) if p != counts.argmax()]
    balls = [ids for ids in loose if _is_ball(mesh.vertices[ids])]
    if not balls:
        return part
    for ids in balls:
        part[ids] = "eye"
    centres = np.array([mesh.vertices[ids].mean(axis=0) for ids in balls])
    radius = max(float(np.ptp(mesh.vertices[ids], axis=0).max()) / 2 for ids in balls)
    for ids in loose:
        if part[ids[0]] != "skin":
            continue
        middle = mesh.vertices[ids].mean(axis=0)
        wide, tall, deep = np.ptp(mesh.vertices[ids], axis=0)
        if np.linalg.norm(centres - middle, axis=1).min() < 1.5 * radius:
            part[ids] = "hidden"
        elif middle[1] < centres[:, 1].min() - radius:
            part[ids] = "tongue" if deep > max(wide, tall) else "teeth"
    return part


def _is_ball(points: Floats) -> bool:
    box = np.ptp(points, axis=0)
    if len(points) < 30 or box.max() > 1.25 * box.min():
        return False
    distance = np.linalg.norm(points - (points.min(axis=0) + box / 2), axis=1)
    return bool(distance.min() > 0.75 * distance.max())


def _gaze(mesh: Mesh, piece: Ints, part: NDArray[np.str_]) -> Floats:
    gaze = np.zeros(mesh.vertices.shape)
    if np.isin(part, ["iris", "pupil"]).any():
        return gaze
    for p in np.unique(piece[part == "eye"]):
        ids = (piece == p) & (part == "eye")
        points = mesh.vertices[ids]
        gaze[ids] = points - (points.min(axis=0) + points.max(axis=0)) / 2
    return gaze
