"""A small actor and a small character with a few emotions, visemes and blinks, as files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mien.core import Blendshapes, Clip, Markers, Rig
from mien.io import gltf, trc
from tests.retargeting.actors import capture, face, points_on

NAMES = ("joy", "surprise", "viseme_PP", "viseme_aa", "blink_closed")
MIXED = np.array(
    [
        [0, 1, 1, 0, 0, 0.1],
        [0.4, 0, 0, 0, 0, 1],
        [-0.1, -0.3, -0.2, 0, 0, 0],
        [1, 0, 0, 0, 0, 0],
        [0, 0, 0, 1, 1, 0],
    ]
)
"""Each expression as weights of the small face's own six shapes; no mixture of them is another."""
MASKS = ("hero/brow", "hero/mouth", "hero/eyes")
FRAMES = 40


def expressive(size: int = 24, name: str = "actor") -> Rig:
    """The small face in three separate parts, each a colour of its own, with expressions for blendshapes."""
    rig = face(size)
    height = rig.neutral.vertices[:, 1]
    part = np.where(height < 0, 1, np.where(height < 0.048, 2, 0))
    corner = part[rig.neutral.triangles]
    whole = (corner == corner[:, :1]).all(axis=1)
    names = [mask.rpartition("/")[2] for mask in MASKS]
    groups = {name: np.flatnonzero(part == k) for k, name in enumerate(names)}
    mesh = replace(rig.neutral, triangles=rig.neutral.triangles[whole], groups=groups)
    shapes = Blendshapes(NAMES, np.tensordot(MIXED, rig.blendshapes.deltas, axes=1))
    colours = {name: (0.2 + 0.3 * k, 0.4, 0.3) for k, name in enumerate(names)}
    return Rig(mesh, shapes, name=name, colours=colours)


def speech() -> np.ndarray:
    """Weights `(F, 5)` of an actor who smiles, speaks and blinks, beginning at rest."""
    t = np.linspace(0, 1, FRAMES)
    bump = [np.exp(-(((t - at) / 0.09) ** 2)) for at in (0.8, 0.25, 0.35, 0.55, 0.15)]
    values = np.array([0.6, 0.3, 0.7, 0.8, 1.0]) * np.array(bump).T
    values[0] = 0
    return values


def extremes_take() -> Markers:
    """Frame 0 at rest, then each expression alone, in a capture elsewhere in space."""
    rig = expressive()
    return capture(rig, np.eye(6)[:, 1:], points_on(rig))


EXTREMES = (
    *(("emotion", "neutral", 0), ("emotion", "joy", 1), ("emotion", "surprise", 2)),
    *(("speech", "viseme_PP", 3), ("speech", "viseme_aa", 4)),
    *(("blink", "blink_open", 0), ("blink", "blink_closed", 5)),
)


def write_extremes(path: Path, rows: Sequence[tuple[str, str, int]] = EXTREMES) -> Path:
    path.write_text("layer,extreme,frame\n" + "".join(f"{a},{b},{c}\n" for a, b, c in rows), encoding="utf-8")
    return path


def write_layered_files(folder: Path) -> Path:
    """Write actor.glb (animated), hero.glb, rom.trc, take.trc and extremes.csv."""
    rig = expressive()
    gltf.write_rig(folder / "actor.glb", rig, Clip(NAMES, speech(), 30.0))
    gltf.write_rig(folder / "hero.glb", expressive(18, "hero"))
    trc.write_markers(folder / "rom.trc", extremes_take())
    trc.write_markers(folder / "take.trc", capture(rig, speech(), points_on(rig)))
    write_extremes(folder / "extremes.csv")
    return folder
