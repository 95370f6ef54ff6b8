"""What methods that learn from labelled frames need of files.

The character may be a rig, or nothing but parameters in a CSV; the actor is read as it is
captured: all markers, points spread over an animated mesh, or the weights themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Rig
from mien.core.anatomy import AXES
from mien.core.errors import unknown
from mien.geometry.puppet import Puppet
from mien.io.formats import format_of, read_clip, read_rig
from mien.job.bones import with_head
from mien.job.layers import own_points, rest_of
from mien.job.pairs import OWN, find_pairs
from mien.job.performance import Performance


@dataclass(frozen=True, eq=False)
class Target:
    """The character's side.

    Attributes:
        rig: the character; None if it is known by its parameters alone.
        animations: its existing animation: poses that nobody acted.
    """

    rig: Rig | None
    animations: tuple[Clip, ...] = ()


@dataclass(frozen=True, eq=False)
class Source:
    """The actor's side.

    Attributes:
        take: the training take as it is read.
        points: the points of an animated mesh that are followed.
        pairs: where the take's points are on the character, if that is known.
        neutral: the actor at rest at the markers, where it is known or given.
    """

    take: Markers | Clip
    points: Correspondence | None = None
    pairs: Correspondence | None = None
    neutral: Neutral | None = None


def read_target(character: Path, examples: Path | None = None, animations: Sequence[Path] = ()) -> Target:
    """Read a rig, or a file of parameters whose rows are existing animation.

    Args:
        character: a rig; or weights, which may be the labels themselves.
        examples: the labels.
        animations: further existing animation.

    Raises:
        FileError: a file is missing or damaged.
    """
    clips = tuple(read_clip(path) for path in animations)
    row = format_of(character)
    if row.read_rig is not None or row.read_clip is None:
        return Target(read_rig(character), clips)
    if examples is not None and character.resolve() == examples.resolve():
        return Target(None, clips)
    return Target(None, (read_clip(character), *clips))


def source_of(
    training: Performance,
    rig: Rig | None,
    *,
    pairs: Path | None = None,
    landmarks: tuple[Path, Path] | None = None,
    count: int,
    neutral: str | None = None,
) -> Source:
    """Return the actor's side of a training take, for which nothing has to correspond.

    Args:
        training: markers, an animated mesh, or weights.
        rig: the character, if it has a mesh.
        pairs: a file that says which point is which.
        landmarks: a file for each side; only the actor's is needed, to spread points over a mesh.
        count: points to spread.
        neutral: frame number or file of the actor's neutral.

    Raises:
        FileError: a file is wrong.
        InputError: points are paired with a character that has none.
    """
    if rig is None and pairs is not None:
        raise InputError("the character is a file of parameters and has no points; leave --pairs out.")
    if training.markers is None and training.actor is None:
        assert training.clip is not None
        return Source(training.clip)
    if training.markers is None:
        assert training.actor is not None
        paired = None if rig is None or pairs is None else find_pairs(training, rig, pairs=pairs)[0]
        points = paired or own_points(training.actor, landmarks, count)
        return Source(training.points(points), points, paired, rest_of(training, points, neutral))
    found = None if rig is None else _place_of(training, rig, pairs, landmarks)
    if neutral is None:
        return Source(training.markers, pairs=found)
    seen = np.flatnonzero(training.markers.seen.any(axis=0))
    markers = training.markers.only([training.markers.names[i] for i in seen])
    return Source(markers, pairs=found, neutral=rest_of(replace(training, markers=markers), None, neutral))


def _place_of(
    training: Performance, rig: Rig, pairs: Path | None, landmarks: tuple[Path, Path] | None
) -> Correspondence | None:
    """Return where markers are on the character, if that is said or can be told by their names."""
    if pairs is not None or (landmarks is not None and landmarks != (OWN, OWN)):
        return find_pairs(training, rig, pairs=pairs, landmarks=landmarks)[0]
    try:
        return find_pairs(training, rig)[0]
    except InputError:
        return None


def check_parameters(examples: Examples | None, rig: Rig | None) -> None:
    """Refuse labels of parameters that the rig does not have.

    Raises:
        InputError: one is neither a blendshape nor a joint's axis.
    """
    if rig is None or examples is None:
        return
    known = {*rig.blendshapes.names, *bones_of(rig)}
    for name in examples.names:
        if name not in known:
            raise InputError(
                f"the labels name what {rig.name} does not have: {unknown('parameter', name, rig.blendshapes.names)} Rename "
                "the column; or, if these are sliders of another rig, give the labels themselves as the character."
            )


def with_bones(clip: Clip, rig: Rig | None) -> Clip:
    """Return a clip whose channels named `joint.axis` move the rig's joints."""
    turned = [] if rig is None else [i for i, name in enumerate(clip.names) if name not in rig.blendshapes.names]
    if rig is None or rig.skeleton is None or not turned:
        return clip
    puppet = Puppet.of(rig)
    names = [clip.names[i] for i in turned]
    joints = np.array([puppet.joint_matrices(dict(zip(names, row, strict=True))) for row in clip.values[:, turned]])
    return replace(clip, joints=with_head(joints, clip.head, rig.skeleton))


def bones_of(rig: Rig) -> tuple[str, ...]:
    """Return the names of what moves and turns a rig's joints: `joint.tx`, …, `joint.rz`."""
    joints = rig.skeleton.names if rig.skeleton is not None else ()
    return tuple(f"{joint}.{axis}" for joint in joints for axis in AXES)
