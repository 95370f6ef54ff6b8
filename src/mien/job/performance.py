"""A performance, whatever kind of file it came in."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from mien.capture import Neutral, fill_gaps, find_neutral, trace
from mien.capture.neutral import neutral_at
from mien.core import Clip, Correspondence, FileError, InputError, Markers, Rig
from mien.core.arrays import Floats
from mien.io.formats import format_of, read_clip, read_markers, read_rig
from mien.vocabularies import match

LARGEST = 1e6
"""No weight and no position in metres is larger than this."""


@dataclass(frozen=True, eq=False)
class Performance:
    """What an actor did: markers, or weights with (or without) the face they play on.

    Attributes:
        path: the file.
        markers: captured points, or None.
        clip: weights or skin animation, or None.
        actor: the mesh that the clip plays on, or None.
    """

    path: Path
    markers: Markers | None = None
    clip: Clip | None = None
    actor: Rig | None = None

    @property
    def head_moves(self) -> bool:
        """Whether head motion is mixed into the points: always in markers, in a mesh if it has joints."""
        return self.markers is not None or (self.clip is not None and self.clip.joints is not None)

    def points(self, pairs: Correspondence) -> Markers:
        """Return the performance as markers at the paired points."""
        if self.markers is not None:
            return self.markers
        if self.clip is None or self.actor is None or pairs.source is None:
            raise InputError(
                f"{self.path} holds weights; to follow points the actor's rig is needed: give it with --actor."
            )
        return trace(self.actor, self.clip, pairs.source, pairs.names)

    @cached_property
    def bridged(self) -> Markers:
        """The markers that are ever seen, short gaps filled: one that never is says nothing about where the others are."""
        assert self.markers is not None
        seen = np.flatnonzero(self.markers.seen.any(axis=0))
        return fill_gaps(self.markers.only([self.markers.names[i] for i in seen]))

    @cached_property
    def rest(self) -> Neutral:
        """The face at rest, found in the bridged markers."""
        return find_neutral(self.bridged)

    def rest_at(self, pairs: Correspondence) -> Neutral | None:
        """Return the rest found in the take for a method that would look for it at these very points; None if it would not."""
        alike = self.markers is not None and pairs.names == self.bridged.names
        return self.rest if alike and (np.asarray(pairs.confidence) > 0).all() else None

    def neutral(self, pairs: Correspondence, given: str | None = None) -> Neutral | None:
        """Return the actor at rest at the paired points, where it is known or given.

        Args:
            pairs: the correspondence.
            given: a frame number, or a file whose first frame is the neutral: markers, weights, or the actor's mesh.

        Returns:
            None if it must be found in the take.
        """
        frame = frame_number(given)
        if frame is not None:
            return neutral_at(self.points(pairs).only(pairs.names), frame)
        if given is not None:
            return self._neutral_of(Path(given), pairs)
        if self.actor is not None and pairs.source is not None:
            return Neutral(pairs.source.of(self.actor.neutral.vertices), None, float("nan"))
        return None

    def _neutral_of(self, path: Path, pairs: Correspondence) -> Neutral:
        if not path.exists():
            raise FileError(f"the neutral {path} does not exist: give a frame number or a file.")
        if self.actor is not None and pairs.source is not None and format_of(path).read_rig is not None:
            rest = read_rig(path)
            check_same_mesh(self.actor, rest, path)
            return Neutral(pairs.source.of(rest.neutral.vertices), None, float("nan"))
        other = load_performance(path)
        if self.actor is not None and other.clip is not None:
            other = _on_actor(path, other.clip, self.actor)
        return replace(neutral_at(other.points(pairs).only(pairs.names), 0), frame=None)


def frame_number(text: str | None) -> int | None:
    """Return the frame that an option names, or None if it names a file or nothing."""
    return int(text) if text is not None and re.fullmatch(r"-?[0-9]{1,9}", text) else None


def check_same_mesh(actor: Rig, other: Rig, path: Path) -> None:
    """Refuse a second mesh of the actor on which the pairs would be other points.

    Raises:
        InputError: the numbers of vertices differ.
    """
    mine, theirs = len(actor.neutral.vertices), len(other.neutral.vertices)
    if mine != theirs:
        raise InputError(
            f"{path} has a mesh of {theirs} vertices, but the actor's {actor.name} has {mine}, so points on one are not "
            "points on the other; give files of the same mesh."
        )


def load_performance(path: Path, actor: Path | None = None) -> Performance:
    """Read a performance.

    Args:
        path: markers, an animated face, or weights.
        actor: the rig that weights play on.

    Raises:
        FileError: the file holds no performance.
        InputError: the weights share no name with the actor's rig.
    """
    row = format_of(path)
    if row.read_markers is not None:
        markers = read_markers(path)
        _check_values(path, markers.points.reshape(len(markers), -1))
        return Performance(path, markers=markers)
    if row.read_rig is not None and row.read_clip is not None:
        return Performance(path, clip=_checked(path, read_clip(path)), actor=read_rig(path))
    if not path.exists():
        raise FileError(f"{path} does not exist.")
    if row.read_clip is None:
        raise FileError(
            f"{path} holds {row.about}: a face, but no performance. Give markers, an animated mesh or weights."
        )
    clip = _checked(path, read_clip(path))
    if actor is None:
        return Performance(path, clip=clip)
    return _on_actor(path, clip, read_rig(actor))


def _checked(path: Path, clip: Clip) -> Clip:
    _check_values(path, clip.values)
    return clip


def _check_values(path: Path, values: Floats) -> None:
    """Refuse a performance without frames, or with numbers `(F, C)` that arithmetic would not survive.

    Raises:
        FileError: there is no frame, or a value is larger than any weight or position.
    """
    if not len(values):
        raise FileError(f"{path} holds no row: a performance needs at least one frame.")
    size = np.nan_to_num(np.abs(values))
    if size.size and size.max() > LARGEST:
        frame = int(np.unravel_index(np.argmax(size), size.shape)[0])
        raise FileError(
            f"{path} holds the value {size.max():.3g} at frame {frame}, which is no weight and no position of a face; "
            "the file is damaged or its columns are mixed up."
        )


def _on_actor(path: Path, clip: Clip, rig: Rig) -> Performance:
    """Give the clip the actor's own shape names, so that it plays on the rig."""
    found = match(clip.names, rig.blendshapes.names)
    if not found.matrix.any():
        raise InputError(
            f"no channel of {path} ({', '.join(clip.names[:5])} …) is a shape of the actor {rig.name} "
            f"({', '.join(rig.blendshapes.names[:5])} …); give the rig that the performance was captured with."
        )
    values = np.where(
        np.isnan(clip.values).any(axis=1, keepdims=True), np.nan, np.nan_to_num(clip.values) @ found.matrix.T
    )
    return Performance(path, clip=replace(clip, names=rig.blendshapes.names, values=values), actor=rig)


def load_source(path: Path) -> Performance:
    """Read the actor's side for pairing: markers, or any mesh, animated or not.

    Raises:
        FileError: the file holds neither.
    """
    row = format_of(path)
    if row.read_markers is not None:
        return Performance(path, markers=read_markers(path))
    return Performance(path, actor=read_rig(path))
