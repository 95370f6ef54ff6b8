"""A small software rasteriser: triangles and dots to pixels, without display or graphics card.

Made for judging a face: furrows, lip lines and lid creases are darkened as daylight
would, and what shows through an open eye or mouth is dark, also on a mask that has
nothing inside; what shows between horns or through a handle is the background.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mien.core import InputError
from mien.core.arrays import Floats, Ints, floats
from mien.look.camera import Camera
from mien.look.kernels import EMPTY, FIRST_BALL, HOLE, cover, cover_balls, flood, furrows, smooth_steps, sum_normals
from mien.look.lighting import light_pixels
from mien.look.openings import Openings
from mien.look.shade import BACKDROP, BRIGHTEST, SKIN, encoding, linear

Edges = Literal["fine", "quick", "hard"]
Picture = NDArray[np.uint8]
Single = NDArray[np.float32]

MOST_PIXELS = 64_000_000
NEAREST = 1e-6
"""What is nearer to the camera than this is not drawn [m]."""

FURROW_WIDTHS = (0.012, 0.035, 0.12)
"""Scales at which furrows are darkened, as shares of the face: a lip line, an eye socket, the mouth's inside."""

ENCODED = encoding()


@dataclass(frozen=True, eq=False)
class Dots:
    """Small lit balls, such as markers.

    Attributes:
        points: `(M, 3)` centres [m]; NaN where one was not seen.
        colour: `(3,)` or `(M, 3)` sRGB between 0 and 1.
        radius: of each ball [m].
        on_top: whether they show through the surface.
    """

    points: Floats
    colour: tuple[float, float, float] | Floats = (0.10, 0.45, 0.85)
    radius: float = 0.0015
    on_top: bool = False

    def __post_init__(self) -> None:
        points = floats(self.points, (None, 3), "dots", nan=True)
        object.__setattr__(self, "points", points)
        colour = np.broadcast_to(np.asarray(self.colour, dtype=np.float64), points.shape)
        object.__setattr__(self, "colour", floats(colour, points.shape, "dot colours"))


def render(
    vertices: Floats,
    triangles: Ints,
    camera: Camera,
    *,
    size: tuple[int, int] = (512, 512),
    colours: Floats | None = None,
    normals: Floats | None = None,
    gaze: Floats | None = None,
    openings: Openings | None = None,
    dots: Sequence[Dots] = (),
    edges: Edges = "fine",
    crevices: float = 1.0,
) -> Picture:
    """Picture a surface.

    Args:
        vertices: `(N, 3)` positions [m].
        triangles: `(T, 3)` vertex indices, counter-clockwise from outside.
        camera: where it is seen from.
        size: width and height [pixels].
        colours: `(N, 3)` sRGB between 0 and 1 per vertex; skin if None.
        normals: `(N, 3)` unit normals; computed if None.
        gaze: `(N, 3)` direction from its eye's centre at rest, on eyeballs that need an iris painted; elsewhere zero.
        openings: the surface's rims; found if None.
        dots: markers to draw.
        edges: `fine` takes four samples a pixel, `quick` one and smooths its steps (with coarser furrows), `hard` just one.
        crevices: how strongly furrows, lip lines and lid creases are darkened; 0 leaves them.

    Returns:
        `(height, width, 3)` sRGB bytes.

    Raises:
        InputError: the size is not positive or larger than memory allows, or shapes disagree.
    """
    width, height = _checked_size(size)
    vertices = floats(vertices, (None, 3), "vertices to render")
    if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(vertices)):
        raise InputError(f"triangles refer to vertices beyond the {len(vertices)} given.")
    shape = vertices.shape
    tint = linear(np.broadcast_to(SKIN, shape) if colours is None else floats(colours, shape, "vertex colours"))
    normals = vertex_normals(vertices, triangles) if normals is None else floats(normals, shape, "vertex normals")

    towards = np.zeros(shape) if gaze is None else floats(gaze, shape, "gaze directions")

    fine = 2 if edges == "fine" else 1
    focus = camera.pixels_per_slope(fine * height)
    screen = _to_screen(camera.seen(vertices), focus, (fine * height, fine * width))
    balls, ball_tint, on_top = _balls(dots, camera, focus, (fine * height, fine * width))
    rows, columns = _window(screen, balls, size, fine)
    backdrop = _backdrop(height)
    picture = np.empty((height, width, 3), np.uint8)
    picture[:] = _bytes(backdrop)[:, None]
    corner = fine * np.array([columns.start, rows.start])
    screen[:, :2] -= corner
    balls[:, :2] -= corner

    depth = np.zeros((fine * (rows.stop - rows.start), fine * (columns.stop - columns.start)), np.float32)
    owner = np.full(depth.shape, HOLE, np.int32)
    corners = np.ascontiguousarray(triangles, dtype=np.int32)
    cover(screen, corners, depth, owner)
    flood(owner)
    if (owner == HOLE).any():
        rims = Openings.of(triangles, np.arange(len(vertices))) if openings is None else openings
        closed, lids = rims.lids(vertices)
        behind = _to_screen(camera.seen(closed), focus, (fine * height, fine * width))
        behind[:, :2] -= corner
        _leave_open(owner, behind, lids)
    left = _furrows(_nearest(depth, fine), crevices, 2 if edges == "quick" else 1)
    _cover_balls(balls, on_top, depth, owner)
    middle = fine * np.array([width, height]) / 2 - corner
    light_pixels(
        owner,
        screen,
        corners,
        normals @ camera.axes.T,
        tint,
        towards,
        balls,
        ball_tint,
        middle,
        focus,
        backdrop[rows],
        left,
        ENCODED,
        picture[rows, columns],
    )
    if edges == "quick":
        smooth_steps(picture[rows, columns].copy(), owner, picture[rows, columns])
    return picture


