"""The one place where the size of a face is measured.

The published constants are for a human face in centimetres.  Files come in any
unit and characters in any size, so solvers divide lengths by `human_centimetre`
and their results depend on neither.
"""

from __future__ import annotations

import numpy as np

from mien.core.arrays import Floats
from mien.core.errors import InputError

HUMAN_FACE_RADIUS_CM = 6.0
"""Root-mean-square distance of facial landmarks from their centre on an adult."""


def face_radius(points: Floats) -> float:
    """Return the root-mean-square distance of points `(M, 3)` from their centre.

    Raises:
        InputError: the points coincide.
    """
    spread = points - points.mean(axis=0)
    radius = float(np.sqrt((spread**2).sum(axis=1).mean()))
    if not radius > 0:
        raise InputError("the corresponding points all coincide; spread them over the face.")
    return radius


def human_centimetre(points: Floats) -> float:
    """Return the length that is one centimetre if this face were human-sized.

    Args:
        points: `(M, 3)` points spread over a neutral face, in any unit.

    Returns:
        The length in the unit of `points`; divide by it to get centimetres.
    """
    return face_radius(points) / HUMAN_FACE_RADIUS_CM
