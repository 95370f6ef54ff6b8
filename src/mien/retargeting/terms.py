"""Actor and character in the same terms: the actor's frame, in human centimetres.

The published constants are for centimetres on a human face.  Here the character is
scaled and turned onto the actor by the correspondences, and all lengths are divided by
what a centimetre would be on this actor; nothing after this module knows about files,
units or axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core import Correspondence, InputError, Note, Rig
from mien.core.arrays import Floats
from mien.core.units import human_centimetre
from mien.geometry.align import Similarity, similarity

MIRRORED = 0.8
"""A mirror image that fits better by this factor means swapped sides or a left-handed file."""
UNLIKE = 0.5
"""A residual above this share of the face's radius means the pairs do not describe one face."""


@dataclass(frozen=True, eq=False)
class Terms:
    """The character as the actor would see it.

    Attributes:
        actor_neutral: `(M, 3)` actor's points at rest [cm of a human face].
        character_neutral: `(M, 3)` the character's points at rest, on the actor.
        deltas: `(K, M, 3)` its blendshapes at those points (Ribera et al.'s `Δs`).
        centimetre: length of a human centimetre in the actor's own unit.
        placement: from the actor's space to the character's.
        notes: what was settled on the way.
    """

    actor_neutral: Floats
    character_neutral: Floats
    deltas: Floats
    centimetre: float
    placement: Similarity
    notes: tuple[Note, ...]

    @property
    def character_centimetre(self) -> float:
        """Length of a human centimetre in the character's own unit."""
        return self.centimetre * self.placement.scale


def common_terms(actor_neutral: Floats, rig: Rig, correspondence: Correspondence) -> Terms:
    """Bring actor and character into the same terms.

    Args:
        actor_neutral: `(M, 3)` the paired points of the actor at rest, in any unit and axes.
        rig: the character.
        correspondence: the `M` pairs.

    Raises:
        InputError: fewer than 4 pairs, coinciding or coplanar ones, sides swapped, or
            points that do not lie on one face.
    """
    target = correspondence.target.of(rig.neutral.vertices)
    _check_distinct(actor_neutral, correspondence.names, "on the actor")
    _check_distinct(target, correspondence.names, f"on {rig.name}")
    placement = similarity(actor_neutral, target)
    _check_placement(placement, rig.name)
    centimetre = human_centimetre(actor_neutral)
    deltas = correspondence.target.of(rig.blendshapes.deltas)
    ratio = placement.scale
    notes = []
    if not 0.2 < ratio < 5:
        text = f"one unit of the actor's file is {ratio:.4g} units of the character's; the difference was settled from the pairs."
        notes.append(Note("units-settled", text, rig.name))
    return Terms(
        actor_neutral / centimetre,
        placement.invert(target) / centimetre,
        placement.invert_vectors(deltas) / centimetre,
        centimetre,
        placement,
        tuple(notes),
    )


def _check_distinct(points: Floats, names: tuple[str, ...], where: str) -> None:
    _, first, count = np.unique(points, axis=0, return_index=True, return_counts=True)
    if (count > 1).any():
        twin = first[np.argmax(count > 1)]
        same = [names[i] for i in np.flatnonzero((points == points[twin]).all(axis=1))]
        raise InputError(f"the pairs {', '.join(map(repr, same[:4]))} are the same point {where}; remove all but one.")


def _check_placement(placement: Similarity, name: str) -> None:
    if placement.mirrored_residual < MIRRORED * placement.residual and placement.residual > 0.15:
        raise InputError(
            f"the actor fits {name} better as a mirror image (residual {placement.mirrored_residual:.2f} of the face's radius "
            f"against {placement.residual:.2f}): left and right are swapped in the pairs, or one file is left-handed. "
            "Left is the subject's own left; exchange the sides in the pairs or landmarks."
        )
    if placement.residual > UNLIKE:
        raise InputError(
            f"the pairs do not place the actor on {name}: after the best scale and turn, points are off by "
            f"{placement.residual:.2f} of the face's radius (up to {UNLIKE} is accepted). Check that each pair names the same "
            "spot on both faces, and that vertex numbers belong to this file."
        )
    if not 1e-4 < placement.scale < 1e4:
        raise InputError(
            f"the actor would have to be scaled by {placement.scale:.3g} to fit {name}; the pairs or the units of a file are wrong."
        )
