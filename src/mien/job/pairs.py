"""Finding out which point of the actor is which point of the character."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mien.capture.neutral import neutral_at
from mien.core import Correspondence, FileError, InputError, Note, Rig, SurfacePoints
from mien.core.arrays import Floats
from mien.geometry.correspond import Placement, marker_points, mesh_points, place, spread_points
from mien.io.documents import join, landmarks_on_markers, landmarks_on_mesh, read_landmarks, read_pairs
from mien.job.performance import Performance, frame_number
from mien.vocabularies.marker_sets import known_landmarks

OWN = Path("-")
"""In place of a landmark file: the side's own landmarks."""
DEFAULT_COUNT = 99
"""As many pairs as the range-of-motion paper has markers."""


def find_pairs(
    performance: Performance,
    character: Rig,
    *,
    pairs: Path | None = None,
    landmarks: tuple[Path, Path] | None = None,
    count: int = DEFAULT_COUNT,
    neutral: str | None = None,
) -> tuple[Correspondence, tuple[Note, ...]]:
    """Return the correspondence from a pairs file, from landmarks, or from what lies beside the files.

    Args:
        performance: the actor's side.
        character: the other.
        pairs: a pairs file.
        landmarks: a landmark file for each side; `-` for a side whose own are to be found: beside
            the file, in the rig, or told by the markers' names.
        count: how many pairs to make from landmarks when the actor is a mesh.
        neutral: frame number of the actor's neutral, if given; with anything else it is found in the take.

    Raises:
        FileError: a file is wrong.
        InputError: there is nothing to make pairs from.
    """
    if pairs is not None:
        names = performance.markers.names if performance.markers is not None else None
        source = performance.actor.neutral if performance.actor is not None else None
        return read_pairs(pairs, character.neutral, names, source), ()
    mine, theirs = (None if path == OWN else path for path in landmarks or (OWN, OWN))
    target = _target_landmarks(character, theirs)
    if performance.markers is not None:
        return _from_markers(performance, character, target, mine, neutral)
    if performance.actor is None:
        raise InputError(f"{performance.path} holds weights; give the actor's rig with --actor, or use --method copy.")
    return _from_mesh(performance.actor, character, target, mine, count)


def landmarks_beside(path: Path | None) -> Path | None:
    """Return `NAME.landmarks.json` beside `NAME.glb`, if it is there."""
    beside = path.with_suffix(".landmarks.json") if path is not None else None
    return beside if beside is not None and beside.is_file() else None


def rig_landmarks(rig: Rig, given: Path | None) -> dict[str, SurfacePoints]:
    """Return a rig's landmarks: given, its own, or from the file beside it."""
    path = given or (None if rig.landmarks else landmarks_beside(rig.source))
    if path is not None:
        return landmarks_on_mesh(read_landmarks(path), rig.neutral, path)
    return dict(rig.landmarks)


def _target_landmarks(character: Rig, given: Path | None) -> dict[str, SurfacePoints]:
    found = rig_landmarks(character, given)
    if not found:
        raise InputError(
            f"nothing says which point of the actor is which point of {character.name}: give --pairs FILE, or --landmarks "
            "SOURCE.json TARGET.json (`-` for a side that has its own) with at least 4 landmarks on both (or put "
            f"{character.name}.landmarks.json beside the character)."
        )
    return found


def _from_markers(
    performance: Performance,
    character: Rig,
    target: dict[str, SurfacePoints],
    given: Path | None,
    neutral: str | None,
) -> tuple[Correspondence, tuple[Note, ...]]:
    markers, frame = performance.bridged, frame_number(neutral)
    rest = (neutral_at(markers, frame) if frame is not None else performance.rest).points
    if given is not None:
        source = landmarks_on_markers(read_landmarks(given), markers, rest, given)
    else:
        names = known_landmarks(markers.names, tuple(target))
        if not names:
            raise InputError(
                "the markers' names are not known to mien, so nothing says where they sit: give --landmarks SOURCE.json TARGET.json "
                '(source entries as {"chin_tip": {"marker": "Chin"}}), or --pairs FILE.'
            )
        source = {landmark: rest[markers.names.index(marker)] for landmark, marker in names.items()}
    shared = _shared(source, target)
    placed_source = np.stack([source[name] for name in shared])
    placed_target = join([target[name] for name in shared])
    result = place(marker_points(rest, placed_source), placed_source, character.neutral, placed_target)
    return Correspondence(markers.names, result.points, None, result.confidence), _notes(result, markers.names)


def _from_mesh(
    actor: Rig, character: Rig, target: dict[str, SurfacePoints], given: Path | None, count: int
) -> tuple[Correspondence, tuple[Note, ...]]:
    source = rig_landmarks(actor, given)
    if not source:
        raise InputError(
            f"the actor's face {actor.name} has no landmarks: give --landmarks SOURCE.json TARGET.json, --pairs FILE, "
            f"or put {actor.name}.landmarks.json beside it."
        )
    shared = _shared(source, target)
    mine, theirs = join([source[n] for n in shared]), join([target[n] for n in shared])
    points = spread_points(actor.neutral, mine, count)
    placed = mine.of(actor.neutral.vertices)
    result = place(mesh_points(actor.neutral, points, mine), placed, character.neutral, theirs)
    names = tuple(shared[:count]) + tuple(f"point_{i}" for i in range(len(shared), count))
    pairs = Correspondence(names, result.points, points, result.confidence)
    keep = _apart(pairs.target.of(character.neutral.vertices)) & (np.asarray(pairs.confidence) > 0)
    return pairs.take(np.flatnonzero(keep)), _notes(result, names)


def _apart(points: Floats) -> np.ndarray:
    """Mark all but the first of points that coincide."""
    keep = np.zeros(len(points), dtype=bool)
    keep[np.unique(points, axis=0, return_index=True)[1]] = True
    return keep


def _shared(
    source: dict[str, object] | dict[str, Floats] | dict[str, SurfacePoints], target: dict[str, SurfacePoints]
) -> list[str]:
    shared = [name for name in source if name in target]
    if len(shared) < 4:
        raise FileError(
            f"the two sides share {len(shared)} landmarks ({', '.join(shared) or 'none'}); at least 4 are needed. "
            f"The actor has {', '.join(list(source)[:8])} …, the character {', '.join(list(target)[:8])} …."
        )
    return shared


def _notes(result: Placement, names: tuple[str, ...]) -> tuple[Note, ...]:
    notes = []
    if result.moved_aside:
        listed = ", ".join(names[i] for i in result.moved_aside[:8])
        notes.append(
            Note(
                "pairs-moved",
                f"{len(result.moved_aside)} points were nearest to the wrong side of a lip or lid and were moved: {listed}.",
            )
        )
    if result.lost:
        listed = ", ".join(names[i] for i in result.lost[:8])
        notes.append(
            Note("pairs-lost", f"{len(result.lost)} points found no place on the character and are left out: {listed}.")
        )
    return tuple(notes)
