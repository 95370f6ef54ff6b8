"""From a character that can be posed by controls to a rig with the extremes of the three layers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from mien.core import Anatomy, Blendshapes, Labels, Rig
from mien.core.rig import Colour
from mien.library.characters.parts import Part, joined
from mien.vocabularies.expressions import BLINKS, LAYER_EMOTIONS, LAYER_REGION, VISEMES

CENTIMETRE = 0.01

EXTREMES = (*LAYER_EMOTIONS, *VISEMES, *BLINKS)
"""What a character for the layers must be able to show; the neutral and the open eyes are its rest."""

Pose = TypeVar("Pose")


def posed_rig(
    name: str,
    model: Callable[[Pose], Sequence[Part]],
    poses: Mapping[str, Pose],
    rest: Pose,
    masks: Sequence[str],
    colours: Mapping[str, Colour],
) -> Rig:
    """Return the rig of a character whose parts a function makes for any pose of its controls.

    Args:
        name: what the rig is called.
        model: the character's parts in a pose [cm]; only their places may depend on it.
        poses: the pose of each extreme that differs from rest.
        rest: the neutral pose.
        masks: the regions whose layers are weighed together (Kholgade et al. 2011, §3.2): vertex groups, put first.
        colours: linear red, green and blue of vertex groups, later ones over earlier.
    """
    mesh = joined(model(rest))
    deltas = np.zeros((len(EXTREMES), len(mesh.vertices), 3))
    for k, extreme in enumerate(EXTREMES):
        if extreme in poses:
            deltas[k] = np.concatenate([part.points for part in model(poses[extreme])]) - mesh.vertices
    groups = {group: mesh.groups[group] for group in (*masks, *mesh.groups)}
    mesh = replace(mesh, vertices=mesh.vertices * CENTIMETRE, groups=groups)
    of = np.full(len(mesh.vertices), -1)
    for k, mask in enumerate(masks):
        of[groups[mask]] = k
    anatomy = Anatomy(labels={LAYER_REGION: Labels(tuple(masks), of)})
    return Rig(mesh, Blendshapes(EXTREMES, deltas * CENTIMETRE), anatomy=anatomy, name=name, colours=colours)
