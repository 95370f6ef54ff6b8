"""A head modelled by code: skin, lids, lips, eyeballs, teeth and brows from one table of measures.

The skin is where rays first meet the blended solids.  Closed rings of vertices run
around each eye and the mouth, so that lids and lips slide along their own edges, and
around ears and nostrils where they are modelled; a graded grid covers the rest.
"""

from __future__ import annotations

import numpy as np

from mien.library.generic.features import brow, eye_rings, eyeball, teeth, tongue
from mien.library.generic.measures import Measures
from mien.library.generic.mouth import mouth_rings
from mien.library.generic.openings import ear_rings, nostril_rings
from mien.library.generic.shell import shell
from mien.library.modelling.half import Half, Head, mirrored


def build(measures: Measures) -> Head:
    """Model the head that these measures describe."""
    half = Half()
    borders = [eye_rings(half, measures), mouth_rings(half, measures)]
    if measures.ear is not None:
        borders.append(ear_rings(half, measures, measures.ear))
    if measures.nostril is not None:
        borders.append(nostril_rings(half, measures, measures.nostril))
    shell(half, measures, borders)
    eyeball(half, measures.eye)
    brow(half, measures)
    teeth(half, measures)
    if measures.tongue is not None:
        tongue(half, *np.array(measures.tongue))
    return mirrored(half)
