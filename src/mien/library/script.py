"""The scripted take: each shape to its extreme, then a few seconds of acting.

It stands in for a recording day: the range of motion that the retargeting learns from
comes first, alone and in natural combinations, and then what is to be retargeted.
"""

from __future__ import annotations

import numpy as np

from mien.core import Clip, Markers, Rig
from mien.core.arrays import Floats

FPS = 60.0
BEAT = 0.24
"""Seconds from one extreme to the next; neighbours overlap as they do on a real face."""

RANGE_OF_MOTION = (
    "jawOpen",
    "eyeBlink*",
    "browInnerUp",
    "browOuterUp*",
    "browDown*",
    "eyeWide*",
    "eyeSquint* cheekSquint*",
    "noseSneer*",
    "mouthSmileLeft",
    "mouthSmileRight",
    "mouthFrown*",
    "mouthPucker",
    "mouthFunnel",
    "mouthStretch*",
    "mouthUpperUp*",
    "mouthLowerDown*",
    "mouthLeft",
    "mouthRight",
    "jawLeft",
    "jawRight",
    "jawForward",
    "cheekPuff",
    "mouthPress*",
    "mouthDimple*",
    "mouthRollUpper mouthRollLower",
    "mouthShrugLower",
    "mouthShrugUpper",
    "jawOpen tongueOut",
    "jawOpen mouthClose",
    "eyeBlinkLeft mouthSmileLeft",
    "eyeBlinkRight browDownRight",
    "browInnerUp browOuterUp* jawOpen eyeWide*",
    "mouthSmile* cheekSquint* mouthUpperUp*",
    "eyeLookUp*",
    "eyeLookDown*",
    "eyeLookOutLeft eyeLookInRight",
    "eyeLookInLeft eyeLookOutRight",
)
"""The extremes, one per beat; a star stands for both sides."""

ACTING: tuple[tuple[float, float, dict[str, float]], ...] = (
    (0.0, 0.5, {"jawOpen": 0.45, "mouthLowerDown*": 0.3}),
    (0.25, 0.4, {"mouthStretch*": 0.5, "mouthUpperUp*": 0.3, "jawOpen": 0.15}),
    (0.5, 0.45, {"mouthFunnel": 0.7, "jawOpen": 0.3}),
    (0.75, 0.4, {"mouthPress*": 0.6, "mouthRollLower": 0.4}),
    (0.95, 0.45, {"mouthPucker": 0.8, "jawOpen": 0.1}),
    (0.6, 0.25, {"eyeBlink*": 1.0}),
    (1.3, 1.2, {"mouthSmile*": 0.85, "cheekSquint*": 0.6, "eyeSquint*": 0.4, "browOuterUp*": 0.2}),
    (1.6, 0.7, {"jawOpen": 0.25, "mouthUpperUp*": 0.4}),
    (2.4, 0.25, {"eyeBlink*": 1.0}),
    (2.55, 1.0, {"browInnerUp": 0.9, "browOuterUp*": 0.9, "eyeWide*": 1.0, "jawOpen": 0.6}),
    (3.5, 0.25, {"eyeBlink*": 1.0}),
    (3.6, 1.1, {"browDown*": 1.0, "noseSneer*": 0.7, "eyeSquint*": 0.5, "mouthUpperUp*": 0.5, "mouthStretch*": 0.4}),
    (3.8, 0.7, {"jawOpen": 0.3, "mouthLowerDown*": 0.6}),
    (4.7, 0.25, {"eyeBlink*": 1.0}),
)
"""Start, length [s] and strengths of a few visemes, a smile, a surprise and an anger."""

NOISE = 0.00015
NECK = np.array([0.0, -0.1, -0.02])


