"""The compiled inner loops that find what each sample of a picture sees.

Depth is kept as 1/distance, which is linear on the picture and larger when nearer.
None of them holds Python's lock, so several pictures can be made at once.
"""

from __future__ import annotations

import numpy as np
from numba import njit

EMPTY, HOLE, FIRST_BALL = -1, -2, -3
"""What owns a sample if no triangle does: nothing, an enclosed hole, ball 0 (then -4, -5, …)."""


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _span(value, slope, low, high):  # type: ignore[no-untyped-def]
    """Narrow `low … high` to where `value + slope · column` is not negative, but for rounding."""
    if slope > 0:
        return max(low, -value / slope - 1e-9), high
    if slope < 0:
        return low, min(high, -value / slope + 1e-9)
    return (low, high) if value >= 0 else (1.0, 0.0)


@njit(cache=True, nogil=True)
def flood(owner):  # type: ignore[no-untyped-def]
    """Make `EMPTY` of the holes that reach the border: sweep there and back until nothing changes."""
    height, width = owner.shape
    changed = True
    while changed:
        changed = False
        for row in range(height):
            for column in range(width):
                if owner[row, column] == HOLE and (
                    row == 0
                    or column == 0
                    or row == height - 1
                    or column == width - 1
                    or owner[row - 1, column] == EMPTY
                    or owner[row, column - 1] == EMPTY
                ):
                    owner[row, column] = EMPTY
        for row in range(height - 2, 0, -1):
            for column in range(width - 2, 0, -1):
                if owner[row, column] == HOLE and (owner[row + 1, column] == EMPTY or owner[row, column + 1] == EMPTY):
                    owner[row, column] = EMPTY
                    changed = True


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
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
            if deeper > 0:
                left[row, column] = np.exp(-strength * deeper)


@njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def smooth_steps(sharp, owner, out):  # type: ignore[no-untyped-def]
    """Average along edges, where the picture changes abruptly across them (after Lottes 2009, FXAA).

    Args:
        sharp: `(H, W, 3)` the picture with one sample a pixel.
        owner: `(H, W)` what each sample sees; pixels amid one triangle or background stay.
        out: `(H, W, 3)`, written where there is an edge.
    """
    height, width = owner.shape
    for row in range(1, height - 1):
        for column in range(1, width - 1):
            here = owner[row, column]
            if (
                owner[row - 1, column] == here
                and owner[row + 1, column] == here
                and owner[row, column - 1] == here
                and owner[row, column + 1] == here
            ):
                continue
            up, down = int(sharp[row - 1, column, 1]), int(sharp[row + 1, column, 1])
            before, after = int(sharp[row, column - 1, 1]), int(sharp[row, column + 1, 1])
            middle = int(sharp[row, column, 1])
            contrast = max(up, down, before, after, middle) - min(up, down, before, after, middle)
            if contrast < 16:
                continue
            a, b = int(sharp[row - 1, column - 1, 1]), int(sharp[row - 1, column + 1, 1])
            c, d = int(sharp[row + 1, column - 1, 1]), int(sharp[row + 1, column + 1, 1])
            along_x, along_y = float(c + d - a - b + 2 * (down - up)), float(a + c - b - d + 2 * (before - after))
            largest = max(abs(along_x), abs(along_y)) + 1e-3
            along_x, along_y = along_x / largest, along_y / largest
            for band in range(3):
                near = _between(sharp, row + 0.5 * along_y, column + 0.5 * along_x, band)
                near += _between(sharp, row - 0.5 * along_y, column - 0.5 * along_x, band)
                far = _between(sharp, row + 1.5 * along_y, column + 1.5 * along_x, band)
                far += _between(sharp, row - 1.5 * along_y, column - 1.5 * along_x, band)
                out[row, column, band] = int(0.25 * (near + far) + 0.5)


@njit(cache=True, nogil=True, fastmath=True)
def _between(picture, row, column, band):  # type: ignore[no-untyped-def]
    """Return the value between four pixels."""
    row = min(max(row, 0.0), picture.shape[0] - 1.001)
    column = min(max(column, 0.0), picture.shape[1] - 1.001)
    r, c = int(row), int(column)
    down, right = row - r, column - c
    top = picture[r, c, band] * (1 - right) + picture[r, c + 1, band] * right
    bottom = picture[r + 1, c, band] * (1 - right) + picture[r + 1, c + 1, band] * right
    return top * (1 - down) + bottom * down
