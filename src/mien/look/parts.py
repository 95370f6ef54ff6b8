"""Which part of a face each vertex is, and what colour that part has.

A rig's own colours come first.  Rigs often arrive as one mesh called "head" in one
colour, though, and a performance can still only be judged if eyes look like eyes.  So
where the rig says nothing, or only its commonest colour, names are asked (unless other
colours tell such a part already), and loose pieces without a telling name are judged by
their shape: balls are eyes, thin open sheets in front of them (tear film, lashes, shadow
planes made for a renderer with transparency) are left out, the rest inside the head is
tongue or teeth.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from mien.core import Mesh, Rig
from mien.core.arrays import Flags, Floats, Ints
from mien.look.openings import Openings
from mien.look.shade import SKIN, encoded

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
    "nostril": np.array([0.45, 0.27, 0.24]),
    "horn": np.array([0.44, 0.39, 0.32]),
    "beak": np.array([0.88, 0.68, 0.32]),
    "shell": np.array([0.50, 0.43, 0.29]),
}
"""sRGB of each part."""

WORDS: Mapping[str, tuple[str, ...]] = {
    "hidden": ("cornea", "occlusion", "tear", "tearline", "lacrimal", "lash", "lashes", "eyelash", "eyelashes", "wet"),
    "pupil": ("pupil", "pupils"),
    "iris": ("iris", "irises"),
    "teeth": ("tooth", "teeth", "denture", "fang", "fangs", "tusk", "tusks"),
    "tongue": ("tongue", "gum", "gums"),
    "hair": ("hair", "brow", "brows", "eyebrow", "eyebrows", "beard", "moustache", "tuft", "tufts", "mane", "whiskers"),
    "eye": ("eye", "eyes", "eyeball", "eyeballs", "sclera"),
    "skin": ("lid", "lids", "eyelid", "eyelids", "socket", "ear", "ears"),
    "horn": ("horn", "horns", "antler", "antlers", "claw", "claws", "hoof", "hooves", "nail", "nails"),
    "beak": ("beak", "bill"),
    "shell": ("shell", "carapace"),
    "nostril": ("nostril", "nostrils"),
    "lips": ("lip", "lips"),
    "mouth": ("mouth", "pocket", "inside"),
}
"""Words in group names, asked in this order."""


EYE = {"eye", "iris", "pupil"}


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh made ready to be pictured.

    Attributes:
        triangles: `(T, 3)` those worth drawing.
        colours: `(N, 3)` sRGB of each vertex.
        gaze: `(N, 3)` direction from its eye's centre at rest, on eyeballs without an iris; elsewhere zero.
        same: `(N,)` the first of the vertices that lie and move together: seams share their normals.
        openings: where the surface lets one look inside.
        teeth: `(N,)` which vertices are teeth, whatever their colour.
    """

    triangles: Ints
    colours: Floats
    gaze: Floats
    same: Ints
    openings: Openings
    teeth: Flags


def surface_of(rig: Rig) -> Surface:
    """Return a rig's surface with each part in its colour."""
    mesh = rig.neutral
    same = _moving_together(rig)
    piece = _pieces(mesh, same)
    part = _told_by_shape(mesh, piece, _told_by_name(mesh))
    teeth = np.asarray(part == "teeth")
    own, said = _own_colours(rig)
    kept = said & ~_left_to_tell(part, own, said)
    colours = np.where(kept[:, None], own, np.array([COLOURS.get(name, SKIN) for name in part]))
    part[kept] = ""
    drawn = mesh.triangles[~(part == "hidden")[mesh.triangles].any(axis=1)]
    return Surface(drawn, colours, _gaze(mesh, piece, part), same, Openings.of(drawn, same), teeth)


def _own_colours(rig: Rig) -> tuple[Floats, Flags]:
    """Return the sRGB per vertex `(N, 3)` that the rig itself gives, and where it gives one."""
    colours = np.zeros((len(rig.neutral.vertices), 3))
    said = np.zeros(len(colours), dtype=bool)
    for group, colour in rig.colours.items():
        colours[rig.neutral.groups[group]] = encoded(np.array(colour))
        said[rig.neutral.groups[group]] = True
    return colours, said


def _left_to_tell(part: NDArray[np.str_], colours: Floats, said: Flags) -> Flags:
    """Return which vertices of the rig's commonest colour are parts that none of its other colours tells."""
    if not said.any():
        return said
    distinct, count = np.unique(colours[said], axis=0, return_counts=True)
    ground = said & (colours == distinct[count.argmax()]).all(axis=1)
    told = {"", "skin", *part[said & ~ground].tolist()}
    if told & EYE:
        told |= EYE
    return np.asarray(ground & ~np.isin(part, list(told)))


def _told_by_name(mesh: Mesh) -> NDArray[np.str_]:
    """Return the part per vertex that its group's name speaks of, or an empty string."""
    part = np.full(len(mesh.vertices), "", dtype="<U8")
    for group in sorted(mesh.groups, key=lambda name: -len(mesh.groups[name])):  # the smaller is the more specific
        if word := part_named(group):
            part[mesh.groups[group]] = word
    return part


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


def _told_by_shape(mesh: Mesh, piece: Ints, part: NDArray[np.str_]) -> NDArray[np.str_]:
    """Return the parts with loose pieces that no name tells judged by shape; who names one eye names them all."""
    part = part.copy()
    counts = np.bincount(piece)
    loose = [np.flatnonzero(piece == p) for p in np.flatnonzero(counts >= 12) if p != counts.argmax()]
    untold = [ids for ids in loose if (part[ids] == "").all()]
    eyes = [ids for ids in loose if np.isin(part[ids], list(EYE)).any()]
    if not eyes:
        eyes = [ids for ids in untold if _is_ball(mesh.vertices[ids])]
        for ids in eyes:
            part[ids] = "eye"
    if not eyes:
        return part
    centres = np.array([mesh.vertices[ids].mean(axis=0) for ids in eyes])
    radius = max(float(np.ptp(mesh.vertices[ids], axis=0).max()) / 2 for ids in eyes)
    for ids in untold:
        if part[ids[0]] != "":
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