def performance(rig: Rig, rng: np.random.Generator | None = None) -> tuple[Clip, Markers]:
    """Play the scripted take on a rig with ARKit shapes, and capture it with markers on its landmarks.

    Args:
        rig: the actor, with all ARKit names that the script uses.
        rng: where the noise and the gaps come from; the same ones every time if None.

    Returns:
        The clip with the true weights and head motion, and the markers in world
        coordinates [m] with 0.15 mm of noise, short gaps and one long one.

    Raises:
        InputError: the rig lacks a shape of the script.
    """
    rng = np.random.default_rng(23) if rng is None else rng
    values = _weights(rig)
    head = _head_motion(len(values))
    clip = Clip(rig.blendshapes.names, values, FPS, head=head)
    return clip, _captured(rig, clip, head, rng)


def _weights(rig: Rig) -> Floats:
    opening = 0.4
    gestures = [
        (opening + i * BEAT, 1.6 * BEAT, dict.fromkeys(shapes.split(), 1.0)) for i, shapes in enumerate(RANGE_OF_MOTION)
    ]
    acting = opening + (len(RANGE_OF_MOTION) + 1) * BEAT
    gestures += [(acting + start, length, shapes) for start, length, shapes in ACTING]
    time = np.arange(round((acting + 5.2) * FPS)) / FPS
    values = np.zeros((len(time), len(rig.blendshapes)))
    for start, length, shapes in gestures:
        bump = _bump((np.round(time * FPS) - round(start * FPS)) / max(round(length * FPS), 1))
        for name, strength in shapes.items():
            for side in ("Left", "Right") if name.endswith("*") else ("",):
                column = rig.blendshapes.index(name.rstrip("*") + side)
                values[:, column] = np.maximum(values[:, column], strength * bump)
    return values


def _bump(t: Floats) -> Floats:
    """Return a smooth rise from 0, a short hold at 1, and a fall back to 0 at 1."""
    ramp = np.clip(np.minimum(t, 1 - t) / 0.4, 0, 1)
    return np.asarray(ramp**3 * (ramp * (6 * ramp - 15) + 10))


def _head_motion(frames: int) -> Floats:
    """Return `(F, 4, 4)` nods, turns and a little sway about the neck, starting at rest."""
    t = np.arange(frames) / FPS
    ease = np.minimum(t, 1)
    nod, turn, roll = (ease * a * np.sin(w * t) for a, w in ((0.10, 1.9), (0.22, 1.1), (0.05, 0.7)))
    one, zero = np.ones(frames), np.zeros(frames)
    cx, sx, cy, sy, cz, sz = (f(a) for a in (nod, turn, roll) for f in (np.cos, np.sin))
    about_x = np.stack([one, zero, zero, zero, cx, -sx, zero, sx, cx], axis=1).reshape(-1, 3, 3)
    about_y = np.stack([cy, zero, sy, zero, one, zero, -sy, zero, cy], axis=1).reshape(-1, 3, 3)
    about_z = np.stack([cz, -sz, zero, sz, cz, zero, zero, zero, one], axis=1).reshape(-1, 3, 3)
    motion = np.tile(np.eye(4), (frames, 1, 1))
    motion[:, :3, :3] = about_y @ about_x @ about_z
    motion[:, :3, 3] = NECK - motion[:, :3, :3] @ NECK + 0.01 * (ease * np.sin(0.8 * t))[:, None] * [1.0, 0.2, 0.5]
    return motion


def _captured(rig: Rig, clip: Clip, head: Floats, rng: np.random.Generator) -> Markers:
    names = tuple(rig.landmarks)
    ids = np.array([rig.landmarks[name].corners[0, 0] for name in names])
    local = rig.only(ids).pose(clip.values)
    points = np.einsum("fab,fmb->fma", head[:, :3, :3], local) + head[:, None, :3, 3]
    points = points + rng.normal(0, NOISE, points.shape)
    for length in [*rng.integers(3, 13, 10).tolist(), 90]:
        start = int(rng.integers(30, len(points) - length))
        points[start : start + length, rng.integers(len(names))] = np.nan
    return Markers(names, points, clip.fps)
