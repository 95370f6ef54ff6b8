"""The compiled inner loops of the rasteriser.

The first pass finds what each sample sees; the second lights it.  So a sample is lit
once however many triangles lie behind one another, and samples of one triangle within
a pixel share their light: smooth edges cost little where triangles are large.  Depth
is kept as 1/distance, which is linear on the picture and larger when nearer.

The lights and colours of `shade` are compiled in, and the compiled code is cached until
this file changes: after changing them there, save this file too.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.look.shade import FILL, HOLE_LIGHT, HOLLOW, IRIS, IRIS_COSINE, KEY, PUPIL, PUPIL_COSINE, RIM, WRAP

EMPTY, HOLE, FIRST_BALL = -1, -2, -3
"""What owns a sample if no triangle does: nothing, an enclosed hole, ball 0 (then -4, -5, …)."""


@njit(cache=True, fastmath=True, error_model="numpy")
def cover(screen, corners, depth, owner):  # type: ignore[no-untyped-def]
    """Write the nearest triangle of every sample, and its 1/distance."""
    height, width = depth.shape
    for t in range(len(corners)):
        i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
        ax, ay, a = screen[i, 0], screen[i, 1], screen[i, 2]
        bx, by, b = screen[j, 0], screen[j, 1], screen[j, 2]
        cx, cy, c = screen[k, 0], screen[k, 1], screen[k, 2]
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area == 0 or a == 0 or b == 0 or c == 0:
            continue
        left = int(np.ceil(max(min(ax, bx, cx) - 0.5, 0.0)))
        right = int(np.floor(min(max(ax, bx, cx) - 0.5, width - 1.0)))
        top = int(np.ceil(max(min(ay, by, cy) - 0.5, 0.0)))
        bottom = int(np.floor(min(max(ay, by, cy) - 0.5, height - 1.0)))
        u_x, u_y = (by - cy) / area, (cx - bx) / area
        v_x, v_y = (cy - ay) / area, (ax - cx) / area
        for row in range(top, bottom + 1):
            x, y = 0.5 - cx, row + 0.5 - cy
            u, v = u_x * x + u_y * y, v_x * x + v_y * y
            low, high = _span(u, u_x, float(left), float(right))
            low, high = _span(v, v_x, low, high)
            low, high = _span(1 - u - v, -u_x - v_x, low, high)
            if low > high:
                continue
            near = u * (a - c) + v * (b - c) + c
            slope = u_x * (a - c) + v_x * (b - c)
            for column in range(int(np.ceil(low)), int(np.floor(high)) + 1):
                here = near + slope * column
                if here > depth[row, column]:
                    depth[row, column] = here
                    owner[row, column] = t


@njit(cache=True, error_model="numpy", inline="always")
def _span(value, slope, low, high):  # type: ignore[no-untyped-def]
    """Narrow `low … high` to where `value + slope · column` is not negative, but for rounding."""
    if slope > 0:
        return max(low, -value / slope - 1e-9), high
    if slope < 0:
        return low, min(high, -value / slope + 1e-9)
    return (low, high) if value >= 0 else (1.0, 0.0)


@njit(cache=True, error_model="numpy")
def cover_balls(balls, first, depth, owner):  # type: ignore[no-untyped-def]
    """Write the nearest ball of every sample; ball `m` of `(M, 5)` owns its samples as `first - m`."""
    height, width = depth.shape
    for m in range(len(balls)):
        x, y, spread, distance, radius = balls[m]
        if not (spread > 0 and x + spread > 0 and y + spread > 0 and x - spread < width and y - spread < height):
            continue  # outside the picture, or not seen (NaN)
        for row in range(max(0, int(y - spread)), min(height, int(y + spread) + 1)):
            for column in range(max(0, int(x - spread)), min(width, int(x + spread) + 1)):
                square = ((column + 0.5 - x) ** 2 + (row + 0.5 - y) ** 2) / spread**2
                if square > 1:
                    continue
                near = 1 / (distance - radius * np.sqrt(1 - square))
                if near > depth[row, column]:
                    depth[row, column] = near
                    owner[row, column] = first - m


@njit(cache=True, fastmath=True, error_model="numpy")
def light_pixels(owner, screen, corners, normals, tint, gaze, balls, ball_tint, focus, backdrop, left, light):  # type: ignore[no-untyped-def]
    """Write the mean light of each pixel's samples; what the surface sends is dimmed by `left`."""
    height, width = light.shape[0], light.shape[1]
    fine = len(owner) // height
    count = fine * fine
    own, lit = np.empty(count, np.int64), np.empty((count, 3))
    middle_x, middle_y = 0.5 * owner.shape[1], 0.5 * owner.shape[0]
    for row in range(height):
        for column in range(width):
            total0 = total1 = total2 = 0.0
            for sample in range(count):
                x, y = column * fine + sample % fine, row * fine + sample // fine
                who = owner[y, x]
                own[sample] = who
                known = 0
                while own[known] != who:
                    known += 1
                if known == sample:
                    eye_x, eye_y = (middle_x - x - 0.5) / focus, (y + 0.5 - middle_y) / focus
                    if who >= 0:
                        red, green, blue = _triangle(
                            who, x + 0.5, y + 0.5, eye_x, eye_y, screen, corners, normals, tint, gaze
                        )
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
            light[row, column, 0] = total0 / count
            light[row, column, 1] = total1 / count
            light[row, column, 2] = total2 / count


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _triangle(t, x, y, eye_x, eye_y, screen, corners, normals, tint, gaze):  # type: ignore[no-untyped-def]
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    ax, ay, bx, by = screen[i, 0], screen[i, 1], screen[j, 0], screen[j, 1]
    cx, cy = screen[k, 0], screen[k, 1]
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    u = ((by - cy) * (x - cx) + (cx - bx) * (y - cy)) / area
    v = ((cy - ay) * (x - cx) + (ax - cx) * (y - cy)) / area
    w = (1 - u - v) * screen[k, 2]
    u, v = u * screen[i, 2], v * screen[j, 2]
    whole = u + v + w
    u, v, w = u / whole, v / whole, w / whole
    n0 = u * normals[i, 0] + v * normals[j, 0] + w * normals[k, 0]
    n1 = u * normals[i, 1] + v * normals[j, 1] + w * normals[k, 1]
    n2 = u * normals[i, 2] + v * normals[j, 2] + w * normals[k, 2]
    length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2) + 1e-12
    red = u * tint[i, 0] + v * tint[j, 0] + w * tint[k, 0]
    green = u * tint[i, 1] + v * tint[j, 1] + w * tint[k, 1]
    blue = u * tint[i, 2] + v * tint[j, 2] + w * tint[k, 2]
    if area > 0:  # rows count downwards, so this one is seen from behind
        dim = 0.4 + 0.6 * abs(n2) / length
        return red * HOLLOW[0] * dim, green * HOLLOW[1] * dim, blue * HOLLOW[2] * dim
    if gaze[i, 0] != 0 or gaze[i, 1] != 0 or gaze[i, 2] != 0:
        g0 = u * gaze[i, 0] + v * gaze[j, 0] + w * gaze[k, 0]
        g1 = u * gaze[i, 1] + v * gaze[j, 1] + w * gaze[k, 1]
        g2 = u * gaze[i, 2] + v * gaze[j, 2] + w * gaze[k, 2]
        ahead = g2 / (np.sqrt(g0 * g0 + g1 * g1 + g2 * g2) + 1e-12)
        if ahead > PUPIL_COSINE:
            red, green, blue = PUPIL[0], PUPIL[1], PUPIL[2]
        elif ahead > IRIS_COSINE:
            red, green, blue = IRIS[0], IRIS[1], IRIS[2]
    return _lit(n0 / length, n1 / length, n2 / length, eye_x, eye_y, red, green, blue)


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
def _ball(ball, tint, x, y, eye_x, eye_y):  # type: ignore[no-untyped-def]
    n0, n1 = (x + 0.5 - ball[0]) / ball[2], (ball[1] - y - 0.5) / ball[2]
    n2 = np.sqrt(max(1 - n0 * n0 - n1 * n1, 0.0))
    return _lit(n0, n1, n2, eye_x, eye_y, tint[0], tint[1], tint[2])


