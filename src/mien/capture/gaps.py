"""Short gaps are bridged; long ones stay gaps, and both are counted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Markers, Note
from mien.core.arrays import Floats, Ints

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
    points = markers.points.copy()
    limit = int(round(longest * markers.fps))
    bridged, left = 0, {}
    for m in np.flatnonzero(~markers.seen.all(axis=0)):
        seen = markers.seen[:, m]
        short = _bridgeable(seen, limit)
        if short.any():
            known = np.flatnonzero(seen)
            points[short, m] = monotone_cubic(known, markers.points[known, m], np.flatnonzero(short))
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


def monotone_cubic(x: Ints, y: Floats, at: Ints) -> Floats:
    """Interpolate by cubics that never overshoot (Fritsch and Butland 1984).

    As SciPy's `PchipInterpolator`, whose import alone takes longer than a minute of markers does here.

    Args:
        x: `(N,)` increasing; at least 2.
        y: `(N, 3)` values there.
        at: `(A,)` places between the first and the last.

    Returns:
        `(A, 3)`.
    """
    step = np.diff(x)[:, None].astype(np.float64)
    rise = np.diff(y, axis=0) / step
    slope = np.broadcast_to(rise, (2, 3)) if len(x) == 2 else _slopes(step, rise)
    left = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(rise) - 1)
    h, t = step[left], (at - x[left])[:, None] / step[left]
    begin, end = slope[left] * h, slope[left + 1] * h
    bend = begin + end - 2 * rise[left] * h
    return np.asarray(y[left] + t * (begin + t * (3 * rise[left] * h - 2 * begin - end + t * bend)))


def _slopes(step: Floats, rise: Floats) -> Floats:
    """Return the slopes at knots: harmonic means of those on both sides, level where these turn."""
    one, other = step[1:] + 2 * step[:-1], 2 * step[1:] + step[:-1]
    turns = np.sign(rise[1:]) * np.sign(rise[:-1]) <= 0
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = (one + other) / (other / rise[:-1] + one / rise[1:])
    ends = [_end_slope(*step[k], *rise[k]) for k in ([0, 1], [-1, -2])]
    return np.concatenate([ends[:1], np.where(turns, 0.0, inner), ends[1:]])


def _end_slope(step: Floats, inner_step: Floats, rise: Floats, inner_rise: Floats) -> Floats:
    """Return the slope at the first or last knot: of the parabola through three, held to the side it is on."""
    slope = ((2 * step + inner_step) * rise - step * inner_rise) / (step + inner_step)
    slope = np.where(np.sign(slope) != np.sign(rise), 0.0, slope)
    steep = (np.sign(rise) != np.sign(inner_rise)) & (np.abs(slope) > 3 * np.abs(rise))
    return np.where(steep, 3 * rise, slope)
