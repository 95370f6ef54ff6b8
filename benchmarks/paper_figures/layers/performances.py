"""Real performances in layers, whose extremes a rule chooses."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.speed.frames import spread
from mien.core import Clip, Labels, Rig
from mien.core.arrays import Floats
from mien.evaluate.collection import actor, take
from mien.io.files import read_bytes
from mien.io.formats import read_clip
from mien.retargeting.layers.choose import COUNTS, choose_extremes
from mien.retargeting.layers.decompose import Decomposer
from mien.retargeting.layers.model import LayeredFace, natural_regions
from mien.retargeting.layers.sources import layers_of_rig, picked_layers
from mien.vocabularies import match

POINTS = 99
SMOOTH = 1e-4
NOISE_CM = 0.01
SPOKEN = ("bs_value_1114_2_01", "bs_value_1114_3_15")
WITHOUT_BLINK = {layer: count for layer, count in COUNTS.items() if layer != "blink"}
"""For recordings of speech alone."""

STUDIO: Mapping[str, tuple[str, ...]] = {
    "mouthFunnel": ("mouth_funnel_dl", "mouth_funnel_dr", "mouth_funnel_ul", "mouth_funnel_ur"),
    "mouthPucker": ("mouth_pucker_l", "mouth_pucker_r"),
    "mouthSmileLeft": ("mouth_lipCornerPull_l",),
    "mouthSmileRight": ("mouth_lipCornerPull_r",),
    "mouthStretchLeft": ("mouth_lipStretch_l",),
    "mouthStretchRight": ("mouth_lipStretch_r",),
    "mouthLowerDownLeft": ("mouth_lowerLipDepress_l",),
    "mouthLowerDownRight": ("mouth_lowerLipDepress_r",),
    "mouthUpperUpLeft": ("mouth_upperLipRaise_l",),
    "mouthUpperUpRight": ("mouth_upperLipRaise_r",),
    "mouthPressLeft": ("mouth_press_l",),
    "mouthPressRight": ("mouth_press_r",),
    "mouthRollLower": ("mouth_suck_dl", "mouth_suck_dr"),
    "mouthRollUpper": ("mouth_suck_ul", "mouth_suck_ur"),
    "jawOpen": ("mouth_stretch_c",),
}
"""The studio's shapes by meaning, as means; those of the tongue and `mouth_oh_c`, `mouth_oo_c` have no counterpart."""


@dataclass(frozen=True, eq=False)
class Performance:
    """What an actor does, in centimetres, with the actor in layers.

    Attributes:
        name: who plays what.
        rig: the actor.
        face: the actor in layers at some points.
        moved: `(F, P, 3)` displacements.
        weights: `(F, K)` of the actor's blendshapes.
        fps: frames per second.
    """

    name: str
    rig: Rig
    face: LayeredFace
    moved: Floats
    weights: Floats
    fps: float

    def decomposer(self) -> Decomposer:
        """Return what takes it apart."""
        return Decomposer(self.face, np.ones(len(self.face.rest)), SMOOTH)


def performance(
    name: str,
    rig: Rig,
    clip: Clip,
    counts: Mapping[str, int] = COUNTS,
    training: Clip | None = None,
) -> Performance:
    """Let an actor perform, seen at 99 points of the face with a tenth of a millimetre of noise.

    Args:
        name: what it is called.
        rig: the actor.
        clip: weights of shapes, matched by name; lost frames are at rest.
        counts: extremes per layer.
        training: the take whose frames are the extremes; the performance itself if None.
    """
    moving = np.flatnonzero(np.linalg.norm(rig.blendshapes.deltas, axis=2).max(axis=0) > 1e-3)
    rows = moving[spread(rig.neutral.vertices[moving], POINTS)]
    whole = natural_regions(layers_of_rig(rig))
    regions = Labels(whole.names, whole.of[rows])
    weights = _weights(rig, clip)
    moved = _seen(rig, weights, rows, 2)
    shown = moved if training is None else _seen(rig, _weights(rig, training), rows, 3)
    picks = choose_extremes(shown, regions, counts)
    layers = picked_layers(picks, shown, [f"p{i}" for i in range(len(rows))])
    face = LayeredFace(100 * rig.neutral.vertices[rows], layers, regions)
    return Performance(name, rig, face, moved, weights, clip.fps)


def performances(folder: Path, quick: bool) -> list[Performance]:
    """Return the real takes: an adult, people of ICT's identities, and two of speech alone; the first two if quick."""
    acted = folder / "clips" / "adult_plays_S07.glb"
    made = [
        performance("adult, S07-001", actor(folder, "adult"), read_clip(acted)),
        performance("p1, S07-001", actor(folder, "p1"), take(folder, "S07-001")),
    ]
    if quick:
        return made
    for person, name in (("p2", "apfel"), ("p3", "alex_rom_3")):
        made.append(performance(f"{person}, {name}", actor(folder, person), take(folder, name)))
    rom = take(folder, "alex_rom_3")
    for person, name in (("p1", "S07-001"), ("p2", "apfel")):
        label = f"{person}, {name}, extremes of alex_rom_3"
        made.append(performance(label, actor(folder, person), take(folder, name), training=rom))
    for name in SPOKEN:
        made.append(performance(f"p4, {name}", actor(folder, "p4"), spoken(folder, name), WITHOUT_BLINK))
    return made


def spoken(folder: Path, name: str) -> Clip:
    """Return a recording of speech in ARKit's names.

    Its columns stand one place after their names: only so do the left and right of all shapes
    that are used agree.
    """
    return Clip(tuple(STUDIO), studio(folder, name, tuple(STUDIO.values())), 30.0)


def studio(folder: Path, take_name: str, wanted: tuple[tuple[str, ...], ...]) -> Floats:
    """Return `(F, len(wanted))` means of a recording's own shapes."""
    names = [str(name) for name in np.load(io.BytesIO(read_bytes(folder / "clips" / "speech" / "names.npy")))]
    values = np.load(io.BytesIO(read_bytes(folder / "clips" / "speech" / f"{take_name}.npy")))
    return np.stack([np.mean([values[:, names.index(n) + 1] for n in group], axis=0) for group in wanted], axis=1)


def _weights(rig: Rig, clip: Clip) -> Floats:
    return np.asarray(np.nan_to_num(clip.values) @ match(clip.names, rig.blendshapes.names).matrix.T)


def _seen(rig: Rig, weights: Floats, rows: np.ndarray, seed: int) -> Floats:
    moved = 100 * np.tensordot(weights, rig.blendshapes.deltas[:, rows], axes=1)
    return np.asarray(moved + np.random.default_rng(seed).normal(0, NOISE_CM, moved.shape))
