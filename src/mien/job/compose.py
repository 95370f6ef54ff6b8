"""A performance as curves of its layers, and any character played by them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mien.core import Clip, InputError, Note, Rig
from mien.io import gltf
from mien.io.formats import read_clip, read_rig, write_clip
from mien.io.weights import write_clip as write_weights
from mien.job.retarget import Result
from mien.retargeting.layers import Layers, rig_face, split_clip, split_rig
from mien.retargeting.layers.compose import curves_of, projection
from mien.retargeting.layers.dynamics import Dynamics
from mien.retargeting.layers.played import played_by
from mien.solve.layered import layer_weights


@dataclass(frozen=True, eq=False)
class Composed:
    """A character with the animation that its layers make.

    Attributes:
        rig: the character; with its shapes split by region if that was asked for.
        clip: weights of its blendshapes.
        loss_mm: mean distance between the layers' face and what the blendshapes make of it.
        notes: what was repaired.
    """

    rig: Rig
    clip: Clip
    loss_mm: float
    notes: tuple[Note, ...]


def write_layers(path: Path, result: Result) -> None:
    """Write the curves of a retargeted performance's layers: shares of extremes, and weights of layers by region.

    Raises:
        InputError: another method than layers was used.
        FileError: the file cannot be written.
    """
    if not hasattr(result.retargeter, "layers") or result.markers is None:
        raise InputError(f"curves of layers come from the method {Layers.name!r}; add --method {Layers.name}.")
    write_weights(path, replace(result.retargeter.layers(result.markers), head=None))


def compose(
    character: Path,
    curves: Path,
    *,
    masks: Sequence[str] = (),
    split: bool = False,
    dynamics: Dynamics | None = None,
) -> Composed:
    """Play a character by curves of layers (Kholgade et al. 2011, eq. 5).

    Args:
        character: a rig whose blendshapes are extremes, by name.
        curves: channels `layer.extreme` and `weight.region.layer`.
        masks: the character's vertex groups that are its regions; told from what moves them if empty.
        split: whether to give the character a shape per extreme and region, which plays the curves exactly.
        dynamics: a time warp and gain of the character's own.

    Raises:
        FileError: a file is wrong.
        InputError: the curves lack a layer or a region of the character.
    """
    rig = read_rig(character)
    clip = read_clip(curves)
    face, unplayed = played_by(rig_face(rig, masks=tuple(masks)), clip)
    if dynamics is not None:
        clip = dynamics.apply(face, clip)
    if split:
        played = split_clip(face, clip)
        return Composed(split_rig(rig, face), played, 0.0, (*face.notes, *unplayed, *played.notes))
    weights, coefficients, notes = curves_of(face, clip)
    mixed = layer_weights(face.starts, weights, coefficients)
    values, loss = projection(rig, face).weights(mixed)
    return Composed(
        rig, Clip(rig.blendshapes.names, values, clip.fps), float(loss.mean()), (*face.notes, *unplayed, *notes)
    )


def write(result: Composed, outputs: Sequence[Path]) -> None:
    """Write the animation to each path in the format of its suffix.

    Raises:
        FileError: a file cannot be written.
    """
    for path in outputs:
        if path.suffix.lower() in (".glb", ".gltf") and result.rig.source is None:
            gltf.write_rig(path, result.rig, result.clip)
        else:
            write_clip(path, result.clip, result.rig)
