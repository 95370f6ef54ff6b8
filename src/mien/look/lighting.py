"""The compiled loop that lights what the samples of a picture see.

It goes by rows of pixels: first the fragments of a row are gathered, then all are lit in
one loop without branches, which the compiler turns into vector instructions, and then
each pixel gets the mean of its samples.  Samples of one pixel share a fragment as long
as they see one smooth surface, that is triangles with a common corner; so smooth edges
cost little more than rough ones.

The lights and colours of `shade` are compiled in, and the compiled code is cached until
this file changes: after changing them there, save this file too.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.look.kernels import EMPTY, FIRST_BALL, HOLE
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
"""Rows of a triangle's table; at the end whether it is seen from behind, and whether it has an iris."""

EYE, DIM, PLAIN = 6, 8, 9
"""Rows of a fragment's table, after its normal and tint: slopes of the view, dimming, and whether it is not lit."""


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def light_pixels(  # type: ignore[no-untyped-def]
    owner, screen, corners, normals, tint, gaze, balls, ball_tint, middle, focus, backdrop, left, table, picture
):
    """Write the bytes of each pixel's mean light; what the surface sends is dimmed by `left`.

    Args:
        owner: `(fine · H, fine · W)` what each sample sees; `fine` is 1 or 2.
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
    own, shared = np.empty(count, np.int64), np.empty(count, np.int64)
    plane, now = np.empty((11, 3)), -1
    fragments, spot, share = np.empty((10, count * width)), np.empty(count * width, np.int64), np.empty(count * width)
    for row in range(height):
        found = 0
        for column in range(width):
            even = True
            for sample in range(count):
                own[sample] = owner[row * fine + (sample >> 1), column * fine + (sample & 1)]
                even = even and own[sample] == own[0]
            if even and own[0] == EMPTY:
                continue
            for sample in range(1 if even else count):
                who, known = own[sample], 0
                while own[known] != who and not _smooth(own[known], who, corners, screen):
                    known += 1
                if known < sample:
                    shared[sample] = shared[known]
                    share[shared[known]] += 1
                    continue
                x, y = column * fine + (sample & 1) + 0.5, row * fine + (sample >> 1) + 0.5
                fragments[EYE, found], fragments[EYE + 1, found] = (middle[0] - x) / focus, (y - middle[1]) / focus
                fragments[DIM, found], fragments[PLAIN, found] = 1.0, 0.0
                if who >= 0:
                    if who != now:
                        _set_up(plane, who, screen, corners, normals, tint, gaze)
                        now = who
                    _see_triangle(plane, x, y, fragments, found)
                    fragments[DIM, found] = left[row, column]
                elif who <= FIRST_BALL:
                    _see_ball(balls, ball_tint, FIRST_BALL - who, x, y, fragments, found)
                else:
                    fragments[PLAIN, found] = 1.0
                    for band in range(3):
                        fragments[NORMAL + band, found] = 1.0
                        fragments[TINT + band, found] = HOLE_LIGHT[band] if who == HOLE else backdrop[row, band]
                spot[found], share[found], shared[sample] = column, count if even else 1, found
                found += 1
        _light(fragments, found)
        _resolve(fragments, spot, share, found, (len(table) - 1) / (BRIGHTEST * count), table, picture[row])


@njit(cache=True, nogil=True)
def _smooth(a, b, corners, screen):  # type: ignore[no-untyped-def]
    """Return whether two owners are triangles with a common corner, seen from the same side."""
    if a < 0 or b < 0:
        return False
    i, j, k = corners[a, 0], corners[a, 1], corners[a, 2]
    for c in range(3):
        corner = corners[b, c]
        if corner in (i, j, k):
            return _behind(a, corners, screen) == _behind(b, corners, screen)
    return False


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _at(plane, row, x, y):  # type: ignore[no-untyped-def]
    return plane[row, 0] + plane[row, 1] * x + plane[row, 2] * y


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _see_triangle(plane, x, y, fragments, f):  # type: ignore[no-untyped-def]
    far = 1 / _at(plane, NEAR, x, y)
    for row in range(6):
        fragments[NORMAL + row, f] = far * _at(plane, NORMAL + row, x, y)
    if plane[MARKS, 0] != 0:
        n0, n1, n2 = fragments[NORMAL, f], fragments[NORMAL + 1, f], fragments[NORMAL + 2, f]
        dim = 0.4 + 0.6 * abs(n2) / (np.sqrt(n0 * n0 + n1 * n1 + n2 * n2) + 1e-12)
        for band in range(3):
            fragments[TINT + band, f] *= HOLLOW[band] * dim
        fragments[PLAIN, f] = 1.0
    elif plane[MARKS, 1] != 0:
        g0, g1, g2 = _at(plane, GAZE, x, y), _at(plane, GAZE + 1, x, y), _at(plane, GAZE + 2, x, y)
        ahead = g2 / (np.sqrt(g0 * g0 + g1 * g1 + g2 * g2) + 1e-12)
        if ahead > IRIS_COSINE:
            for band in range(3):
                fragments[TINT + band, f] = PUPIL[band] if ahead > PUPIL_COSINE else IRIS[band]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _see_ball(balls, tint, m, x, y, fragments, f):  # type: ignore[no-untyped-def]
    n0, n1 = (x - balls[m, 0]) / balls[m, 2], (balls[m, 1] - y) / balls[m, 2]
    fragments[NORMAL, f], fragments[NORMAL + 1, f] = n0, n1
    fragments[NORMAL + 2, f] = np.sqrt(max(1 - n0 * n0 - n1 * n1, 0.0))
    for band in range(3):
        fragments[TINT + band, f] = tint[m, band]


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _light(fragments, found):  # type: ignore[no-untyped-def]
    """Replace tints by light: a wrapped key, fill and sky light, a rim, and a soft highlight."""
    for f in range(found):
        n0, n1, n2 = fragments[NORMAL, f], fragments[NORMAL + 1, f], fragments[NORMAL + 2, f]
        red, green, blue = fragments[TINT, f], fragments[TINT + 1, f], fragments[TINT + 2, f]
        eye_x, eye_y = fragments[EYE, f], fragments[EYE + 1, f]
        unit = 1 / (np.sqrt(n0 * n0 + n1 * n1 + n2 * n2) + 1e-12)
        n0, n1, n2 = n0 * unit, n1 * unit, n2 * unit
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
        dim, plain = fragments[DIM, f], fragments[PLAIN, f]
        lit = 1 - plain
        fragments[TINT, f] = dim * (red * (plain + lit * (soft0 + even + rim)) + lit * (gleam + 0.3 * rim))
        fragments[TINT + 1, f] = dim * (green * (plain + lit * (soft1 + even + rim)) + lit * (gleam + 0.3 * rim))
        fragments[TINT + 2, f] = dim * (blue * (plain + lit * (soft2 + even + rim)) + lit * (gleam + 0.3 * rim))


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _resolve(fragments, spot, share, found, scale, table, line):  # type: ignore[no-untyped-def]
    """Write the bytes of one row of pixels; the fragments of a pixel follow one another."""
    last = len(table) - 1
    f = 0
    while f < found:
        column = spot[f]
        total0 = total1 = total2 = 0.0
        while f < found and spot[f] == column:
            total0 += share[f] * fragments[TINT, f]
            total1 += share[f] * fragments[TINT + 1, f]
            total2 += share[f] * fragments[TINT + 2, f]
            f += 1
        line[column, 0] = table[min(int(total0 * scale), last)]
        line[column, 1] = table[min(int(total1 * scale), last)]
        line[column, 2] = table[min(int(total2 * scale), last)]
