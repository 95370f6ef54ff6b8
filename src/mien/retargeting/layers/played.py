"""Which extremes of a character some curves play: seldom all, since actors differ in what they have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Clip, InputError, Labels, Note
from mien.retargeting.layers.model import RESTING, Layer, LayeredFace


def played_by(face: LayeredFace, clip: Clip) -> tuple[LayeredFace, tuple[Note, ...]]:
    """Return the face with the extremes that curves have channels for, and what was left out.

    An extreme that is the face at rest (`RESTING`) is known to every face.  Regions that the curves
    call by other names correspond in their order.

    Raises:
        InputError: the curves have no layer of the face with two extremes.
    """
    layers, notes = [], []
    for layer in face.layers:
        wanted = [name.removeprefix(f"{layer.name}.") for name in clip.names if name.startswith(f"{layer.name}.")]
        still = [name for name in wanted if name in RESTING and name not in layer.extremes]
        known = {name: layer.offsets[k] for k, name in enumerate(layer.extremes)}
        known |= {name: np.zeros(layer.offsets.shape[1:]) for name in still}
        own = [name for name in wanted if name in known]
        for alone, whose in (
            ([name for name in wanted if name not in known], "the curves"),
            ([name for name in layer.extremes if name not in wanted], face.name),
        ):
            if alone:
                text = f"{len(alone)} extremes of {layer.name!r} are not played, for only {whose} has them: "
                notes.append(Note("extremes-unshared", text + ", ".join(alone[:12]) + ".", layer.name))
        if len(own) > 1:
            layers.append(Layer(layer.name, tuple(own), np.stack([known[name] for name in own])))
    if not layers:
        raise InputError(
            f"the curves ({', '.join(clip.names[:6]) or 'none'} …) play no layer of {face.name}, whose extremes are "
            f"{', '.join(face.extremes[:6])} …; curves are channels named layer.extreme and weight.region.layer."
        )
    return replace(face, layers=tuple(layers), regions=_called(face.regions, clip)), tuple(notes)


def _called(regions: Labels, clip: Clip) -> Labels:
    """Return regions by the names that curves have for them, where there are as many."""
    parts = [name.split(".") for name in clip.names if name.startswith("weight.")]
    names = tuple(dict.fromkeys(".".join(part[1:-1]) for part in parts if len(part) > 2))
    if len(names) != len(regions.names) or set(names) == set(regions.names):
        return regions
    return replace(regions, names=names)