def vertex_normals(vertices: Floats, triangles: Ints, same: Ints | None = None) -> Floats:
    """Return unit normals `(N, 3)`, the mean over the triangles around each vertex by area.

    Args:
        vertices: `(N, 3)` positions.
        triangles: `(T, 3)` vertex indices.
        same: `(N,)` the vertex each one shares its normal with, so that seams do not show; itself if None.
    """
    joined = np.arange(len(vertices)) if same is None else same
    return np.asarray(sum_normals(np.ascontiguousarray(vertices), np.ascontiguousarray(triangles), joined))


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    width, height = size
    if width < 1 or height < 1 or width * height > MOST_PIXELS:
        raise InputError(
            f"a picture of {width} × {height} pixels cannot be made; choose 1 to {MOST_PIXELS:,} pixels in all."
        )
    return int(width), int(height)


def _to_screen(seen: Floats, focus: float, shape: tuple[int, ...]) -> Floats:
    """Return `(N, 3)`: column, row, and 1/distance, which is 0 behind the camera."""
    height, width = shape
    distance = -seen[:, 2]
    inverse = np.where(distance > NEAREST, 1 / np.maximum(distance, NEAREST), 0)
    columns = width / 2 + focus * seen[:, 0] * inverse
    rows = height / 2 - focus * seen[:, 1] * inverse
    return np.stack([columns, rows, inverse], axis=1)


def _backdrop(height: int) -> Floats:
    """Return the background's `(height, 3)` linear colours, lighter above."""
    down = np.linspace(0, 1, height)[:, None]
    return linear(BACKDROP[0] * (1 - down) + BACKDROP[1] * down)


def _bytes(light: Floats) -> Picture:
    """Return sRGB bytes for linear light."""
    return np.asarray(ENCODED[np.minimum((light / BRIGHTEST * (len(ENCODED) - 1)).astype(int), len(ENCODED) - 1)])


