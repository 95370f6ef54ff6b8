"""What the layers method needs of files: the actor's extremes, and the points it is seen at.

The actor's extremes are frames picked from the training take (`extremes.csv`), or, for an
actor who is an animated mesh whose shapes are emotions, visemes and blinks, those shapes.
Either way no point of the actor has to be a point of the character.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mien.capture import Neutral
from mien.core import Correspondence, Examples, Markers, Rig, SurfacePoints
from mien.geometry.correspond import spread_points
from mien.io.documents import join
from mien.io.examples import read_extremes
from mien.job.pairs import OWN, rig_landmarks
from mien.job.performance import Performance
from mien.retargeting.layers.posed import posed_extremes, shared_table


def actor_extremes(
    training: Performance,
    character: Rig,
    extremes: Path | None,
    landmarks: tuple[Path, Path] | None,
    count: int,
) -> tuple[Markers, Examples, Correspondence | None] | None:
    """Return the take that shows the actor's extremes, which frames show them, and the actor's own points.

    Args:
        training: the actor's side.
        character: the other, whose extremes are matched by name.
        extremes: which frame of the take shows which extreme.
        landmarks: the first is the actor's, for an actor who is a mesh.
        count: points to follow on a mesh.

    Returns:
        None if the actor has no extremes of its own that the character knows.

    Raises:
        FileError: a file is wrong.
    """
    points = None if training.actor is None else own_points(training.actor, landmarks, count)
    if extremes is not None:
        take = training.markers if points is None else training.points(points)
        return None if take is None else (take, read_extremes(extremes), points)
    if training.actor is None or points is None:
        return None
    shared = shared_table(training.actor, character)
    if not shared:
        return None
    assert training.clip is not None
    take, examples = posed_extremes(training.actor, points, shared, training.clip.fps)
    return take, examples, points


def own_points(actor: Rig, landmarks: tuple[Path, Path] | None, count: int) -> Correspondence:
    """Spread points over an actor's face, which stand for nothing on any character."""
    given = None if landmarks is None or landmarks[0] == OWN else landmarks[0]
    found = rig_landmarks(actor, given)
    if found:
        points = spread_points(actor.neutral, join(list(found.values())), count)
        names = tuple(found)[:count] + tuple(f"point_{i}" for i in range(len(found), count))
    else:
        moving = np.flatnonzero(actor.blendshapes.deltas.any(axis=(0, 2)))
        if not len(moving):  # a face that only its bones move
            moving = np.arange(len(actor.neutral.vertices))
        chosen = moving[np.linspace(0, len(moving) - 1, min(count, len(moving))).astype(np.int64)]
        points, names = SurfacePoints.at_vertices(chosen), tuple(f"point_{i}" for i in range(len(chosen)))
    return Correspondence(names, points, points)


def rest_of(training: Performance, points: Correspondence | None, given: str | None) -> Neutral | None:
    """Return the actor at rest where it is known or given."""
    if points is not None or given is not None:
        names = training.markers.names if training.markers is not None else ()
        stand_in = points or Correspondence(names, SurfacePoints.at_vertices(np.zeros(len(names), np.int64)))
        return training.neutral(stand_in, given)
    return None
