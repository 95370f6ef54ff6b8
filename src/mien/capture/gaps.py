"""Short gaps are bridged; long ones stay gaps, and both are counted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Markers, Note

LONGEST_BRIDGE_S = 0.2
"""Gaps up to this long are bridged: about the length of a blink, the fastest thing a face does."""


def fill_gaps(markers: Markers, longest: float = LONGEST_BRIDGE_S) -> Markers:
    """Bridge gaps of up to `longest` seconds by monotone cubics; leave longer ones as NaN.

    A gap at the beginning or end of the take is left: there is nothing to bridge to.

    Returns:
        The markers, with a note that counts the samples bridged and those still missing.
    """
    if markers.seen.all():
        return markers
    from scipy.interpolate import PchipInterpolator  # slow to import, and not every take needs it

    points = markers.points.copy()
    limit = int(round(longest * markers.fps))
    bridged, left = 0, {}
    for m in np.flatnonzero(~markers.seen.all(axis=0)):
        seen = markers.seen[:, m]
        short = _bridgeable(seen, limit)
        if short.any():
            known = np.flatnonzero(seen)
            points[short, m] = PchipInterpolator(known, markers.points[known, m], axis=0)(np.flatnonzero(short))
            bridged += int(short.sum())
        missing = int((~seen & ~short).sum())
        if missing:
            left[markers.names[m]] = missing
    notes = list(markers.notes)
    if bridged:
        notes.append(
            Note("gaps-filled", f"{bridged} missing marker samples in gaps of at most {longest:g} s were bridged.")
        )
    if left:
        worst = ", ".join(f"{name} ({n} frames)" for name, n in sorted(left.items(), key=lambda x: -x[1])[:5])
        more = f" and {len(left) - 5} more" if len(left) > 5 else ""
        text = f"{sum(left.values())} marker samples are missing for longer and are left out of the fit: {worst}{more}."
        notes.append(Note("gaps-left", text))
    return replace(markers, points=points, notes=tuple(notes))


def _bridgeable(seen: np.ndarray, limit: int) -> np.ndarray:
    """Mark unseen frames in runs of at most `limit` with something seen on both sides."""
    result = np.zeros(len(seen), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[True], seen, [True]]).astype(np.int8)))
    for begin, end in edges.reshape(-1, 2):
        if begin > 0 and end < len(seen) and end - begin <= limit and seen.sum() >= 2:
            result[begin:end] = True
    return result
