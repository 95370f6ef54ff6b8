"""A performance, whatever kind of file it came in."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mien.capture import Neutral, trace
from mien.capture.neutral import neutral_at
from mien.core import Clip, Correspondence, FileError, InputError, Markers, Rig
from mien.io.formats import format_of, read_clip, read_markers, read_rig
from mien.vocabularies import match


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
            raise InputError(f"{self.path} holds weights; to follow points the actor's rig is needed: give it with --actor.")
        return trace(self.actor, self.clip, pairs.source, pairs.names)

    def neutral(self, pairs: Correspondence, given: str | None = None) -> Neutral | None:
        """Return the actor at rest at the paired points, where it is known or given.

        Args:
            pairs: the correspondence.
            given: a frame number, or a file of markers whose first frame is the neutral.

        Returns:
            None if it must be found in the take.
        """
        if given is not None and not given.lstrip("-").isdigit():
            other = load_performance(Path(given)).points(pairs).only(pairs.names)
            return replace(neutral_at(other, 0), frame=None)
        if given is not None:
            return neutral_at(self.points(pairs).only(pairs.names), int(given))
        if self.actor is not None and pairs.source is not None:
            return Neutral(pairs.source.of(self.actor.neutral.vertices), None, float("nan"))
        return None


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
        return Performance(path, markers=read_markers(path))
    if row.read_rig is not None and row.read_clip is not None:
        return Performance(path, clip=read_clip(path), actor=read_rig(path))
    if row.read_clip is None:
        raise FileError(f"{path} holds {row.about}: a face, but no performance. Give markers, an animated mesh or weights.")
    clip = read_clip(path)
    if actor is None:
        return Performance(path, clip=clip)
    return _on_actor(path, clip, read_rig(actor))


def _on_actor(path: Path, clip: Clip, rig: Rig) -> Performance:
    """Give the clip the actor's own shape names, so that it plays on the rig."""
    found = match(clip.names, rig.blendshapes.names)
    if not found.matrix.any():
        raise InputError(
            f"no channel of {path} ({', '.join(clip.names[:5])} …) is a shape of the actor {rig.name} "
            f"({', '.join(rig.blendshapes.names[:5])} …); give the rig that the performance was captured with."
        )
    values = np.where(np.isnan(clip.values).any(axis=1)[:, None], np.nan, np.nan_to_num(clip.values) @ found.matrix.T)
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