def _window(screen: Floats, balls: Floats, size: tuple[int, int], fine: int) -> tuple[slice, slice]:
    """Return the rows and columns of pixels outside which there is nothing but background."""
    width, height = size
    if (screen[:, 2] == 0).any():
        return slice(0, height), slice(0, width)
    balls = balls[np.isfinite(balls[:, 2])]
    low = np.concatenate([screen[:, :2], balls[:, :2] - balls[:, 2:3]]).min(axis=0) / fine - 1
    high = np.concatenate([screen[:, :2], balls[:, :2] + balls[:, 2:3]]).max(axis=0) / fine + 2
    left, top = np.clip(low, 0, [width - 1, height - 1]).astype(int)
    right, bottom = np.clip(high, [left + 1, top + 1], [width, height]).astype(int)
    return slice(int(top), int(bottom)), slice(int(left), int(right))


def _balls(
    dots: Sequence[Dots], camera: Camera, focus: float, shape: tuple[int, int]
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return each dot's place, colour, and whether it shows through the surface.

    A place is `(5,)`: column, row and radius [samples], distance and radius [m].
    """
    height, width = shape
    placed, colours = [np.empty((0, 5))], [np.empty((0, 3))]
    for group in dots:
        seen = camera.seen(group.points)
        distance = np.where(-seen[:, 2] > group.radius, -seen[:, 2], np.nan)
        scale = focus / distance
        columns, rows = width / 2 + seen[:, 0] * scale, height / 2 - seen[:, 1] * scale
        radius = np.full(len(seen), group.radius)
        placed.append(np.stack([columns, rows, radius * scale, distance, radius], axis=1))
        colours.append(np.asarray(group.colour))
    on_top = np.repeat([group.on_top for group in dots], [len(group.points) for group in dots]).astype(bool)
    return np.concatenate(placed), linear(np.concatenate(colours)), on_top


def _cover_balls(balls: Floats, on_top: NDArray[np.bool_], depth: Single, owner: NDArray[np.int32]) -> None:
    """Cover samples with dots, those in the scene first."""
    for shown, front in ((~on_top, depth), (on_top, np.zeros_like(depth) if on_top.any() else depth)):
        if shown.any():
            cover_balls(np.where(shown[:, None], balls, np.nan), FIRST_BALL, front, owner)


def _leave_open(owner: NDArray[np.int32], screen: Floats, lids: Ints) -> None:
    """Make `EMPTY` of the holes that no lid closes: one sees past the surface there, not into it."""
    behind = np.full(owner.shape, EMPTY, np.int32)
    cover(screen, np.ascontiguousarray(lids, dtype=np.int32), np.zeros(owner.shape, np.float32), behind)
    owner[(owner == HOLE) & (behind == EMPTY)] = EMPTY


def _nearest(depth: Single, fine: int) -> Single:
    """Return the nearest of each pixel's samples."""
    if fine == 1:
        return depth
    nearest = depth[::fine, ::fine]
    for row in range(fine):
        for column in range(fine):
            nearest = np.maximum(nearest, depth[row::fine, column::fine])
    return nearest


def _furrows(depth: Single, strength: float, step: int) -> Single:
    """Return how much light is left in furrows (Luft et al. 2006: unsharp masking of the depth buffer).

    Args:
        depth: `(H, W)` 1/distance, 0 where nothing is seen.
        strength: how dark they get.
        step: how many pixels apart it is worked out.
    """
    height, width = depth.shape
    coarse = np.ascontiguousarray(depth[::step, ::step])
    left = np.ones(coarse.shape, np.float32)
    count = int(np.count_nonzero(coarse))
    if not (strength > 0 and count):
        return np.ones(depth.shape, np.float32)
    span = np.sqrt(count)
    reaches = np.array([max(1, round(share * span / 2)) for share in FURROW_WIDTHS])
    furrows(coarse, reaches, span / (2 * float(coarse.sum(dtype=np.float64)) / count), 2 * strength, left)
    left = left.repeat(step, axis=0).repeat(step, axis=1)[:height, :width]
    return np.asarray(ndimage.uniform_filter(left, 3))  # along outlines neighbouring pixels see different surfaces
