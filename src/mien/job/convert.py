"""Changing the vocabulary of a clip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Clip, InputError, Note
from mien.core.errors import unknown
from mien.vocabularies import ARKIT_NAMES, match

VOCABULARIES: dict[str, tuple[str, ...]] = {"arkit": ARKIT_NAMES}


def renamed(clip: Clip, vocabulary: str | None) -> tuple[Clip, tuple[Note, ...]]:
    """Return a clip in another vocabulary, and which names had no counterpart.

    Raises:
        InputError: the vocabulary is unknown, or shares no shape with the clip.
    """
    if vocabulary is None:
        return clip, ()
    if vocabulary not in VOCABULARIES:
        raise InputError(unknown("vocabulary", vocabulary, VOCABULARIES))
    found = match(clip.names, VOCABULARIES[vocabulary])
    if not found.matrix.any():
        raise InputError(f"no channel of the clip ({', '.join(clip.names[:6])} …) has a counterpart in {vocabulary}.")
    notes = []
    if found.unmatched_source:
        notes.append(
            Note(
                "channels-unused",
                f"{len(found.unmatched_source)} channels have no counterpart: {', '.join(found.unmatched_source[:12])}.",
            )
        )
    return replace(clip, names=found.target, values=np.asarray(found.apply(clip.values))), tuple(notes)
