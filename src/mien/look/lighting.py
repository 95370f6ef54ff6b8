"""The compiled loop that lights what the samples of a picture see.

The samples of one pixel share their light as long as they see one smooth surface, that
is triangles with a common corner; so smooth edges cost little more than rough ones.
What changes evenly across a triangle is set up once for a run of pixels in a row.

The lights and colours of `shade` are compiled in, and the compiled code is cached until
this file changes: after changing them there, save this file too.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.look.kernels import FIRST_BALL, HOLE
from mien.look.shade import (
    BRIGHTEST,
    FILL,
    HOLE_LIGHT,
    HOLLOW,
    IRIS,
    IRIS_COSINE,
    KEY,
    PUPIL,
    PUPIL_COSINE,
    RIM,
    WRAP,
)

NORMAL, TINT, GAZE, NEAR = 0, 3, 6, 9
"""Where a triangle's table holds each quantity; its last row is 1/distance."""


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def light_pixels(  # type: ignore[no-untyped-def]
    owner, screen, corners, normals, tint, gaze, balls, ball_tint, middle, focus, backdrop, left, table, picture
):
    """Write the bytes of each pixel's mean light; what the surface sends is dimmed by `left`.

    Args:
        owner: `(fine · H, fine · W)` what each sample sees.
        screen: `(N, 3)` column, row and 1/distance of the vertices.
        corners: `(T, 3)` vertex indices.
        normals, tint, gaze: `(N, 3)` per vertex, in the camera's axes; gaze zero where no iris is painted.
        balls, ball_tint: `(M, 5)` and `(M, 3)`.
        middle: column and row of the optical axis [samples].
        focus: samples per slope.
        backdrop: `(H, 3)` linear colours.
        left: `(H, W)` share of the light that furrows leave.
        table: bytes for light from 0 to `BRIGHTEST`.
        picture: `(H, W, 3)`, written where a sample sees something.
    """
    height, width = left.shape
    fine = len(owner) // height
    count = fine * fine
    own, lit = np.empty(count, np.int64), np.empty((count, 3))
    plane, now = np.empty((10, 3)), -1
    last = len(table) - 1
    for row in range(height):
        for column in range(width):
            seen = False
            for sample in range(count):
                own[sample] = owner[row * fine + sample // fine, column * fine + sample % fine]
                seen = seen or own[sample] != -1
            if not seen:
                continue
            total0 = total1 = total2 = 0.0
            for sample in range(count):
                who, known = own[sample], 0
                while known < sample and not _alike(own[known], who, corners, screen):
                    known += 1
                if known == sample:
                    x, y = column * fine + sample % fine + 0.5, row * fine + sample // fine + 0.5
                    eye_x, eye_y = (middle[0] - x) / focus, (y - middle[1]) / focus
                    if who >= 0:
                        if who != now:
                            _set_up(plane, who, screen, corners, normals, tint, gaze)
                            now = who
                        red, green, blue = _triangle(plane, x, y, eye_x, eye_y)
                        dim = left[row, column]
                        colour = (red * dim, green * dim, blue * dim)
                    elif who <= FIRST_BALL:
                        colour = _ball(balls[FIRST_BALL - who], ball_tint[FIRST_BALL - who], x, y, eye_x, eye_y)
                    elif who == HOLE:
                        colour = (HOLE_LIGHT[0], HOLE_LIGHT[1], HOLE_LIGHT[2])
                    else:
                        colour = (backdrop[row, 0], backdrop[row, 1], backdrop[row, 2])
                    lit[sample, 0], lit[sample, 1], lit[sample, 2] = colour
                total0 += lit[known, 0]
                total1 += lit[known, 1]
                total2 += lit[known, 2]
            scale = last / (BRIGHTEST * count)
            picture[row, column, 0] = table[min(int(total0 * scale), last)]
            picture[row, column, 1] = table[min(int(total1 * scale), last)]
            picture[row, column, 2] = table[min(int(total2 * scale), last)]


@njit(cache=True, nogil=True, inline="always")
def _alike(a, b, corners, screen):  # type: ignore[no-untyped-def]
    """Return whether two samples may share their light: one owner, or two sides of a smooth surface's edge."""
    if a == b:
        return True
    if a < 0 or b < 0:
        return False
    i, j, k = corners[a, 0], corners[a, 1], corners[a, 2]
    for c in range(3):
        corner = corners[b, c]
        if corner == i or corner == j or corner == k:
            return _behind(a, corners, screen) == _behind(b, corners, screen)
    return False


@njit(cache=True, nogil=True, inline="always")
def _behind(t, corners, screen):  # type: ignore[no-untyped-def]
    """Return whether a triangle is seen from behind; rows count downwards, so then its corners turn clockwise."""
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    across = (screen[j, 0] - screen[i, 0]) * (screen[k, 1] - screen[i, 1])
    return across > (screen[k, 0] - screen[i, 0]) * (screen[j, 1] - screen[i, 1])


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _set_up(plane, t, screen, corners, normals, tint, gaze):  # type: ignore[no-untyped-def]
    """Write how quantities over distance change on the picture: `(10, 3)` at the origin, per column, per row.

    A triangle seen from behind gets a normal of zero as its mark, for all that is needed is how it is turned.
    """
    ids = corners[t, 0], corners[t, 1], corners[t, 2]
    ax, ay, bx, by = screen[ids[0], 0], screen[ids[0], 1], screen[ids[1], 0], screen[ids[1], 1]
    cx, cy = screen[ids[2], 0], screen[ids[2], 1]
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
