"""Closed lids that leave nothing of the eye to be seen.

Lids meet where their edges were laid by the correspondence.  At the corners of the eye it
is least sure, and a face's own slit may reach farther than the one that was laid on it.
So once a pose has closed the lids, the eyeball is looked at from its centre: wherever it
still shows, the skin on both sides of the opening is drawn together; and what was drawn
straight to where it meets, into the ball, is lifted back onto it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy import sparse

from mien.core import Muscle
from mien.core.arrays import Floats, Ints
from mien.core.units import human_centimetre
from mien.geometry.surface import unit
from mien.rigging.contact import Bumps, Meeting
from mien.rigging.dense import DenseFit

STEP = np.radians(0.5)
"""Between two directions in which the eyeball is looked at [rad]."""
HALF = 120
"""So many directions on either side of the middle."""
ON_BALL = (0.5, 1.4)
"""What lies between these shares of the seam's distance from the centre is eyeball."""
WIDEST_CM = 0.6
"""What is farther open than this is not closed by its lids, on a human face."""
PRESSED = 1.03
"""A lid may be pressed into the ball by this factor of its own distance from the centre."""
OVER = 2
"""One lid comes to lie over the other by so many steps."""
ROUNDS = 4


class Seen(NamedTuple):
    """What lies in each direction `(D, D)`, columns along the seam: how far, and which triangle, -1 if none."""

    distance: Floats
    triangle: Ints