@njit(cache=True, fastmath=True, error_model="numpy", inline="always")
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


@njit(cache=True, error_model="numpy")
def sum_normals(vertices, triangles, joined):  # type: ignore[no-untyped-def]
    """Return unit normals `(N, 3)`, summed over the triangles around each group of joined vertices."""
    total = np.zeros_like(vertices)
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        u0, u1, u2 = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
        v0, v1, v2 = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2] - vertices[a, 2]
        for i in (joined[a], joined[b], joined[c]):
            total[i, 0] += u1 * v2 - u2 * v1
            total[i, 1] += u2 * v0 - u0 * v2
            total[i, 2] += u0 * v1 - u1 * v0
    out = np.zeros_like(vertices)
    for i in range(len(vertices)):
        x, y, z = total[joined[i]]
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0:
            out[i, 0], out[i, 1], out[i, 2] = x / length, y / length, z / length
        else:
            out[i, 2] = 1.0
    return out


@njit(cache=True, error_model="numpy")
def furrows(depth, reaches, slope, strength, left):  # type: ignore[no-untyped-def]
    """Write how much light is left where the surface lies deeper than the mean of its surroundings.

    Means over squares of several sizes come from one summed-area table each of depth and cover.
    """
    height, width = depth.shape
    sums, cover = np.zeros((height + 1, width + 1)), np.zeros((height + 1, width + 1), np.int32)
    for row in range(height):
        along, seen = 0.0, 0
        for column in range(width):
            along += depth[row, column]
            seen += depth[row, column] > 0
            sums[row + 1, column + 1] = sums[row, column + 1] + along
            cover[row + 1, column + 1] = cover[row, column + 1] + seen
    for row in range(height):
        for column in range(width):
            if depth[row, column] == 0:
                continue
            deeper = 0.0
            for reach in reaches:
                top, bottom = max(row - reach, 0), min(row + reach + 1, height)
                near, far = max(column - reach, 0), min(column + reach + 1, width)
                total = sums[bottom, far] - sums[top, far] - sums[bottom, near] + sums[top, near]
                count = cover[bottom, far] - cover[top, far] - cover[bottom, near] + cover[top, near]
                rise = (total / count - depth[row, column]) * slope / reach
                deeper += min(max(rise, 0.0), 0.25)
            left[row, column] = np.exp(-strength * deeper)


@njit(cache=True, error_model="numpy")
def encode(light, table, top, out):  # type: ignore[no-untyped-def]
    """Write bytes for light through a table over 0 … `top`."""
    last = len(table) - 1
    for row in range(light.shape[0]):
        for column in range(light.shape[1]):
            for band in range(3):
                out[row, column, band] = table[min(int(light[row, column, band] / top * last), last)]
