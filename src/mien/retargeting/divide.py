"""Which markers and which parameters belong to the upper and to the lower face.

Few labels tie the brows to the jaw if both happened to move together; regions learned apart cannot
(the discussion of Bouaziz and Pauly 2014).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mien.core import InputError
from mien.core.arrays import Flags, Ints
from mien.retargeting.rows import ChannelRows, MarkerRows
from mien.vocabularies.regions import UPPER

AUTO = "auto"
FEWEST = 4
"""Markers that a region is learned from."""

Regions = tuple[tuple[Ints, Ints], tuple[Ints, Ints]]
"""Dimensions of the source of the upper and the lower region, and dimensions of the target."""


def divided(words: Sequence[str], names: Sequence[str], reading: MarkerRows | ChannelRows) -> Regions:
    """Divide parameters by their names, and the source by its channels' names or by its markers' heights at rest.

    Args:
        words: a parameter belongs to the upper face if its name holds one of these; `auto` stands for `UPPER`.
        names: of the parameters.
        reading: of the source.

    Raises:
        InputError: one of the regions has no parameter, or too few markers.
    """
    wanted = tuple(w for word in words for w in (UPPER if word == AUTO else (word,)))
    upper = _holding(names, wanted)
    if upper.all() or not upper.any():
        which = "all" if upper.all() else "none"
        raise InputError(
            f"{which} of the {len(names)} parameters ({', '.join(names[:5])} …) have one of {', '.join(wanted)} in their "
            "name, so there are no two regions; give words that only the upper face's parameters have, as in "
            "regions=brow,eye, or leave regions out."
        )
    return _sources(reading, wanted), (np.flatnonzero(upper), np.flatnonzero(~upper))


def _sources(reading: MarkerRows | ChannelRows, words: Sequence[str]) -> tuple[Ints, Ints]:
    if isinstance(reading, ChannelRows):
        upper = _holding(reading.names, words)
        if upper.all() or not upper.any():
            every = np.arange(len(upper))
            return every, every
        return np.flatnonzero(upper), np.flatnonzero(~upper)
    height = reading.neutral[:, 1]
    above = height > np.median(height)
    if min(above.sum(), (~above).sum()) < FEWEST:
        raise InputError(
            f"{len(above)} markers are too few to learn two regions apart, at least {2 * FEWEST} are needed; leave regions out."
        )
    return np.flatnonzero(np.repeat(above, 3)), np.flatnonzero(np.repeat(~above, 3))


def _holding(names: Sequence[str], words: Sequence[str]) -> Flags:
    return np.array([any(word.lower() in name.lower() for word in words) for name in names], dtype=bool)
