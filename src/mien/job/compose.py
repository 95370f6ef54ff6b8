"""A performance as curves of its layers, and any character played by them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mien.core import Clip, InputError, Note, Rig
from mien.io.formats import read_clip, read_rig, write_clip
from mien.io.weights import write_clip as write_weights
from mien.job.exact import MESHES, write_shown
from mien.job.request import Result
from mien.retargeting.layers import LayeredRetargeter, Layers, rig_face, split_clip, split_rig
from mien.retargeting.layers.compose import curves_of, projection
from mien.retargeting.layers.dynamics import Dynamics
from mien.retargeting.layers.head import head_of_curves, with_head_curves
from mien.retargeting.layers.played import played_by
from mien.solve.layered import layer_weights


@dataclass(frozen=True, eq=False)
class Composed:
    """A character with the animation that its layers make.

    Attributes:
        rig: the character.
        clip: weights of its own blendshapes.
        loss_mm: mean distance between the layers' face and what these make of it.
        split: the character with its shapes split by region, and weights of those, which are exact; None if
            not asked for.
        notes: what was repaired.
    """

    rig: Rig
    clip: Clip
    loss_mm: float
    split: tuple[Rig, Clip] | None
    notes: tuple[Note, ...]


def write_layers(path: Path, result: Result) -> None:
    """Write the curves of a retargeted performance's layers: shares of extremes, weights of layers by region, the head.

    Raises:
        InputError: another method than layers was used.
        FileError: the file cannot be written.
    """
    made = result.retargeter
    if not isinstance(made, LayeredRetargeter) or result.markers is None:
        raise InputError(f"curves of layers come from the method {Layers.name!r}; add --method {Layers.name}.")
    write_weights(path, with_head_curves(made.character, made.layers(result.markers), result.clip.head))


def compose(
    character: Path,
    curves: Path,
    *,
    masks: Sequence[str] = (),
    split: bool = True,
    dynamics: Dynamics | None = None,
) -> Composed:
    """Play a character by curves of layers (Kholgade et al. 2011, eq. 5).

    Args:
        character: a rig whose blendshapes are extremes, by name.
        curves: channels `layer.extreme` and `weight.region.layer`.
        masks: the character's vertex groups that are its regions; its own, or told from what moves them, if empty.
        split: whether to make a shape per extreme and region too, which play the curves exactly.
        dynamics: a time warp and gain of the character's own.

    Raises:
        FileError: a file is wrong.
        InputError: the curves lack a layer or a region of the character.
    """
    rig = read_rig(character)
    clip = read_clip(curves)
    face, unplayed = played_by(rig_face(rig, masks=tuple(masks)), clip)
    clip = replace(clip, head=head_of_curves(face, clip))
    said: tuple[Note, ...] = ()
    if dynamics is not None:
        said = dynamics.notes(face)
        clip = dynamics.apply(face, clip)
    weights, coefficients, notes = curves_of(face, clip)
    mixed, projected = layer_weights(face.starts, weights, coefficients), projection(rig, face)
    values = projected.weights(mixed)
    own = Clip(rig.blendshapes.names, values, clip.fps, clip.head, start=clip.start)
    exact = (split_rig(rig, face), split_clip(face, clip)) if split else None
    return Composed(
        rig, own, float(projected.loss(mixed, values).mean()), exact, (*face.notes, *unplayed, *said, *notes)
    )


def write(result: Composed, outputs: Sequence[Path]) -> None:
    """Write the animation to each path in the format of its suffix; meshes with the split shapes, if there are any.

    Raises:
        FileError: a file cannot be written.
    """
    for path in outputs:
        if result.split is not None and path.suffix.lower() in MESHES:
            rig, clip = result.split
            write_shown(path, clip, rig)
        else:
            write_clip(path, result.clip, result.rig)
