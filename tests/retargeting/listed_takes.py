"""An actor doing the list of docs/calibration-take.md, as a capture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.accuracy.calibration_take import FPS, HOLD_S, NEUTRAL_S, RAMP_S, REST_S, played
from mien.core import Blendshapes, Clip, Markers, Rig
from mien.evaluate.conditions import Conditions, captured
from mien.evaluate.metrics import millimetre
from mien.geometry.correspond import spread_points
from mien.io import gltf, trc
from mien.io.documents import join, write_landmarks
from mien.vocabularies import ARKIT_NAMES, match
from tests.retargeting.actors import face, points_on

BLINK = np.array([0.5, 1, 1, 0.7, 0.3])
SMALL_FACE = Conditions(49, 0.15)
"""Few points, with a noise of 0.2 mm on a human face."""
PERIOD_S = 2 * RAMP_S + HOLD_S + REST_S


def listed_face(names: tuple[str, ...] = ARKIT_NAMES) -> Rig:
    """The small face with local shapes of a few millimetres under Apple's names, and landmarks."""
    rng, bare, points = np.random.default_rng(5), face(), points_on(face())
    vertices = bare.neutral.vertices
    centres = vertices[rng.integers(0, len(vertices), len(ARKIT_NAMES)), :2] * 0.7
    reach = np.exp(-((vertices[None, :, :2] - centres[:, None]) ** 2).sum(2) / 0.03**2)
    pushes = rng.normal(0, 1, (len(ARKIT_NAMES), 3))
    pushes *= rng.uniform(0.008, 0.02, (len(ARKIT_NAMES), 1)) / np.linalg.norm(pushes, axis=1, keepdims=True)
    landmarks = {f"spot_{i}": points.take(np.array([i])) for i in (0, 6, 10, 24, 31, 38, 42, 48)}
    return Rig(bare.neutral, Blendshapes(names, reach[..., None] * pushes[:, None]), landmarks=landmarks, name="face")


def holds(count: int = 29) -> np.ndarray:
    """Return the first and last frame of each hold, `(count, 2)`."""
    first = np.round((NEUTRAL_S + RAMP_S + PERIOD_S * np.arange(count)) * FPS).astype(int)
    return np.stack([first, first + round(HOLD_S * FPS) - 1], axis=1)


def blinking(clip: Clip, every_s: float = 3.7) -> Clip:
    """Return a take with blinks, some between expressions and some within."""
    values = np.array(clip.values)
    eyes = [ARKIT_NAMES.index(f"eyeBlink{side}") for side in ("Left", "Right")]
    for second in np.arange(1.5, len(values) / FPS - 1, every_s):
        frames = slice(round(second * FPS), round(second * FPS) + len(BLINK))
        values[frames, eyes] = np.maximum(values[frames, eyes], BLINK[:, None])
    return replace(clip, values=values)


def without(clip: Clip, entry: int) -> Clip:
    """Return a take in which one expression is not done."""
    values = np.array(clip.values)
    first, last = holds()[entry]
    ramp = round(RAMP_S * FPS)
    return replace(clip, values=np.delete(values, np.s_[first - ramp : last + ramp + 1], axis=0))


def filmed(rig: Rig, clip: Clip, conditions: Conditions) -> Markers:
    """Return an actor as markers that carry the names of the landmarks they sit on."""
    spots = join(list(rig.landmarks.values()))
    points = spread_points(rig.neutral, spots, conditions.markers)
    names = [*rig.landmarks][: len(points)]
    names += [f"point_{i}" for i in range(len(names), len(points))]
    weights = match(clip.names, rig.blendshapes.names).apply(clip.values)
    markers = Markers(tuple(names), points.of(rig.pose(weights)), clip.fps)
    return captured(markers, conditions, millimetre(rig), np.random.default_rng(conditions.seed))


def write_take(path: Path, rig: Rig, clip: Clip | None = None, conditions: Conditions | None = None) -> Path:
    """Write the list, or what else an actor does, as a capture with noise and blinks."""
    trc.write_markers(path, filmed(rig, blinking(played()) if clip is None else clip, conditions or Conditions()))
    return path


def write_face(path: Path, rig: Rig, clip: Clip | None = None) -> Path:
    """Write a face, animated or not, with its landmarks beside it."""
    gltf.write_rig(path, rig, clip)
    write_landmarks(path.with_suffix(".landmarks.json"), rig.landmarks, rig.neutral)
    return path
