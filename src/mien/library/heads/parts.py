"""What a head carries that is not skin: swept horns, ears, beards, brows, teeth and tongues, each a closed piece."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from mien.core.arrays import Floats
from mien.library.heads.clay import cast
from mien.library.modelling.half import Half
from mien.library.modelling.solids import Point, Solids

Knot = tuple[Point, float, float]
"""A place on a sweep's path and the half width and half thickness of its section [cm]."""


def sweep(
    name: str,
    knots: tuple[Knot, ...],
    *,
    up: Point = (0, 1, 0),
    rings: int = 14,
    around: int = 10,
    ripple: tuple[float, float] = (0.0, 0.0),
    cup: float = 0.0,
) -> Callable[[Half, Solids], None]:
    """Return a part swept along a path on the left: closed at both ends.

    Args:
        name: its group, ending in `_left`.
        knots: path and sections; the width lies across the path and across `up`.
        up: the direction the thickness lies along, made square to the path.
        rings, around: numbers of sections, and of vertices around each.
        ripple: how deep and how many rings of growth there are.
        cup: by how much of its width the section's middle sinks along `up`, as an ear's does.
    """

    def add(half: Half, _: Solids) -> None:
        path, sizes = _along(knots, rings)
        wave = 1 + ripple[0] * np.cos(2 * np.pi * ripple[1] * np.linspace(0, 1, rings))
        _tube(half, path, sizes * wave[:, None], np.array(up, dtype=float), around, cup, (name,))

    return add


def midline_sweep(
    name: str, knots: tuple[Knot, ...], *, up: Point = (0, 1, 0), rings: int = 8, around: int = 13
) -> Callable[[Half, Solids], None]:
    """Return a part swept along a path in the midline: a beard, a tongue. Only its left half is laid."""

    def add(half: Half, _: Solids) -> None:
        path, sizes = _along(knots, rings)
        forward, across, over = _frames(path, np.array(up, dtype=float))
        turn = np.linspace(-np.pi / 2, np.pi / 2, around)
        cosine, sine = np.cos(turn), np.sin(turn)
        cosine[[0, -1]] = 0
        sections = []
        for p, o, (wide, thick) in zip(path, over, sizes, strict=True):
            section = p + np.outer(cosine * wide, [1.0, 0.0, 0.0]) + np.outer(sine * thick, o)
            section[[0, -1], 0] = 0
            sections.append(half.add(section, name))
        leftward = across[0, 0] > 0
        for first, second in pairwise(sections):
            a, b = (first, second) if leftward else (second, first)
            half.strip(a, b, closed=False)
        for ring, end, along, flip in (
            (sections[0], path[0], -forward[0], leftward),
            (sections[-1], path[-1], forward[-1], not leftward),
        ):
            tip = int(half.add((end + 0.3 * sizes[0, 1] * along * [0, 1, 1])[None], name)[0])
            half.fan(ring if flip else ring[::-1], tip, closed=False)

    return add


def brow(
    inner: tuple[float, float], peak: tuple[float, float], outer: tuple[float, float], tall: float, thick: float
) -> Callable[[Half, Solids], None]:
    """Return an eyebrow that lies on the skin through three points of the front view."""

    def add(half: Half, solids: Solids) -> None:
        t = np.linspace(0, 1, 13)[:, None]
        middle = 2 * np.array(peak) - 0.5 * (np.array(inner) + outer)
        flat = (1 - t) ** 2 * inner + 2 * t * (1 - t) * middle + t**2 * outer
        origins = np.column_stack([flat, np.full(13, 20.0)])
        path = cast(solids, origins, np.broadcast_to([0.0, 0.0, -1.0], origins.shape))
        taper = np.sqrt(np.clip(1.02 - (1.35 * t[:, 0] - 0.5) ** 2 / 0.75, 0.02, 1))
        _tube(half, path, np.outer(taper, [tall, thick]), np.array([0.0, 0.0, 1.0]), 8, 0.0, ("brow_left",))

    return add


def teeth(wide: float, tall: float, front: float, deep: float, height: float) -> Callable[[Half, Solids], None]:
    """Return the left halves of an upper and a lower arch of teeth."""

    def add(half: Half, _: Solids) -> None:
        turn = np.linspace(0, 1.3, 11)
        arch = np.stack([wide * np.sin(turn), 0 * turn, front - deep * (1 - np.cos(turn))], axis=1)
        behind = arch * [0.92, 1, 1] - [0, 0, 0.35]
        for name, row, lift in (("teeth_upper", arch, 0.2), ("teeth_lower", behind, -0.7)):
            path = row + np.array([0, height + lift * tall, 0])
            path[0, 0] = 0
            _tube(
                half,
                path,
                np.tile([tall / 2, 0.2], (11, 1)),
                np.array([0.0, 0.0, 1.0]),
                8,
                0.0,
                (name, "teeth"),
                mirror=True,
            )

    return add


def _along(knots: tuple[Knot, ...], rings: int) -> tuple[Floats, Floats]:
    places = np.array([place for place, _, _ in knots], dtype=float)
    sizes = np.array([(wide, thick) for _, wide, thick in knots])
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    at = np.linspace(0, s[-1], rings)
    return CubicSpline(s, places)(at), np.maximum(CubicSpline(s, sizes)(at), 0.02)


def _frames(path: Floats, up: Floats) -> tuple[Floats, Floats, Floats]:
    """Return directions along a path, across it, and over it."""
    forward = np.gradient(path, axis=0)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    across = np.cross(forward, up)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return forward, across, np.cross(across, forward)


def _tube(
    half: Half,
    path: Floats,
    sizes: Floats,
    up: Floats,
    around: int,
    cup: float,
    groups: tuple[str, ...],
    *,
    mirror: bool = False,
) -> None:
    """Sweep ellipses of half widths and thicknesses `sizes` along a path and close the ends; open where it meets its mirror image."""
    forward, across, over = _frames(path, up)
    if mirror:
        across[0], over[0] = [0, -1, 0], [0, 0, 1]
    turn = np.arange(around) * 2 * np.pi / around
    rings = []
    for p, a, o, (wide, thick) in zip(path, across, over, sizes, strict=True):
        sunk = -cup * wide * np.sin(turn) ** 2
        ring = p + np.outer(np.cos(turn) * wide, a) + np.outer(np.sin(turn) * thick + sunk, o)
        rings.append(half.add(ring, *groups))
    for first, second in pairwise(rings):
        half.strip(first, second, closed=True)
    ends = [(rings[-1], path[-1] + 0.3 * sizes[-1, 1] * forward[-1])]
    if not mirror:
        ends.append((rings[0][::-1], path[0] - 0.3 * sizes[0, 1] * forward[0]))
    for ring, tip in ends:
        half.fan(ring[::-1], int(half.add(tip[None], *groups)[0]), closed=True)
