"""Recognising a known list of expressions in a take in which an actor does them in order.

The order does most of the work: what a hold shows need only look more like its expression
than like nothing, since neighbours in time must be neighbours in the list.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.capture.holds import Hold, find_holds, from_rest, mean_face, movement
from mien.core.arrays import Floats, Ints
from mien.retargeting.prepare import Prepared

AWAY = (0.1, 0.14, 0.2, 0.28, 0.4, 0.56)
"""How far from rest may begin a hold: a look is no more than the first, and some actors never come back closer than the last."""
LEAST = 0.3
"""A hold that looks less like its expression than this [cosine] is none of it."""
UNSEEN_CM = 0.02
"""An expression that moves no point by this much cannot be recognised."""


@dataclass(frozen=True, eq=False)
class Listed:
    """What of a list was recognised.

    Attributes:
        holds: `N` holds that were recognised, in time.
        entries: `(N,)` what they are, numbers in the list, increasing.
        frames: `(N,)` a frame in the middle of each, with as many points seen as can be.
        likeness: `(N,)` how much each looks like it [cosine].
        others: stretches in which the face is away from rest, and that are nothing in the list.
        seen: `(E,)` which expressions of the list move the points at all.
        backwards: how well the list backwards fits, as a share of how well it fits: about 1 for a take of something else.
    """

    holds: tuple[Hold, ...]
    entries: Ints
    frames: Ints
    likeness: Floats
    others: tuple[Hold, ...]
    seen: np.ndarray
    backwards: float


def recognise(prepared: Prepared, weights: Floats) -> Listed:
    """Recognise expressions done in order, some perhaps left out, with other things in between.

    Args:
        prepared: the take beside the character.
        weights: `(E, K)` what the character's shapes are in each expression of the list.
    """
    take, shapes = from_rest(prepared.take, prepared.fps), np.tensordot(weights, prepared.terms.deltas, axes=1)
    moved = movement(take, prepared.fps)
    found = {hold for away in AWAY for hold in find_holds(moved, prepared.fps, away)}
    holds = sorted(found, key=lambda hold: (hold.last, hold.first))
    ends = np.array([hold.last for hold in holds], dtype=np.int64)
    before = np.searchsorted(ends, [hold.first for hold in holds])
    likeness = np.array([_likeness(mean_face(take[hold.plateau]), shapes) for hold in holds]).reshape(
        len(holds), len(shapes)
    )
    gain = likeness - LEAST
    rows, entries = in_order(gain, before)
    chosen = tuple(holds[i] for i in rows)
    return Listed(
        chosen,
        entries,
        np.array([_best_frame(take, hold) for hold in chosen], dtype=np.int64),
        likeness[rows, entries],
        _others(holds, chosen),
        _visible(shapes),
        _fit(gain[:, ::-1], before) / max(_fit(gain, before), 1e-9),
    )


def in_order(gain: Floats, before: Ints) -> tuple[Ints, Ints]:
    """Pair rows with columns, both in order, for the largest sum of gains; any may stay alone.

    Args:
        gain: `(N, E)` of each pair.
        before: `(N,)` how many of the rows may stand before each; later ones overlap it.

    Returns:
        The rows and the columns that are paired, both increasing.
    """
    best = np.zeros((gain.shape[0] + 1, gain.shape[1] + 1))
    for i, row in enumerate(gain):
        paired = np.concatenate([[0.0], best[before[i], :-1] + row])
        best[i + 1] = np.maximum.accumulate(np.maximum(best[i], paired))
    pairs = []
    i, j = gain.shape
    while i and j:
        if best[i, j] == best[i - 1, j]:
            i -= 1
        elif best[i, j] == best[i, j - 1]:
            j -= 1
        else:
            pairs.append((i - 1, j - 1))
            i, j = int(before[i - 1]), j - 1
    rows, columns = np.array(pairs[::-1], dtype=np.int64).reshape(-1, 2).T
    return rows, columns


def _fit(gain: Floats, before: Ints) -> float:
    return float(gain[in_order(gain, before)].sum())


def _others(holds: Sequence[Hold], chosen: Sequence[Hold]) -> tuple[Hold, ...]:
    """Return the holds that overlap none of the chosen, the outermost of those within each other."""
    free = [hold for hold in holds if not any(hold.overlaps(one) for one in chosen)]
    return tuple(hold for hold in free if not any(other.contains(hold) for other in free))


def _likeness(face: Floats, shapes: Floats) -> Floats:
    """Return the cosines `(E,)` between a face and expressions, at the points that are seen; 0 where there is none."""
    seen = ~np.isnan(face).any(axis=1)
    one, all_ = face[seen].ravel(), shapes[:, seen].reshape(len(shapes), -1)
    size = np.linalg.norm(one) * np.linalg.norm(all_, axis=1)
    known = _visible(shapes) & (size > 0)
    return np.asarray(np.divide(all_ @ one, size, out=np.zeros(len(shapes)), where=known))


def _visible(shapes: Floats) -> np.ndarray:
    return np.asarray(np.linalg.norm(shapes, axis=2).max(axis=1) > UNSEEN_CM)


def _best_frame(take: Floats, hold: Hold) -> int:
    """Return the frame of the plateau that sees most points, the nearest to its middle of those."""
    frames = hold.plateau
    seen = (~np.isnan(take[frames]).any(axis=2)).sum(axis=1)
    aside = np.abs(frames - (hold.first + hold.last) / 2)
    return int(frames[np.lexsort((aside, -seen))[0]])
