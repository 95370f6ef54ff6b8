"""The actor's side: captured points brought to rest, and the actor's face in layers at them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.capture import Neutral, Stabiliser, fill_gaps, find_neutral, learn_stabiliser
from mien.core import InputError, Labels, Markers, Note
from mien.core.arrays import Flags, Floats
from mien.core.units import human_centimetre
from mien.retargeting.layers.model import LayeredFace, natural_regions
from mien.retargeting.layers.planar import PlanarStabiliser, planar_stabiliser
from mien.retargeting.layers.sources import Pick, picked_layers
from mien.retargeting.layers.still import hold_still

STILL_CM = 0.05
"""A take in which no point ever leaves rest by this much shows no movement."""


@dataclass(frozen=True, eq=False)
class Actor:
    """Points of an actor: 3-D markers and 2-D image points, each with a unit and a head motion of its own.

    Attributes:
        markers: `M` names.
        rest: `(M, 3)` the points at rest, in the performance's units; planar ones have z = 0.
        centimetre: `(M,)` the length of a human centimetre at each point.
        stabiliser: holds the 3-D points still; None if the head does not move.
        planar: `(M,)` which points are planar.
        planar_stabiliser: holds those still; None if there are none.
    """

    markers: tuple[str, ...]
    rest: Floats
    centimetre: Floats
    stabiliser: Stabiliser | None
    planar: Flags
    planar_stabiliser: PlanarStabiliser | None = None

    def displacements(self, points: Floats, before: Floats | None = None) -> tuple[Floats, Floats | None]:
        """Return displacements from rest with the head held still `(F, M, 3)` [cm], and the 3-D head motion.

        Args:
            points: `(F, M, 3)` in the performance's units; NaN where missing.
            before: `(4, 4)` the head motion that frames keep which see too little to tell it.
        """
        still = np.array(points, np.float64)
        motion = None
        solid = ~self.planar
        if self.stabiliser is not None:
            steady, motion = np.ascontiguousarray(still[:, solid]), np.empty((len(still), 4, 4))
            held = np.empty_like(steady)
            stability, softness = np.array(self.stabiliser.stability), float(self.stabiliser.softness)
            hold_still(
                self.rest[solid], stability, softness, steady, np.eye(4) if before is None else before, held, motion
            )
            still[:, solid] = held
        if self.planar_stabiliser is not None:
            still[:, self.planar, :2], _ = self.planar_stabiliser(still[:, self.planar, :2])
            seen = ~np.isnan(still[:, self.planar, 0])
            still[:, self.planar, 2] = np.where(seen, 0.0, np.nan)
        return (still - self.rest) / self.centimetre[:, None], motion


@dataclass(frozen=True, eq=False)
class Training:
    """A training take, prepared.

    Attributes:
        actor: the actor's side.
        take: `(F, M, 3)` displacements from rest [cm].
        neutral_frame: where the rest was found, if in the take.
        notes: what was settled, filled or left out.
    """

    actor: Actor
    take: Floats
    neutral_frame: int | None
    notes: tuple[Note, ...]


def train(
    markers: Markers,
    *,
    neutral: Neutral | None = None,
    rigid: Sequence[str] = (),
    planar: Sequence[str] = (),
    head_moves: bool = True,
) -> Training:
    """Prepare a take whose frames show an actor's extremes.

    Args:
        markers: the take; markers that are never seen are left out.
        neutral: the actor at rest at these markers; found in the take if None.
        rigid: markers that ride on the skull (a headband); the only ones that say where the head is.
        planar: names of points that are 2-D, in x and y.
        head_moves: whether there is head motion to take out.

    Raises:
        InputError: no marker is seen, no frame sees all, or a named marker is unknown.
    """
    markers.index([*rigid, *planar])
    seen = np.asarray(markers.seen.any(axis=0))
    if not seen.any():
        raise InputError("no frame of the training take sees any marker.")
    notes = []
    if not seen.all():
        gone = [name for name, s in zip(markers.names, seen, strict=True) if not s]
        notes.append(
            Note("markers-never-seen", f"{len(gone)} markers are never seen and left out: {', '.join(gone[:8])}.")
        )
    kept = fill_gaps(markers.only([name for name, s in zip(markers.names, seen, strict=True) if s]))
    flat = np.isin(kept.names, planar)
    frame = None if neutral is None else neutral.frame
    if neutral is None:
        found = find_neutral(kept.only([name for name, f in zip(kept.names, flat, strict=True) if not f]))
        frame = found.frame
        rest = kept.points[frame].copy()
        rest[~flat] = found.points
    else:
        rest = np.array(neutral.points[seen])
    if np.isnan(rest).any():
        raise InputError("the neutral does not see every point; choose another frame for it.")
    actor = make_actor(kept.names, rest, kept.points, rigid=rigid, planar=planar, head_moves=head_moves)
    take, _ = actor.displacements(kept.points)
    return Training(actor, take, frame, (*kept.notes, *notes))


def make_actor(
    names: tuple[str, ...],
    rest: Floats,
    points: Floats,
    *,
    rigid: Sequence[str] = (),
    planar: Sequence[str] = (),
    head_moves: bool = True,
) -> Actor:
    """Learn an actor's units and head motion from a take `(F, M, 3)` and the points at rest `(M, 3)`.

    Raises:
        InputError: only some 3-D points are too few, or one or two rigid markers are named.
    """
    flat = np.isin(names, planar)
    rest = np.array(rest)
    rest[flat, 2] = 0.0
    centimetre = np.empty(len(names))
    if (~flat).any():
        centimetre[~flat] = human_centimetre(rest[~flat])
    stabiliser = None
    if head_moves and (~flat).any():
        solid = [name for name, f in zip(names, flat, strict=True) if not f]
        stabiliser = learn_stabiliser(
            rest[~flat], points[:, ~flat], [solid.index(name) for name in rigid if name in solid]
        )
    flattener = None
    if flat.any():
        centimetre[flat] = human_centimetre(rest[flat, :2])
        flattener = planar_stabiliser(rest[flat, :2])
    return Actor(names, rest, centimetre, stabiliser, flat, flattener)


def picked_face(training: Training, picks: Sequence[Pick], regions: Labels | None = None) -> LayeredFace:
    """Return the actor in layers, from frames that show the extremes.

    Args:
        training: the prepared take.
        picks: which frame shows which extreme.
        regions: of the points; told from what moves them if None.

    Raises:
        InputError: as `picked_layers`; or the take shows no movement.
    """
    take, actor = training.take, training.actor
    reach = np.nanmax(np.linalg.norm(take, axis=2), initial=0.0)
    if not reach > STILL_CM:
        raise InputError(
            f"the training take of {len(take)} frames shows no movement (no point leaves the neutral by more than "
            f"{reach * 10:.2f} mm), so its frames are no extremes."
        )
    layers = picked_layers(picks, take, actor.markers)
    rest = actor.rest / actor.centimetre[:, None]
    return LayeredFace(rest, layers, natural_regions(layers) if regions is None else regions, "the actor")
