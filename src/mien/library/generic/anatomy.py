"""The anatomy of a head of the kit: muscles, deformers, and what the skin has to bear."""

from __future__ import annotations

import numpy as np

from mien.core.anatomy import Anatomy, Muscle
from mien.core.arrays import Floats
from mien.library.expressions import BASES, SCRIPTS, templates
from mien.library.generic.deformers import clusters, flexors
from mien.library.generic.measures import Measures
from mien.library.generic.muscles import muscles
from mien.library.generic.places import Field
from mien.library.modelling.half import Head


def generic_anatomy(measures: Measures, head: Head) -> Anatomy:
    """Lay muscles, clusters and flexors under the skin of a head and give it every expression template.

    Args:
        measures: of the head [cm].
        head: the head built from them [cm].

    Returns:
        The anatomy [m], for a rig whose bones are `head`, `jaw`, `eye_left` and `eye_right`.
    """
    field = Field.of(measures, head)
    laid = muscles(field)
    return Anatomy(
        laid,
        clusters(field),
        flexors(field),
        fields={"muscle_stress": muscle_stress(laid)},
        templates=templates(tongue="tongue" in head.groups),
        bases=BASES,
        scripts=SCRIPTS,
    )


def muscle_stress(laid: tuple[Muscle, ...]) -> Floats:
    """Return `(N,)` how much each vertex is strained when every muscle contracts: shortening times weight, summed."""
    return np.asarray(sum(muscle.shortening * muscle.weights for muscle in laid))
