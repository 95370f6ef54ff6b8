"""How one muscle moves the skin: along its fibre, or towards the seam of a ring (after Waters 1987)."""

from __future__ import annotations

import numpy as np

from mien.core.anatomy import Muscle
from mien.core.arrays import Floats, Ints
from mien.geometry.surface import unit

BLOCK = 4096
"""Points compared with a polyline at a time, so that memory stays small on large meshes."""


def fibre_length(fibre: Floats) -> float:
    """Return the length of a polyline, in its own unit."""
    return float(np.linalg.norm(np.diff(fibre, axis=0), axis=1).sum())


def on_polyline(line: Floats, points: Floats) -> tuple[Ints, Floats, Floats]:
    """Find the nearest point of a polyline to each of some points.

    Args:
        line: `(P, 3)`, at least two points.
        points: `(M, 3)`.

    Returns:
        `(M,)` number of the segment, `(M,)` how far along it from 0 to 1, `(M, 3)` the nearest point.
    """
    start, step = line[:-1], np.diff(line, axis=0)
    square = np.maximum((step * step).sum(axis=1), 1e-300)
    segment = np.empty(len(points), np.int64)
    share = np.empty(len(points))
    for first in range(0, len(points), BLOCK):
        some = slice(first, first + BLOCK)
        offset = points[some, None] - start
        along = np.clip((offset * step).sum(axis=2) / square, 0, 1)
        nearest = ((offset - along[..., None] * step) ** 2).sum(axis=2).argmin(axis=1)
        segment[some], share[some] = nearest, along[np.arange(len(nearest)), nearest]
    return segment, share, np.asarray(start[segment] + share[:, None] * step[segment])


def across(seam: Floats, points: Floats) -> Floats:
    """Return the `(M, 3)` places on a seam `(S, 3)` that lie across from points beside it.

    The place is the one as far along the line between the seam's ends as the point, so
    that points on either side of a slit, opposite each other, meet.  Beyond its ends the
    seam goes on straight.
    """
    along = unit(seam[-1] - seam[0])
    walked = np.maximum.accumulate((seam - seam[0]) @ along)
    reached = (points - seam[0]) @ along
    beyond = reached - np.clip(reached, walked[0], walked[-1])
    within = np.stack([np.interp(reached, walked, seam[:, axis]) for axis in range(3)], axis=1)
    return np.asarray(within + beyond[:, None] * along)


def beside(seam: Floats, points: Floats) -> Floats:
    """Return the `(M, 3)` places on a seam `(S, 3)` nearest to points; beyond its ends it goes on straight.

    What `across` is for lids, this is for lips: those of a snout run around it, and most of
    them lie in one place along the line between their corners.
    """
    far = fibre_length(seam) + float(np.ptp(np.concatenate([seam, points]), axis=0).sum())
    before, after = seam[:1] - far * unit(seam[1:2] - seam[:1]), seam[-1:] + far * unit(seam[-1:] - seam[-2:-1])
    return on_polyline(np.concatenate([before, seam, after]), points)[2]


def pull(muscle: Muscle, points: Floats) -> Floats:
    """Return the `(M, 3)` displacement of skin that follows a linear muscle fully at contraction 1.

    The skin moves towards the fixed end in the direction that the fibre has nearby, so
    that a fibre laid around the cheek pulls around it.
    """
    segment, share, _ = on_polyline(muscle.fibre, points)
    steps = unit(-np.diff(muscle.fibre, axis=0))
    tangents = unit(np.concatenate([steps[:1], steps[:-1] + steps[1:], steps[-1:]]))
    direction = unit((1 - share)[:, None] * tangents[segment] + share[:, None] * tangents[segment + 1])
    return np.asarray(muscle.shortening * fibre_length(muscle.fibre) * direction)


def drawn(points: Floats, places: Floats, share: Floats, pivot: Floats | None) -> Floats:
    """Return the `(M, 3)` displacement of points drawn this share of the way to their places.

    Args:
        points, places: `(M, 3)` where they are and where they would end.
        share: `(M,)` 0 to stay, 1 to arrive; more or less goes beyond.
        pivot: `(3,)` centre of the ball around which they travel, or None to go straight.
    """
    if pivot is None:
        return np.asarray(share[:, None] * (places - points))
    start, end = points - pivot, places - pivot
    near, far = (np.linalg.norm(v, axis=1, keepdims=True) for v in (start, end))
    u, v = unit(start), unit(end)
    across = v - (u * v).sum(axis=1, keepdims=True) * u
    sine = np.linalg.norm(across, axis=1, keepdims=True)
    angle = share[:, None] * np.arctan2(sine, (u * v).sum(axis=1, keepdims=True))
    turned = np.cos(angle) * u + np.sin(angle) * unit(across)
    return np.asarray((near + share[:, None] * (far - near)) * turned - start)
