"""Eyes, teeth and tongue for a face that has none: brought along from the generic rig.

A part is moved, turned and scaled as a whole, as the skin around it is; it is never bent.
Eyeballs are fitted under the lids, and what belongs into the mouth is kept inside the head.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

import numpy as np

from mien.core import Blendshapes, Mesh, Note, Rig
from mien.core.arrays import Floats, Ints
from mien.core.rig import Colour
from mien.rigging.dense import DenseFit
from mien.rigging.eyeballs import ball_of, fitted_ball
from mien.rigging.parts import Attachment, pieces
from mien.rigging.structure import Structure
from mien.rigging.tucking import tucked_in

TEETH = {"teeth", "tooth", "denture", "gum", "gums"}
WORDS = TEETH | {"eye", "eyes", "eyeball", "tongue"}
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

    def shapes(self, shapes: Blendshapes, deltas: Floats) -> Blendshapes:
        """Add to the face's shapes how the brought parts move in them, from the source's deltas `(K, Ns, 3)`."""
        moved = np.einsum("bij,kbj->kbi", self.turn, deltas[:, self.vertices])
        return Blendshapes(shapes.names, np.concatenate([shapes.deltas, moved], axis=1))


def bring(generic: Rig, fit: DenseFit, structure: Structure, attached: tuple[Attachment, ...]) -> Brought:
    """Place the generic rig's eyes, teeth and tongue on a face that has no counterpart of them."""
    lacking = _lacking(generic, fit, attached)
    if not lacking:
        return Brought.nothing()
    moved = [_moved(generic.neutral.vertices[ids], fit, structure) for ids in lacking]
    soft = [row for row, (_, _, ball) in enumerate(moved) if not ball]
    tucked, scale = tucked_in([moved[row][1] for row in soft], fit)
    turns, places = [turn for turn, _, _ in moved], [place for _, place, _ in moved]
    for row, place in zip(soft, tucked, strict=True):
        turns[row], places[row] = scale * turns[row], place
    spread = [np.broadcast_to(turn, (len(ids), 3, 3)) for turn, ids in zip(turns, lacking, strict=True)]
    note = Note("parts-brought", f"{len(lacking)} parts that the face lacks (eyes, teeth, tongue) were added.")
    return Brought(np.concatenate(lacking), np.concatenate(spread), np.concatenate(places), (note,))


def _lacking(generic: Rig, fit: DenseFit, attached: tuple[Attachment, ...]) -> list[Ints]:
    """Return the vertices of each part that a face cannot act without and has none of.

    A face with a tongue of its own, but no teeth, was made without teeth.
    """
    followed = np.concatenate([np.empty(0, np.int64), *(part.followed for part in attached)])
    groups = generic.neutral.groups
    words = WORDS - TEETH if np.isin(_named(groups, {"tongue"}), followed).any() else WORDS
    wanted = _named(groups, words)
    return [
        ids
        for ids in pieces(generic.neutral.triangles, ~fit.source_skin)
        if not np.isin(ids, followed).any() and np.isin(ids, wanted).all()
    ]


def _moved(points: Floats, fit: DenseFit, structure: Structure) -> tuple[Floats, Floats, bool]:
    """Move a part as the skin around it is: how it is turned and scaled, where it is, and whether it is a ball."""
    ball = ball_of(points)
    if ball is not None:
        turn, _ = structure.around(ball.centre)
        there = fitted_ball(ball, fit, structure)
        whole = there.radius / ball.radius * turn
        return whole, (points - ball.centre) @ whole.T + there.centre, True
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    turn, scale = structure.around(centre)
    return scale * turn, (points - centre) @ (scale * turn).T + structure.warp(centre[None]), False


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


def _named(groups: Mapping[str, Ints], words: AbstractSet[str]) -> Ints:
    """Return the vertices of the groups in whose names one of some words stands."""
    named = [ids for name, ids in groups.items() if words & set(re.findall("[a-z]+", name.lower()))]
    return np.unique(np.concatenate([np.empty(0, np.int64), *named]))
