"""The character's shapes moved onto the actor's own mesh: what one has who scanned the actor's face at rest.

Deformation transfer (Sumner & Popović 2004) is no method for markers: it needs the actor's whole surface, which a
capture lacks.  So it stands beside the methods as a reference, like the actor's true shapes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from mien.core import InputError, Mesh, Rig, SurfacePoints
from mien.core.arrays import Floats
from mien.evaluate.cases import Case
from mien.rigging.blendshapes import carried
from mien.rigging.dense import DenseFit, lay
from mien.rigging.landmarks import paired_landmarks

METHOD = "deformation-transfer"


@dataclass(frozen=True)
class _Face:
    """A face at rest with its landmarks: the same one whatever shapes it has."""

    neutral: Mesh
    landmarks: tuple[tuple[str, SurfacePoints], ...]
    rig: Rig = field(compare=False)

    @classmethod
    def of(cls, rig: Rig) -> _Face:
        return cls(rig.neutral, tuple(rig.landmarks.items()), rig)


def transferred_shapes(case: Case) -> Floats:
    """Return the character's shapes at the actor's points by deformation transfer, `(K, M, 3)` [cm of a human face].

    Raises:
        InputError: the pairs have no points on the actor, or the faces share too few landmarks.
    """
    if case.pairs.source is None:
        raise InputError("deformation transfer needs pairs with points on the actor's mesh.")
    shapes, _ = carried(case.character, _laid(_Face.of(case.character), _Face.of(case.actor)), METHOD)
    return np.asarray(case.pairs.source.of(shapes.deltas) / case.prepared.terms.centimetre)


@lru_cache(maxsize=4)
def _laid(character: _Face, actor: _Face) -> DenseFit:
    """Lay a character's face on an actor's; the same for every take and condition."""
    pairs = paired_landmarks(character.rig, actor.rig)
    return lay(character.neutral, pairs.source, actor.neutral, pairs.target)
