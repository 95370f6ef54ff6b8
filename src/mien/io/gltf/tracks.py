"""Animation curves: key frames, and their values at any time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.io.gltf.accessors import floats_at
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields
from mien.io.gltf.transforms import slerped

USUAL_RATES = (30.0, 24.0, 25.0, 60.0, 48.0, 50.0, 100.0, 120.0, 30 / 1.001, 24 / 1.001, 60 / 1.001)
"""Frame rates to try on keys that are not evenly spaced, the likeliest first."""

SLOWEST = 12.0
"""Evenly spaced keys further apart than this [1/s] are key poses, not frames."""

JITTER = 2e-3
"""How far [frames] a time may be from a key and still mean it, besides the rounding of single precision."""


@dataclass(frozen=True, eq=False)
class Track:
    """One animated property.

    Attributes:
        times: `(n,)` key times [s], never decreasing.
        values: `(n, C)` the keys.
        tangents: `(n, 2, C)` incoming and outgoing tangents, for cubic splines.
        interpolation: `LINEAR`, `STEP` or `CUBICSPLINE`.
        spherical: whether the values are unit quaternions.
    """

    times: Floats
    values: Floats
    tangents: Floats | None
    interpolation: str
    spherical: bool = False

    def at(self, times: Floats, fps: float) -> Floats:
        """Return `(F, C)` values at `times`; before the first and after the last key they hold."""
        times = self._snapped(np.clip(times, self.times[0], self.times[-1]), fps)
        left = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, max(len(self.times) - 2, 0))
        right = np.minimum(left + 1, len(self.times) - 1)
        span = (self.times[right] - self.times[left])[:, None]
        u = (times - self.times[left])[:, None] / np.where(span > 0, span, 1)
        a, b = self.values[left], self.values[right]
        if self.interpolation == "STEP":
            return np.where(u >= 1, b, a)
        if self.tangents is not None:
            curve = _hermite(a, b, span * self.tangents[left, 1], span * self.tangents[right, 0], u)
            return _unit(curve) if self.spherical else curve
        return slerped(a, b, u) if self.spherical else a + u * (b - a)

    def _snapped(self, times: Floats, fps: float) -> Floats:
        """Move times onto the keys they mean, so that rounding does not blend a frame with its neighbour."""
        right = np.clip(np.searchsorted(self.times, times), 1, max(len(self.times) - 1, 1))
        near = self.times[np.minimum(right, len(self.times) - 1)]
        before = self.times[right - 1]
        near = np.where(np.abs(before - times) < np.abs(near - times), before, near)
        return np.where(np.abs(near - times) < JITTER / fps + rounding(self.times), near, times)


def _hermite(a: Floats, b: Floats, leaving: Floats, arriving: Floats, u: Floats) -> Floats:
    v = 1 - u
    return a * v * v * (1 + 2 * u) + leaving * u * v * v + b * u * u * (3 - 2 * u) - arriving * u * u * v


def _unit(q: Floats) -> Floats:
    return np.asarray(q / np.maximum(np.linalg.norm(q, axis=1, keepdims=True), np.finfo(float).tiny))


def read_track(document: Document, sampler: Fields, kind: str, width: int) -> Track:
    """Return the curve of an animation sampler.

    Args:
        document: the file.
        sampler: the sampler.
        kind: the type of its output: `SCALAR` for weights, else `VEC3` or `VEC4`.
        width: numbers per key: morph targets, or 3 or 4.

    Raises:
        FileError: times decrease, or there are too few or too many values.
    """
    times = floats_at(document, sampler.integer("input"), sampler, "SCALAR")[:, 0]
    if (np.diff(times) < 0).any():
        raise sampler.error(f"has key times that go back, first after key {int(np.argmax(np.diff(times) < 0))}")
    interpolation = sampler.text("interpolation", "LINEAR")
    if interpolation not in {"LINEAR", "STEP", "CUBICSPLINE"}:
        raise sampler.error(f"has the unknown interpolation {interpolation!r}")
    stored = floats_at(document, sampler.integer("output"), sampler, kind)
    cubic = interpolation == "CUBICSPLINE"
    if stored.size != len(times) * width * (3 if cubic else 1):
        raise sampler.error(f"has {len(times)} keys of {width} numbers, but {stored.size} values")
    keys = stored.reshape(len(times), -1, width)
    values, tangents = (keys[:, 1], keys[:, ::2]) if cubic else (keys[:, 0], None)
    spherical = kind == "VEC4"
    if spherical:
        if not np.linalg.norm(values, axis=1).all():
            raise sampler.error("has a rotation of no direction")
        values = _unit(values)
    return Track(times, values, tangents, interpolation, spherical)


def rounding(times: Floats) -> float:
    """Return how far single precision may put the last of these times off [s]."""
    return float(np.spacing(np.float32(np.abs(times[-1]))))


def frame_rate(tracks: list[Track]) -> float:
    """Return the frame rate that the key times were recorded at, 30 where they do not tell."""
    times = np.unique(np.round(np.concatenate([track.times for track in tracks]), 5))
    if len(times) < 2:
        return USUAL_RATES[0]
    mean = (times[-1] - times[0]) / (len(times) - 1)
    if np.abs(np.diff(times) - mean).max() < 0.02 * mean + 2 * rounding(times) and mean <= 1 / SLOWEST:
        return _exact(float(1 / mean))
    for rate in USUAL_RATES:
        frames = (times - times[0]) * rate
        if np.abs(frames - np.round(frames)).max() < 0.01:
            return rate
    return USUAL_RATES[0]


def _exact(rate: float) -> float:
    """Return the whole or broadcast rate that a measured one means."""
    for likely in (float(round(rate)), round(rate * 1.001) / 1.001):
        if abs(rate - likely) < 2e-4 * likely:
            return likely
    return rate
