"""A rigged face's expressions as blendshapes, and its scripts as their weights.

The templates are played on the face and what they add to it is kept.  Where lids and
lips meet on the generic rig they are made to meet on the face too.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mien.core import Blendshapes, Clip, Note, Rig
from mien.core.arrays import matching
from mien.geometry.templates import template_shapes
from mien.rigging.blendshapes import closed
from mien.rigging.transfer import Transfer


def baked(transfer: Transfer, generic: Rig, names: Iterable[str] | None = None) -> tuple[Blendshapes, tuple[Note, ...]]:
    """Make blendshapes of a rigged face's templates.

    Args:
        transfer: the rigged face.
        generic: the rig it came from.
        names: which templates; all if None.

    Returns:
        The shapes, and notes on the gaps that were closed.
    """
    chosen = tuple(transfer.rig.anatomy.templates if names is None and transfer.rig.anatomy else names or ())
    shapes = template_shapes(transfer.rig, chosen)
    if not chosen:
        return shapes, ()
    own = len(transfer.fit.target.vertices)
    met, notes = closed(template_shapes(generic, chosen), shapes.deltas[:, :own], transfer.fit)
    return Blendshapes(chosen, np.concatenate([met, shapes.deltas[:, own:]], axis=1)), notes


def scripted(script: Clip, shapes: Blendshapes) -> Clip:
    """Return a script, whose channels are templates, as weights of the blendshapes made of them."""
    place = matching(script.names, shapes.names)
    values = np.where(place >= 0, script.values[:, place], 0.0)
    return Clip(shapes.names, values, script.fps)
