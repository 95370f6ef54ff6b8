"""Eyes, teeth and tongue for a face that has none: brought along from the generic rig.

A part is moved, turned and scaled as a whole, as the skin around it is; it is never bent.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from mien.core import Blendshapes, Mesh, Note, Rig
from mien.core.arrays import Floats, Ints
from mien.core.rig import Colour
from mien.rigging.attributes import interpolation
from mien.rigging.dense import DenseFit
from mien.rigging.parts import Attachment, pieces
from mien.rigging.structure import Structure

WORDS = {"eye", "eyes", "eyeball", "teeth", "tooth", "denture", "tongue", "gum", "gums"}
"""Parts that a face cannot act without, by the words of their groups' names."""


@dataclass(frozen=True, eq=False)
class Brought:
    """Parts of the generic rig on a face that lacks them.

    Attributes:
        vertices: `(B,)` vertices of the generic rig, in the order in which they are added.
        turn: `(B, 3, 3)` by what each was turned and scaled.
        places: `(B, 3)` where they are on the face.
        notes: what was brought.
    """

    vertices: Ints
    turn: Floats
    places: Floats
    notes: tuple[Note, ...] = ()

    @classmethod
    def nothing(cls) -> Brought:
        """Return the record of bringing nothing."""
        return cls(np.empty(0, np.int64), np.empty((0, 3, 3)), np.empty((0, 3)))

    def means(self, fit: DenseFit, attached: tuple[Attachment, ...]) -> sparse.csr_matrix:
        """Return the matrix of means from the source's vertices to the face's, then to those brought."""
        own = sparse.csr_matrix(
            (np.ones(len(self.vertices)), (np.arange(len(self.vertices)), self.vertices)),
            shape=(len(self.vertices), len(fit.source.vertices)),
        )
        return sparse.vstack([interpolation(fit, attached), own]).tocsr()

    def shapes(self, shapes: Blendshapes, deltas: Floats) -> Blendshapes:
        """Add to the face's shapes how the brought parts move in them, from the source's deltas `(K, Ns, 3)`."""
        moved = np.einsum("bij,kbj->kbi", self.turn, deltas[:, self.vertices])
        return Blendshapes(shapes.names, np.concatenate([shapes.deltas, moved], axis=1))


def bring(generic: Rig, fit: DenseFit, structure: Structure, attached: tuple[Attachment, ...]) -> Brought:
    """Place the generic rig's eyes, teeth and tongue on a face that has no counterpart of them."""
    followed = np.concatenate([np.empty(0, np.int64), *(part.followed for part in attached)])
    wanted = _needed(generic.neutral.groups)
    lacking = [
        ids
        for ids in pieces(generic.neutral.triangles, ~fit.source_skin)
        if not np.isin(ids, followed).any() and np.isin(ids, wanted).all()
    ]
    if not lacking:
        return Brought.nothing()
    turns, places = [], []
    for ids in lacking:
        points = generic.neutral.vertices[ids]
        centre = (points.min(axis=0) + points.max(axis=0)) / 2
        turn, scale = structure.around(centre)
        turns.append(np.broadcast_to(scale * turn, (len(ids), 3, 3)))
        places.append((points - centre) @ (scale * turn).T + structure.warp(centre[None]))
    note = Note("parts-brought", f"{len(lacking)} parts that the face lacks (eyes, teeth, tongue) were added.")
    return Brought(np.concatenate(lacking), np.concatenate(turns), np.concatenate(places), (note,))


def face_with(face: Mesh, generic: Mesh, brought: Brought) -> Mesh:
    """Return the face with the brought parts behind its own vertices and triangles."""
    if not len(brought.vertices):
        return face
    number = np.full(len(generic.vertices), -1)
    number[brought.vertices] = len(face.vertices) + np.arange(len(brought.vertices))
    added = number[generic.triangles]
    added = added[(added >= 0).all(axis=1)]
    groups = {name: np.asarray(ids) for name, ids in face.groups.items()}
    for name, ids in generic.groups.items():
        mine = number[ids][number[ids] >= 0]
        if len(mine):
            groups[name] = np.concatenate([groups.get(name, np.empty(0, np.int64)), mine])
    return replace(
        face,
        vertices=np.concatenate([face.vertices, brought.places]),
        triangles=np.concatenate([face.triangles, added]),
        uv=None if face.uv is None else np.concatenate([face.uv, np.zeros((len(added), 3, 2))]),
        faces=None if face.faces is None else (*face.faces, *(tuple(t) for t in added.tolist())),
        groups=groups,
    )


def colours_with(face: Rig, generic: Rig, brought: Brought) -> dict[str, Colour]:
    """Return the face's colours, and over them those of the brought parts."""
    shown = {
        name: colour
        for name, colour in generic.colours.items()
        if np.isin(generic.neutral.groups[name], brought.vertices).any()
    }
    return {**face.colours, **shown}


def _needed(groups: Mapping[str, Ints]) -> Ints:
    """Return the vertices of the groups whose names say eye, teeth or tongue."""
    named = [ids for name, ids in groups.items() if WORDS & set(re.findall("[a-z]+", name.lower()))]
    return np.unique(np.concatenate([np.empty(0, np.int64), *named]))
