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

NORMAL, TINT, GAZE, NEAR, MARKS = 0, 3, 6, 9, 10
"""Where the table of a triangle holds each quantity; at the end whether it is seen from behind, and has an iris."""


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
    plane, now = np.empty((11, 3)), -1
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
    """Write how each quantity over distance changes on the picture: at the origin, per column, per row."""
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    ax, ay, bx, by = screen[i, 0], screen[i, 1], screen[j, 0], screen[j, 1]
    cx, cy = screen[k, 0], screen[k, 1]
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    u_x, u_y, v_x, v_y = (by - cy) / area, (cx - bx) / area, (cy - ay) / area, (ax - cx) / area
    u, v = -u_x * cx - u_y * cy, -v_x * cx - v_y * cy
    steps = ((u, v, 1 - u - v), (u_x, v_x, -u_x - v_x), (u_y, v_y, -u_y - v_y))
    for s in range(3):
        a, b, c = steps[s][0] * screen[i, 2], steps[s][1] * screen[j, 2], steps[s][2] * screen[k, 2]
        for axis in range(3):
            plane[NORMAL + axis, s] = a * normals[i, axis] + b * normals[j, axis] + c * normals[k, axis]
            plane[TINT + axis, s] = a * tint[i, axis] + b * tint[j, axis] + c * tint[k, axis]
            plane[GAZE + axis, s] = a * gaze[i, axis] + b * gaze[j, axis] + c * gaze[k, axis]
        plane[NEAR, s] = a + b + c
    plane[MARKS, 0] = area > 0
    plane[MARKS, 1] = gaze[i, 0] != 0 or gaze[i, 1] != 0 or gaze[i, 2] != 0


@njit(cache=True, nogil=True, inline="always")
def _at(plane, row, x, y):  # type: ignore[no-untyped-def]
    return plane[row, 0] + plane[row, 1] * x + plane[row, 2] * y


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy", inline="always")
def _triangle(plane, x, y, eye_x, eye_y):  # type: ignore[no-untyped-def]
    n0, n1, n2 = _at(plane, NORMAL, x, y), _at(plane, NORMAL + 1, x, y), _at(plane, NORMAL + 2, x, y)
    length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2) + 1e-12
    far = 1 / _at(plane, NEAR, x, y)
    red, green, blue = far * _at(plane, TINT, x, y), far * _at(plane, TINT + 1, x, y), far * _at(plane, TINT + 2, x, y)
    if plane[MARKS, 0] != 0:
        dim = 0.4 + 0.6 * abs(n2) / length
        return red * HOLLOW[0] * dim, green * HOLLOW[1] * dim, blue * HOLLOW[2] * dim
    if plane[MARKS, 1] != 0:
        g0, g1, g2 = _at(plane, GAZE, x, y), _at(plane, GAZE + 1, x, y), _at(plane, GAZE + 2, x, y)
        ahead = g2 / (np.sqrt(g0 * g0 + g1 * g1 + g2 * g2) + 1e-12)
        if ahead > PUPIL_COSINE:
            red, green, blue = PUPIL[0], PUPIL[1], PUPIL[2]
        elif ahead > IRIS_COSINE:
            red, green, blue = IRIS[0], IRIS[1], IRIS[2]
    return _lit(n0 / length, n1 / length, n2 / length, eye_x, eye_y, red, green, blue)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy", inline="always")
def _ball(ball, tint, x, y, eye_x, eye_y):  # type: ignore[no-untyped-def]
    n0, n1 = (x - ball[0]) / ball[2], (ball[1] - y) / ball[2]
    n2 = np.sqrt(max(1 - n0 * n0 - n1 * n1, 0.0))
    return _lit(n0, n1, n2, eye_x, eye_y, tint[0], tint[1], tint[2])


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy", inline="always")
def _lit(n0, n1, n2, eye_x, eye_y, red, green, blue):  # type: ignore[no-untyped-def]
    """Light one sample: a wrapped key, fill and sky light, a rim, and a soft highlight."""
    fill = max(n0 * FILL[0] + n1 * FILL[1] + n2 * FILL[2] + 0.25, 0.0)
    even = 0.17 * fill + 0.15 + 0.05 * n1
    away = 1 - max((n0 * eye_x + n1 * eye_y + n2) / np.sqrt(1 + eye_x * eye_x + eye_y * eye_y), 0.0)
    rim = 0.35 * away**4 * max(n0 * RIM[0] + n1 * RIM[1] + n2 * RIM[2] + 0.3, 0.0)
    h0, h1, h2 = KEY[0] + eye_x, KEY[1] + eye_y, KEY[2] + 1
    gleam = 0.055 * max((n0 * h0 + n1 * h1 + n2 * h2) / np.sqrt(h0 * h0 + h1 * h1 + h2 * h2), 0.0) ** 24
    key = n0 * KEY[0] + n1 * KEY[1] + n2 * KEY[2]
    soft0 = 0.80 * max((key + WRAP[0]) / (1 + WRAP[0]), 0.0)
    soft1 = 0.80 * max((key + WRAP[1]) / (1 + WRAP[1]), 0.0)
    soft2 = 0.80 * max((key + WRAP[2]) / (1 + WRAP[2]), 0.0)
    return (
        red * (soft0 + even) + gleam + rim * (0.3 + red),
        green * (soft1 + even) + gleam + rim * (0.3 + green),
        blue * (soft2 + even) + gleam + rim * (0.3 + blue),
    )
