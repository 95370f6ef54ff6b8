"""Faces, lines and colours for the figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mien.core import Rig
from mien.core.arrays import Floats, Ints
from mien.look.camera import Camera, View, frame_face
from mien.look.portrait import Portrait
from mien.look.raster import Dots

GREY = np.array([0.82, 0.82, 0.84])
BLUE, ORANGE = (0.18, 0.44, 0.71), (0.86, 0.42, 0.13)
HUES = ((0.80, 0.12, 0.16), (0.95, 0.80, 0.30), (0.92, 0.92, 0.88), (0.35, 0.62, 0.85), (0.10, 0.20, 0.60))
"""From 0 to 1: red to blue, as in the paper's figure 11."""
AROUND = 1.5
"""A portrait reaches this many times as far from the middle of the face as its landmarks do."""


def camera(rig: Rig, view: View = "front", names: Iterable[str] | None = None, around: float = AROUND) -> Camera:
    """Frame a face by its landmarks, so that heads of any extent are seen alike."""
    chosen = rig.landmarks.values() if names is None else [rig.landmarks[name] for name in names]
    points = np.concatenate([point.of(rig.neutral.vertices) for point in chosen])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return frame_face(middle + around * (points - middle), view, margin=0.0)


def sitter(rig: Rig, view: View = "front", size: int = 240, at: Camera | None = None) -> Portrait:
    """Make a portrait framed by the landmarks."""
    return Portrait.of(rig, view, size=(size, size), camera=at or camera(rig, view))


def line(points: Floats, step: float) -> Floats:
    """Return points `(M, 3)` along a polyline, no farther apart than `step`."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    counts = np.maximum(np.ceil(lengths / step).astype(int), 1)
    parts = [a + (b - a) * np.arange(n)[:, None] / n for a, b, n in zip(points[:-1], points[1:], counts, strict=True)]
    return np.concatenate([*parts, points[-1:]])


def lines(
    strokes: Sequence[Floats], colours: Sequence[Sequence[float]] | Floats, radius: float, *, on_top: bool = False
) -> Dots:
    """Return polylines as strings of small balls."""
    strings = [line(stroke, radius) for stroke in strokes]
    tint = np.concatenate([np.tile(colour, (len(s), 1)) for s, colour in zip(strings, colours, strict=True)])
    return Dots(np.concatenate(strings), tint, radius, on_top)


def wires(vertices: Floats, triangles: Ints, radius: float, colour: tuple[float, float, float] = BLUE) -> Dots:
    """Return the edges of a mesh."""
    edges = np.unique(np.sort(np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1), axis=0)
    return lines([vertices[edge] for edge in edges], [colour] * len(edges), radius)


def heat(values: Floats) -> Floats:
    """Return sRGB `(M, 3)` of values between 0 and 1."""
    stops = np.linspace(0, 1, len(HUES))
    return np.stack([np.interp(values, stops, [hue[c] for hue in HUES]) for c in range(3)], axis=1)


def distinct(count: int) -> Floats:
    """Return `count` sRGB colours that neighbours can be told apart by: hues a golden angle apart, two shades."""
    turn = (np.arange(count) * 0.381966) % 1
    phase = 2 * np.pi * (turn[:, None] - np.array([0, 1 / 3, 2 / 3]))
    shade = np.where(np.arange(count) % 2, 0.62, 0.85)[:, None]
    return np.asarray(np.clip(shade * (0.68 + 0.42 * np.cos(phase)), 0, 1))
