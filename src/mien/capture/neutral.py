"""Finding the frame in which the face is at rest.

An actor returns to rest again and again, and starts there: the neutral is where the
take dwells.  Frames are compared with the head's motion taken out; the frame with the
most others close to it wins, an early one before a late one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from mien.capture.stabilise import learn_stabiliser
from mien.core import InputError, Markers
from mien.core.arrays import Floats
from mien.core.units import human_centimetre

CLOSE_CM = 0.12
"""Two frames show the same face if their points differ by no more than this (root mean square)."""
LOOKED_AT = 800
"""Longer takes are thinned to about this many frames for the comparison."""


@dataclass(frozen=True, eq=False)
class Neutral:
    """The face at rest.

    Attributes:
        points: `(M, 3)`.
        frame: the frame it was taken from, or None if it was given otherwise.
        dwell: share of the take spent close to it.
    """

    points: Floats
    frame: int | None
    dwell: float


def find_neutral(markers: Markers) -> Neutral:
    """Find the face at rest in a take.

    Returns:
        The neutral: the mean of the frames around the one found, to take the noise down.

    Raises:
        InputError: no frame sees all markers.
    """
    whole = np.flatnonzero(markers.seen.all(axis=1))
    if len(whole) == 0:
        seen = np.asarray(markers.seen.any(axis=0))
        gone = [n for n, s in zip(markers.names, seen, strict=True) if not s]
        why = f" Never seen: {', '.join(gone[:6])}; leave them out of the pairs." if gone else ""
        raise InputError(
            f"no frame of the take sees all {len(markers.names)} paired markers, so none can be the neutral.{why}"
        )
    looked = whole[:: max(1, len(whole) // LOOKED_AT)]
    points = markers.points[looked]
    first = points[0]
    centimetre = human_centimetre(first)
    still, _ = learn_stabiliser(first, points)(points)
    flat = still.reshape(len(still), -1) / np.sqrt(still.shape[1])
    close = cdist(flat, flat) < CLOSE_CM * centimetre
    popularity = close.sum(axis=1)
    best = int(np.argmax(popularity >= 0.8 * popularity.max()))  # the earliest of the popular frames
    members = np.flatnonzero(close[best])
    centre = members[np.argmax(close[np.ix_(members, members)].sum(axis=1))]
    frame = int(looked[centre])
    return neutral_at(markers, frame, float(close[centre].mean()))


def neutral_at(markers: Markers, frame: int, dwell: float = float("nan")) -> Neutral:
    """Take the neutral from a frame, averaged with its neighbours that show the same.

    Raises:
        InputError: the take has no such frame, or a marker is missing there.
    """
    if not 0 <= frame < len(markers):
        raise InputError(f"the neutral is to be frame {frame}, but the take has frames 0 … {len(markers) - 1}.")
    here = markers.points[frame]
    if not markers.seen[frame].all():
        gone = [n for n, s in zip(markers.names, markers.seen[frame], strict=True) if not s]
        raise InputError(
            f"the neutral frame {frame} misses {', '.join(gone[:6])}; choose a frame that sees every marker."
        )
    near = markers.points[max(0, frame - 2) : frame + 3]
    off = np.sqrt(((near - here) ** 2).sum(axis=2).mean(axis=1))
    alike = near[off < 0.5 * CLOSE_CM * human_centimetre(here)]  # false for frames with gaps
    return Neutral(alike.mean(axis=0), frame, dwell)
