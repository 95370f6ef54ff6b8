"""Which region of the face a shape moves, by the words in its name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mien.vocabularies.names import shape_key

REGIONS: Mapping[str, tuple[str, ...]] = {
    "brows": ("brow", "forehead"),
    "cheeks": ("cheek", "nose"),
    "eyes": ("eye", "lid", "blink", "squint"),
}
"""Words in the names of each region's shapes: a shape belongs to the first that holds one, all others to the mouth."""
MOUTH = "mouth"
UPPER = (*REGIONS["brows"], *REGIONS["eyes"])
"""Words in the names of what moves the upper face."""


def regions_of(names: Sequence[str]) -> np.ndarray:
    """Return which region of the face each shape belongs to, a key of `REGIONS` or `MOUTH`."""
    stems = [shape_key(name).stem for name in names]
    return np.array([next((r for r, words in REGIONS.items() if any(w in s for w in words)), MOUTH) for s in stems])
