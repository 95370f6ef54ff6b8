"""Head motion as curves beside those of the layers: six channels that belong to no face.

A rigid motion `x ↦ R x + t` means something else on a face of another size and in another place.
As a turn about the face's centre and a shift of that centre in human centimetres it goes to any
character, and can be edited.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mien.core import Clip
from mien.core.arrays import Floats
from mien.core.units import human_centimetre
from mien.retargeting.layers.model import LayeredFace

HEAD = ("head.rx", "head.ry", "head.rz", "head.tx", "head.ty", "head.tz")
"""A rotation vector [degrees] and the shift of the face's centre [cm of a human face]."""


def with_head_curves(face: LayeredFace, curves: Clip, head: Floats | None) -> Clip:
    """Return curves with the head motion `(F, 4, 4)` of a face as six more channels, if there is any."""
    if head is None:
        return Clip(curves.names, curves.values, curves.fps, start=curves.start, notes=curves.notes)
    centre = face.rest.mean(axis=0)
    turned = np.degrees(Rotation.from_matrix(head[:, :3, :3]).as_rotvec())
    shift = (head[:, :3, :3] @ centre + head[:, :3, 3] - centre) / human_centimetre(face.rest)
    values = np.concatenate([curves.values, turned, shift], axis=1)
    return Clip((*curves.names, *HEAD), values, curves.fps, start=curves.start, notes=curves.notes)


def head_of_curves(face: LayeredFace, curves: Clip) -> Floats | None:
    """Return the head motion `(F, 4, 4)` that curves give a face; None if they have none.

    Channels that are missing are 0; a frame with a blank keeps the one before.
    """
    if not set(HEAD) & set(curves.names):
        return None
    values = curves.channels(HEAD)
    whole = ~np.isnan(values).any(axis=1)
    last = np.maximum.accumulate(np.where(whole, np.arange(len(values)), -1))
    values = np.where((last >= 0)[:, None], values[last], 0.0)
    centre = face.rest.mean(axis=0)
    head = np.tile(np.eye(4), (len(values), 1, 1))
    head[:, :3, :3] = Rotation.from_rotvec(np.radians(values[:, :3])).as_matrix()
    head[:, :3, 3] = centre + values[:, 3:] * human_centimetre(face.rest) - head[:, :3, :3] @ centre
    return head