class Eye(NamedTuple):
    """An eyeball that is looked at from its centre.

    Attributes:
        centre: `(3,)`.
        axes: `(3, 3)` rows along the seam, up, and ahead.
        radius: of the seam.
        ball: `(T, 3)` triangles of the eyeball.
        skin: `(S, 3)` triangles of the skin.
    """

    centre: Floats
    axes: Floats
    radius: float
    ball: Ints
    skin: Ints

    @classmethod
    def under(cls, lid: Muscle, vertices: Floats, skin: Ints, parts: Ints) -> Eye:
        """Find the eyeball that a lid's muscle closes over, among triangles `parts` that are not `skin`."""
        assert lid.seam is not None
        assert lid.pivot is not None
        arms = lid.seam - lid.pivot
        radius = float(np.median(np.linalg.norm(arms, axis=1)))
        ahead = unit(arms.mean(axis=0))
        up = unit(np.cross(ahead, lid.seam[-1] - lid.seam[0]))
        away = np.linalg.norm(vertices[parts] - lid.pivot, axis=2).max(axis=1)
        axes = np.stack([np.cross(up, ahead), up, ahead])
        return cls(lid.pivot, axes, radius, parts[away < ON_BALL[1] * radius], skin)

    def look(self, posed: Floats, triangles: Ints, farthest: float) -> Seen:
        """Return what of some triangles is outermost in each direction."""
        return Seen(*_cast((posed - self.centre) @ self.axes.T, triangles, ON_BALL[0] * self.radius, farthest))

    def lifted(self, posed: Floats, rest: Floats) -> Floats:
        """Return vertices `(N, 3)`, those of the skin that are a little within the ball, and were not at rest, on it."""
        height = self.look(posed, self.ball, ON_BALL[1] * self.radius).distance
        result, ids = np.array(posed), np.unique(self.skin)
        depth = []
        for points in (rest[ids], posed[ids]):
            arms = (points - self.centre) @ self.axes.T
            places = np.round(_places(arms)).astype(np.int64)
            ahead = np.all((places >= 0) & (places <= 2 * HALF), axis=1, keepdims=False)
            column, row = np.where(ahead[:, None], places, 0).T
            depth.append(np.where(ahead, height[column, row], 0) / np.maximum(np.linalg.norm(arms, axis=1), 1e-300))
        pressed = (depth[0] <= 1) & (depth[1] > 1) & (depth[1] < PRESSED)  # deeper is the lining of the other lid
        result[ids[pressed]] = self.centre + depth[1][pressed, None] * (posed[ids[pressed]] - self.centre)
        return result

    def openings(self, posed: Floats) -> Ints:
        """Return `(O, 3)` column, and the rows before and behind, of every stretch in which the eyeball shows."""
        covered = self.look(posed, self.skin, np.inf).triangle >= 0
        shows = (self.look(posed, self.ball, ON_BALL[1] * self.radius).triangle >= 0) & ~covered
        edge = np.diff(np.pad(shows, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        (column, first), after = np.nonzero(edge == 1), np.nonzero(edge == -1)[1]
        found = np.column_stack([column, first - 1, after])
        return np.asarray(found[(found[:, 1] >= 0) & (found[:, 2] <= 2 * HALF)])

    def widest(self, posed: Floats) -> float:
        """Return how far the eyeball shows at most, across the slit [m]."""
        found = self.openings(posed)
        return float(STEP * self.radius * (found[:, 2] - found[:, 1] - 1).max(initial=0))


def sealed(posed: Floats, eye: Eye, fit: DenseFit) -> tuple[Floats, float, float]:
    """Draw the lids of a closed eye together where its eyeball still shows.

    Args:
        posed: `(N, 3)` vertices of the face with lids closed, those of the target first.
        eye: the eyeball.
        fit: the correspondence to the face.

    Returns:
        `(N, 3)` vertices, and how far open the eye was and is, at its widest [m].
    """
    result, count = np.array(posed), len(fit.target.vertices)
    most = WIDEST_CM * human_centimetre(fit.warp(fit.warp.centres)) / (STEP * eye.radius)
    for _ in range(ROUNDS):
        pairs = eye.openings(result)
        meeting = _meeting(result, eye, pairs[pairs[:, 2] - pairs[:, 1] <= most], count)
        if meeting is None:
            break
        result[:count] += Bumps(fit, [meeting]).change(meeting, meeting.missing(result[:count]))
    result = eye.lifted(result, np.concatenate([fit.target.vertices, result[count:]]))
    return result, eye.widest(posed), eye.widest(result)


def _meeting(posed: Floats, eye: Eye, pairs: Ints, count: int) -> Meeting | None:
    """Return the pairs of points on both sides of the openings as contacts that are to close; None if there are none."""
    seen = eye.look(posed, eye.skin, np.inf)
    triangle = seen.triangle[pairs[:, :1], pairs[:, 1:]]
    near = seen.distance[pairs[:, :1], pairs[:, 1:]] < ON_BALL[1] * eye.radius
    kept = (triangle >= 0).all(axis=1) & near.all(axis=1)
    if not kept.any():
        return None
    triangle, pairs = triangle[kept], pairs[kept]
    sides = []
    for side in (0, 1):
        corners = eye.skin[triangle[:, side]]
        aim = _directions(pairs[:, 0], pairs[:, 1 + side]) @ eye.axes
        weights = np.linalg.solve(np.swapaxes(posed[corners] - eye.centre, 1, 2), aim[:, :, None])[:, :, 0]
        weights = np.clip(weights, 0, None)
        weights /= weights.sum(axis=1, keepdims=True)
        ends = np.arange(0, 3 * len(corners) + 1, 3)
        sides.append(sparse.csr_matrix((weights.ravel(), corners.ravel(), ends), shape=(len(corners), count)))
    difference = sparse.csr_matrix(sides[1] - sides[0])
    apart = difference @ posed[:count]
    way = unit(apart)
    along = eye.axes[0]
    across = np.broadcast_to(np.eye(3) - along[:, None] * along, (len(way), 3, 3))
    goal = -OVER * STEP * eye.radius * way
    return Meeting("closed", (0,), 0, difference, goal, apart, across, apart)


def _directions(columns: Ints, rows: Ints) -> Floats:
    turn, rise = (columns - HALF) * STEP, (rows - HALF) * STEP
    return np.stack([np.cos(rise) * np.sin(turn), np.sin(rise), np.cos(rise) * np.cos(turn)], axis=1)


def _places(points: Floats) -> Floats:
    """Return in which column and row points `(N, 3)` are seen from the origin, `(N, 2)`."""
    flat = np.hypot(points[:, 0], points[:, 2])
    turn, rise = np.arctan2(points[:, 0], points[:, 2]), np.arctan2(points[:, 1], flat)
    return np.asarray(np.stack([turn, rise], axis=1) / STEP + HALF)


def _cast(points: Floats, triangles: Ints, nearest: float, farthest: float) -> tuple[Floats, Ints]:
    """Return how far the outermost of some triangles is in each direction from the origin, and which one it is."""
    places = _places(points)
    steps = (np.arange(2 * HALF + 1) - HALF) * STEP
    reach = np.linalg.norm(points, axis=1)
    return _outermost(points, triangles, places, reach, np.sin(steps), np.cos(steps), nearest, farthest)


@njit(cache=True, nogil=True)
def _outermost(
    points: Floats,
    triangles: Ints,
    places: Floats,
    reach: Floats,
    sine: Floats,
    cosine: Floats,
    nearest: float,
    farthest: float,
) -> tuple[Floats, Ints]:
    """Meet triangles with the directions around their corners, whose column and row is in `places` `(N, 2)`."""
    last = len(sine) - 1
    distance = np.full((last + 1, last + 1), -np.inf)
    found = np.full((last + 1, last + 1), -1)
    for number in range(len(triangles)):
        i, j, k = triangles[number]
        if max(reach[i], reach[j], reach[k]) < nearest or min(reach[i], reach[j], reach[k]) > farthest:
            continue
        left, right = min(places[i, 0], places[j, 0], places[k, 0]), max(places[i, 0], places[j, 0], places[k, 0])
        low, high = min(places[i, 1], places[j, 1], places[k, 1]), max(places[i, 1], places[j, 1], places[k, 1])
        if right - left > HALF:  # around the back of the head
            continue
        a, b, c = points[i], points[j], points[k]
        # a direction's share of a corner is its volume with the other two
        nax, nay, naz = b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]
        nbx, nby, nbz = c[1] * a[2] - c[2] * a[1], c[2] * a[0] - c[0] * a[2], c[0] * a[1] - c[1] * a[0]
        ncx, ncy, ncz = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        volume = a[0] * nax + a[1] * nay + a[2] * naz
        for column in range(max(int(left) - 1, 0), min(int(right) + 2, last) + 1):
            for row in range(max(int(low) - 1, 0), min(int(high) + 2, last) + 1):
                x, y, z = cosine[row] * sine[column], sine[row], cosine[row] * cosine[column]
                u, v = x * nax + y * nay + z * naz, x * nbx + y * nby + z * nbz
                w = x * ncx + y * ncy + z * ncz
                total = u + v + w
                if abs(total) < 1e-300:
                    continue
                far = volume / total
                inside = min(u / total, v / total, w / total) >= -1e-9
                if inside and nearest < far < farthest and far > distance[column, row]:
                    distance[column, row] = far
                    found[column, row] = number
    return distance, found
