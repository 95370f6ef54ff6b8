"""Extremes chosen from a take by rule, where nobody has picked any.

Each choice is the frame farthest from those chosen before, so that the simplices reach as
far as the actor does.  A person who knows which frame is which emotion picks better; a rule
is what figures and benchmarks can repeat.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mien.core import InputError, Labels
from mien.core.arrays import Flags, Floats, Ints
from mien.retargeting.layers.sources import Pick

COUNTS: Mapping[str, int] = {"emotion": 29, "speech": 12, "blink": 3}
"""As many as the paper has."""


def choose_extremes(moved: Floats, regions: Labels, counts: Mapping[str, int] = COUNTS) -> tuple[Pick, ...]:
    """Return frames of a take that serve as extremes.

    Emotions are told apart by the whole face.  Visemes are told apart by the mouth, among the
    half of the frames in which the rest of the face is quietest; blinks by the eyes, likewise.
    The first extreme of each layer is the frame nearest to rest.

    Args:
        moved: `(F, P, 3)` displacements from rest with the head held still; NaN where not seen.
        regions: of the points; named `mouth` and `eyes`, whatever the rest.
        counts: extremes per layer.

    Raises:
        InputError: a region is missing, or the take has too few different frames.
    """
    whole = np.flatnonzero(~np.isnan(moved).any(axis=(1, 2)))
    if not len(whole):
        raise InputError("no frame of the take sees every point, so no frame can be an extreme.")
    picks = []
    for layer, own in (("emotion", None), ("speech", "mouth"), ("blink", "eyes")):
        if layer not in counts:
            continue
        mask = np.ones(len(regions.of), bool) if own is None else regions.of == _region(regions, own)
        for k, frame in enumerate(_farthest(moved, whole, mask, counts[layer], layer)):
            picks.append(Pick(layer, f"{layer}_{k:02d}", int(frame)))
    return tuple(picks)


def _farthest(moved: Floats, whole: Ints, mask: Flags, count: int, layer: str) -> Ints:
    others = np.linalg.norm(moved[whole][:, ~mask], axis=(1, 2)) if not mask.all() else np.zeros(len(whole))
    usable = whole[others <= np.median(others)]
    seen = moved[usable][:, mask].reshape(len(usable), -1)
    size = np.linalg.norm(moved[usable].reshape(len(usable), -1), axis=1)
    chosen = [int(np.argmin(size))]
    distance = np.full(len(usable), np.inf)
    while len(chosen) < count:
        distance = np.minimum(distance, np.linalg.norm(seen - seen[chosen[-1]], axis=1))
        best = int(np.argmax(distance))
        if not distance[best] > 0:
            raise InputError(
                f"the take has only {len(chosen)} frames that differ where the layer {layer!r} shows, but {count} are wanted; "
                "give a longer take or ask for fewer extremes."
            )
        chosen.append(best)
    return usable[chosen]


def _region(regions: Labels, name: str) -> int:
    if name not in regions.names:
        raise InputError(
            f"the points have no region {name!r} ({', '.join(regions.names)}), which its layer is told apart by."
        )
    return regions.names.index(name)
