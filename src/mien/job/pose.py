"""A pose of a character completed from a few values, by what a fitted model knows of its poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mien.core import Clip, FileError, InputError, Rig
from mien.io.formats import format_of, write_clip
from mien.job.labelled import with_bones
from mien.job.model import load_model
from mien.look.portrait import Portrait
from mien.look.sheet import save_png
from mien.retargeting.by_example import ExampleRetargeter

PICTURE = ".png"
SIZE = 720
SHOWN = 0.01
"""Parameters closer to 0 than this are not printed."""


@dataclass(frozen=True, eq=False)
class Posed:
    """A completed pose.

    Attributes:
        rig: the character; None if it is parameters alone.
        clip: one frame.
        given: names of what was given.
    """

    rig: Rig | None
    clip: Clip
    given: tuple[str, ...]

    def values(self) -> dict[str, float]:
        """Return the parameters by name."""
        return {name: float(v) for name, v in zip(self.clip.names, self.clip.values[0], strict=True)}


def pose(character: Path, model: Path, given: Mapping[str, float]) -> Posed:
    """Complete a pose.

    Args:
        character: the rig; or the .csv of parameters that the model was fitted to.
        model: fitted with a method that knows poses.
        given: a few values by name.

    Raises:
        FileError: a file is missing or damaged.
        InputError: the model knows no poses, or a name is unknown.
    """
    alone = format_of(character).read_rig is None
    fitted = load_model(model, None if alone else character)
    if fitted.character is not None and alone:
        raise InputError(f"{model} was fitted to a rig, but {character} is a file of parameters; give the rig.")
    return completed(fitted.retargeter, fitted.character, given)


def completed(retargeter: object, rig: Rig | None, given: Mapping[str, float]) -> Posed:
    """Complete a pose by a fitted method.

    Raises:
        InputError: the method did not learn from labelled poses, or a name is unknown.
    """
    if not isinstance(retargeter, ExampleRetargeter):
        raise InputError(
            "the model did not learn from labelled poses, so it cannot complete one; fit with --method latent."
        )
    values = retargeter.complete(given)
    clip = Clip(retargeter.names, values[None], retargeter.fps)
    return Posed(rig, with_bones(clip, rig), tuple(given))


def write(posed: Posed, output: Path) -> None:
    """Write a pose: a row of a `.csv` or `.npz`, a character in it, or a picture.

    Raises:
        FileError: the file cannot be written, or there is no character to show.
    """
    if output.suffix.lower() != PICTURE:
        write_clip(output, posed.clip, posed.rig)
        return
    if posed.rig is None:
        raise FileError(f"cannot write {output}: the model knows parameters but no mesh to picture; write a .csv.")
    joints = None if posed.clip.joints is None else posed.clip.joints[0]
    weights = posed.clip.channels(posed.rig.blendshapes.names)[0]
    save_png(output, np.asarray(Portrait.of(posed.rig, size=(SIZE, SIZE)).picture(weights, joints=joints)))
