"""What marker files say about their markers: names and units, made usable."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mien.core import Note
from mien.core.arrays import Floats, Ints

_METRES = {
    "mm": 0.001, "millimeters": 0.001, "millimetres": 0.001,
    "cm": 0.01, "centimeters": 0.01, "centimetres": 0.01,
    "dm": 0.1,
    "m": 1.0, "meters": 1.0, "metres": 1.0,
    "in": 0.0254, "inches": 0.0254,
    "ft": 0.3048,
}  # fmt: skip
_UNLABELLED = re.compile(r"(\*\d*|U[_ ]?\d+|unlabel+ed[_ ]?\d*|uname\*?\d*)?$", re.IGNORECASE)


def metres_per(unit: str, notes: list[Note], where: str) -> float:
    """Return metres per unit; an unknown one is taken for millimetres and noted."""
    known = _METRES.get(unit.strip().strip("\0").lower())
    if known is None:
        notes.append(Note("unit-assumed", f"the unit {unit.strip()[:20]!r} is unknown; millimetres are assumed", where))
    return 0.001 if known is None else known


def named_markers(labels: Sequence[str], notes: list[Note], where: str) -> tuple[tuple[str, ...], Ints]:
    """Return distinct names of the labelled markers and which of the file's markers they are.

    A subject's prefix that all share (`Actor:Chin`) is dropped; markers without a
    label (`*12`, `U_3`, blank) are left out; repeated labels get a number.

    Args:
        labels: one a marker, as in the file.
        notes: where changes are noted.
        where: the file, for notes.
    """
    stripped = [label.strip().strip("\0").strip() for label in labels]
    kept = [i for i, label in enumerate(stripped) if not _UNLABELLED.match(label.rpartition(":")[2])]
    if len(kept) < len(stripped):
        count = len(stripped) - len(kept)
        notes.append(
            Note("unlabelled-markers", f"{count} of {len(stripped)} markers have no label and are left out", where)
        )
    names = [stripped[i] for i in kept]
    subjects = {name.partition(":")[0] if ":" in name else None for name in names}
    if len(subjects) == 1 and None not in subjects:
        names = [name.partition(":")[2] for name in names]
    return tuple(_distinct(names, notes, where)), np.array(kept, dtype=np.int64)


def without_zeros(points: Floats, notes: list[Note], where: str, unseen: NDArray[np.bool_] | None = None) -> Floats:
    """Return points `(F, M, 3)` in which what was not seen is NaN, counted in a note.

    Args:
        points: positions; NaN and exact zeros mean not seen.
        notes: where the count is noted.
        where: the file, for the note.
        unseen: `(F, M)` true where the file itself says so (a residual of -1), or None.
    """
    blank = ~np.isfinite(points).all(axis=2)
    zero = ~blank & (points == 0).all(axis=2)
    flagged = np.zeros_like(blank) if unseen is None else unseen & ~blank & ~zero
    gaps = blank | zero | flagged
    if gaps.any():
        kinds = (("blank", blank), ("at zero", zero), ("marked as not seen", flagged))
        counted = ", ".join(f"{int(kind.sum())} {name}" for name, kind in kinds if kind.any())
        message = f"{int(gaps.sum())} samples of {int(gaps.any(axis=0).sum())} markers are gaps ({counted})"
        notes.append(Note("gaps", message, where))
    return np.where(gaps[..., None], np.nan, points)


def _distinct(names: Sequence[str], notes: list[Note], where: str) -> list[str]:
    taken = set(names)
    seen: set[str] = set()
    result = []
    for name in names:
        fresh, number = name, 2
        while fresh in seen or (fresh != name and fresh in taken):
            fresh, number = f"{name}_{number}", number + 1
        if fresh != name:
            notes.append(Note("repeated-label", f"a second marker {name!r} is called {fresh!r}", where))
        seen.add(fresh)
        result.append(fresh)
    return result
