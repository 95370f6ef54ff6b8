"""Bones on another face: frames carried with the skin, and eyes turned about their own centres."""

from __future__ import annotations

import numpy as np

from mien.core import Rig
from mien.core.arrays import Floats, Ints
from mien.rigging.brought import Brought
from mien.rigging.dense import DenseFit
from mien.rigging.eyeballs import ball_of
from mien.rigging.parts import Attachment, centre_of
from mien.rigging.structure import Structure

AT_CENTRE = 0.2
"""A joint belongs to the centre of a part if it lies this close to it, as a share of the part's size."""


def carried_joints(
    generic: Rig, fit: DenseFit, structure: Structure, attached: tuple[Attachment, ...], brought: Brought
) -> Floats:
    """Return the rest matrices `(J, 4, 4)` of the joints on the face.

    A joint in the middle of an eyeball goes to the middle of the face's eyeball, however much else follows it.
    """
    assert generic.skeleton is not None
    rest = np.stack([structure.frame(frame) for frame in generic.skeleton.rest])
    for joint, frame in enumerate(generic.skeleton.rest):
        for own, points in _balls(generic, fit, attached, brought, joint):
            size, offset = float(np.ptp(own, axis=0).max()), frame[:3, 3] - centre_of(own)
            if np.linalg.norm(offset) < AT_CENTRE * size:
                turn = rest[joint, :3, :3] @ frame[:3, :3].T
                rest[joint, :3, 3] = centre_of(points) + float(np.ptp(points, axis=0).max()) / size * turn @ offset
    return rest


def _balls(
    generic: Rig, fit: DenseFit, attached: tuple[Attachment, ...], brought: Brought, joint: int
) -> list[tuple[Floats, Floats]]:
    """Return the parts that follow a joint fully, balls alone if any is: their points on the source and on the face."""
    assert generic.skin is not None
    held = (generic.skin.weights * (generic.skin.joints == joint)).sum(axis=1) > 0.99
    source = generic.neutral.vertices
    found = [
        (source[part.followed], fit.target.vertices[part.vertices])
        for part in attached
        if part.counterpart and held[part.followed].all()
    ]
    mine: Ints = np.flatnonzero(held[brought.vertices])
    if len(mine):
        found.append((source[brought.vertices[mine]], brought.places[mine]))
    return [pair for pair in found if ball_of(pair[1]) is not None] or found
