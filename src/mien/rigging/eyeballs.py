"""Eyeballs for a face that has none: as large, and as deep, as its lids leave room for.

The lids lie on the eyeball, so where they came to lie on the face says where its
eyeball is: the ball is fitted under them as closely as it sat under the lids it came
from, and no lid may cut into it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mien.core.arrays import Floats
from mien.geometry.surface import unit
from mien.rigging.dense import DenseFit
from mien.rigging.parts import centre_of
from mien.rigging.structure import Structure

ROUND = 0.08
"""A part is a ball if its vertices are this close to a sphere, as a share of its radius …"""
DEEP = 0.8
"""… and it is at least this deep in every direction, in radii: a dental arch lies on a sphere too."""
ON_BALL = (0.9, 1.12)
"""Skin lies on a ball if its distance from the centre is between these shares of the radius."""
FEWEST = 12
"""With fewer such vertices nothing is known about how the ball sits."""
PRIOR = 0.1
"""How much where the warp takes the ball counts, beside all of the skin that lies on it."""
CLOSE = 0.05
"""Lids of the face are what lies this close to the lids that were put on it, as a share of the radius."""
CLEAR = 0.01
"""Lids stay this far off the ball, as a share of its radius."""
ROUNDS = 40


class Ball(NamedTuple):
    """A centre `(3,)` and a radius [m]."""

    centre: Floats
    radius: float


def ball_of(points: Floats) -> Ball | None:
    """Return the ball that points `(M, 3)` lie on, None if they lie on none."""
    centre = centre_of(points)
    lengths = np.linalg.norm(points - centre, axis=1)
    radius = float(np.median(lengths))
    deep = float(np.ptp(points, axis=0).min()) > DEEP * radius
    return Ball(centre, radius) if deep and lengths.std() < ROUND * radius else None


def fitted_ball(ball: Ball, fit: DenseFit, structure: Structure) -> Ball:
    """Return where an eyeball of the source sits on the target, and how large it is there."""
    turn, scale = structure.around(ball.centre)
    guess = Ball(structure.warp(ball.centre[None])[0], float(scale) * ball.radius)
    off = np.linalg.norm(fit.source.vertices - ball.centre, axis=1) / ball.radius
    on_ball = fit.paired & (off > ON_BALL[0]) & (off < ON_BALL[1])
    lids = np.flatnonzero(on_ball)
    if len(lids) < FEWEST:
        return guess
    gaze = turn @ unit(fit.source.vertices[lids].mean(axis=0) - ball.centre)
    own = fit.target_skin & on_ball[fit.back.corners].any(axis=1) & (fit.back_distance < CLOSE * guess.radius)
    return _cleared(_under(fit.stuck[lids], off[lids], guess), gaze, fit.target.vertices[own])


def _under(places: Floats, off: Floats, guess: Ball) -> Ball:
    """Fit a ball so that places `(M, 3)` are `off` `(M,)` radii from its centre, by Gauss-Newton from a guess."""
    centre, radius = guess
    hold = np.sqrt(PRIOR * len(places))
    for _ in range(ROUNDS):
        arms = places - centre
        length = np.linalg.norm(arms, axis=1)
        rows = np.vstack([np.column_stack([-arms / length[:, None], -off]), hold * np.eye(4)])
        left = np.concatenate([length - off * radius, hold * (centre - guess.centre), [hold * (radius - guess.radius)]])
        step = np.linalg.lstsq(rows, -left, rcond=None)[0]
        centre, radius = centre + step[:3], radius + float(step[3])
        if np.abs(step).max() < 1e-6 * guess.radius:
            break
    return Ball(centre, radius)


def _cleared(ball: Ball, gaze: Floats, lids: Floats) -> Ball:
    """Draw a ball back, and make it smaller, until no lid in front of its centre cuts into it."""
    centre, radius = ball
    for _ in range(ROUNDS):
        arms = lids - centre
        ahead = np.linalg.norm(arms[arms @ gaze > 0], axis=1)
        cut = (1 + CLEAR) * radius - float(ahead.min(initial=np.inf))
        if cut <= 0:
            break
        centre, radius = centre - 0.6 * cut * gaze, radius - 0.4 * cut
    return Ball(centre, radius)
