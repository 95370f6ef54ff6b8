"""The fitted form of every method that gives the actor blendshapes of their own.

Whatever made the shapes (alignment, a warp), a frame is solved the same way.  Live, it is
smoothed by the frame before; in a whole take by both neighbours, unless that is asked not to be.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mien.capture import Stabiliser
from mien.core import Clip, Correspondence, InputError, Markers, Note, Report, Rig
from mien.core.arrays import Flags, Floats
from mien.geometry.align import Similarity, inverse_rigid, transform
from mien.retargeting.contact import Contacts, find_contacts
from mien.retargeting.energy import FrameSolver, frame_solver
from mien.retargeting.movement import MovementSolver
from mien.retargeting.prepare import Prepared
from mien.retargeting.prior import PRIORS
from mien.retargeting.settings import SolveSettings
from mien.retargeting.visibility import cost_of_unseen

POOR_GAIN = 0.4
"""Below this share of the actor's movement, what is fitted is something else."""


class State(NamedTuple):
    """What a frame needs of the one before.

    Attributes:
        weights: `(K,)` the last weights; None before the first frame.
        motion: `(4, 4)` the last head motion, in the actor's space.
        left: `(M, 3)` what the last weights left of the displacements, for methods that match movements [cm].
    """

    weights: Floats | None
    motion: Floats
    left: Floats | None = None


@dataclass(frozen=True, eq=False)
class ShapeRetargeter:
    """An actor's own blendshapes at the markers, and how to solve for their weights.

    Attributes:
        method: the method's name.
        names: `K` shapes of the character.
        markers: `M` markers of the actor.
        stabiliser: holds the head still, or None if it does not move.
        neutral: `(M, 3)` the actor at rest, in the performance's unit.
        centimetre: a human centimetre in that unit.
        placement: from the actor's space to the character's.
        shapes: `(K, M, 3)` the actor's own blendshapes `Δp` [cm].
        solver: the per-frame problem.
        fps: frame rate of the training take, and of live frames.
        evidence: per shape, how well the training take shows it.
        notes: of the fit.
        alignment: what the fit found on the way, for looking into; None once saved.
        contacts: what is made to touch where the actor does; None if nothing is.
    """

    method: str
    names: tuple[str, ...]
    markers: tuple[str, ...]
    stabiliser: Stabiliser | None
    neutral: Floats
    centimetre: float
    placement: Similarity
    shapes: Floats
    solver: FrameSolver
    fps: float
    evidence: Mapping[str, float]
    neutral_frame: int | None
    notes: tuple[Note, ...] = ()
    alignment: Any = None
    contacts: Contacts | None = None

    def retarget(self, performance: Markers) -> tuple[Clip, Report]:
        """Map a take onto the character.

        Args:
            performance: markers; those of the fit must be among them, NaN where missing.

        Returns:
            Weights and head motion of the character, and the report.

        Raises:
            InputError: a marker is unknown, or no frame sees any.
        """
        markers = performance.only(self.markers)
        if not markers.seen.any():
            raise InputError("no frame of the performance sees any of the paired markers.")
        take, motion = self.displacements(markers.points)
        weights, residual = self.solved(take, markers.fps)
        weights = self.touching(weights, take)
        head = None if motion is None else self.placement.conjugate(motion)
        clip = Clip(self.names, weights, markers.fps, head)
        return clip, self._report(take, weights, residual, markers)

    def solved(self, take: Floats, fps: float) -> tuple[Floats, float]:
        """Return weights `(F, K)` of a take `(F, M, 3)` [cm], and the largest KKT residual."""
        return MovementSolver(self.solver, 0.0).clip(take, fps) if self.ahead else self.solver.batch(take, fps)

    def touching(self, weights: Floats, take: Floats) -> Floats:
        """Return weights `(F, K)` as solved for a take `(F, M, 3)` [cm], with what touches in it made to touch."""
        if self.contacts is None:
            return weights
        solver = self.solver
        found = self.contacts.touching(weights, take, (solver.lower, solver.upper), solver.settings.contact)
        return found if solver.correctives is None else solver.correctives.complete(found)

    @property
    def ahead(self) -> bool:
        """Whether frames of a take are tied to the next one, too; only what is convex over a whole take can be."""
        return self.solver.settings.ahead and self.solver.settings.smooth > 0 and self.solver.convex

    @property
    def unseen_are(self) -> str:
        """What becomes of frames that see no marker, for the report."""
        return "are interpolated between the frames around them" if self.ahead else "hold the frame before"

    def start(self) -> State:
        """Begin with no frame before."""
        return State(None, np.eye(4))

    def step(self, state: State, frame: Floats) -> tuple[State, Floats]:
        """Map one frame of markers `(M, 3)`, NaN where missing, to `(K,)` weights."""
        moved, motion = self.still(frame, state.motion)
        weights = self.solver.step(moved, state.weights, self.fps)
        return State(weights, motion), self.touching(weights[None], moved[None])[0]

    def still(self, frame: Floats, motion: Floats) -> tuple[Floats, Floats]:
        """Return how far one frame's points are from the neutral with the head held still, and the head's motion.

        Args:
            frame: `(M, 3)` points, NaN where missing.
            motion: `(4, 4)` of the frame before; kept where too few points tell.

        Returns:
            `(M, 3)` [cm] and `(4, 4)`.
        """
        points = np.asarray(frame, dtype=np.float64)[None]
        if self.stabiliser is not None:
            if (self.stabiliser.stability * ~np.isnan(points[0, :, 0]) > 0).sum() >= 3:
                motion = self.stabiliser(points)[1][0]
            points = transform(inverse_rigid(motion[None]), points)
        return np.asarray((points[0] - self.neutral) / self.centimetre), motion

    def displacements(self, points: Floats) -> tuple[Floats, Floats | None]:
        """Return how far points `(F, M, 3)` are from the neutral with the head held still [cm], and its motion."""
        if self.stabiliser is None:
            return (points - self.neutral) / self.centimetre, None
        still, motion = self.stabiliser(points)
        return (still - self.neutral) / self.centimetre, motion

    def _report(self, take: Floats, weights: Floats, residual: float, markers: Markers) -> Report:
        seen = ~np.isnan(take[..., 0])
        actual = np.where(seen[..., None], take, 0.0)
        fitted = np.tensordot(weights, self.shapes, axes=1) * seen[..., None]
        error = ((fitted - actual) ** 2).sum(axis=2)
        count = seen.sum(axis=1)
        with np.errstate(invalid="ignore"):
            fit = 10 * np.sqrt(np.where(count > 0, error.sum(axis=1) / count, np.nan))
        moved = float((actual**2).sum())
        notes = [*self.notes]
        blind = int((count == 0).sum())
        if blind:
            notes.append(Note("frames-held", f"{blind} frames see no marker and {self.unseen_are}."))
        gain = float((fitted * actual).sum() / moved) if moved > 0 else float("nan")
        if gain < POOR_GAIN:
            text = f"only {gain:.0%} of the actor's movement is found again in the character: check the pairs, or look for stray markers."
            notes.append(Note("poor-fit", text))
        figures = {
            "frames": len(take),
            "fps": markers.fps,
            "neutral_frame": self.neutral_frame,
            "missing_samples": int((~seen).sum()),
            "kkt_residual": residual,
            "active_per_frame": round(float((np.abs(weights) > 1e-4).sum(axis=1).mean()), 3),
            "largest_weight": {
                n: round(float(w), 4) for n, w in zip(self.names, np.quantile(weights, 0.99, axis=0), strict=True)
            },
        }
        return Report(
            self.method,
            fit,
            gain,
            self.evidence,
            self.solver.settings.as_dict(),
            figures,
            tuple(notes),
        )


def shape_retargeter(
    method: str,
    character: Rig,
    prepared: Prepared,
    shapes: Floats,
    settings: SolveSettings,
    evidence: Mapping[str, float] | None = None,
    notes: tuple[Note, ...] = (),
    alignment: Any = None,
) -> ShapeRetargeter:
    """Put together what a frame needs, from the actor's own shapes `(K, M, 3)` [cm]."""
    terms, names = prepared.terms, character.blendshapes.names
    off = settings.kept_at_rest(names)
    if off:
        text = f"{len(off)} shapes are kept at rest, as the parameter off says: {', '.join(off)}."
        notes = (*notes, Note("shapes-off", text))
    prior = PRIORS[settings.prior_kind if settings.prior > 0 else "none"]
    unlikely = prior.quadratic(character, terms.character_centimetre)
    cost = cost_of_unseen(character, prepared.pairs) if settings.unseen else np.ones(len(names))
    confidence = np.asarray(prepared.pairs.confidence)
    solver = frame_solver(shapes, names, unlikely, confidence, settings, cost, character.correctives)
    contacts = None
    if settings.contact > 0:
        contacts, remark = find_contacts(character, prepared, shapes, _free(solver))
        notes = (*notes, remark)
    return ShapeRetargeter(
        method,
        names,
        prepared.pairs.names,
        prepared.stabiliser,
        prepared.neutral.points,
        terms.centimetre,
        terms.placement,
        shapes,
        solver,
        prepared.fps,
        evidence or {},
        prepared.neutral.frame,
        (*prepared.notes, *notes),
        alignment,
        contacts,
    )


def _free(solver: FrameSolver) -> Flags:
    """Return `(K,)` which weights may be changed on their own: no corrective, and none that excludes another."""
    free = np.ones(len(solver.shapes), dtype=bool)
    free[solver.exclusive] = False
    if solver.correctives is not None:
        free[solver.correctives.shapes] = False
    return free


def check_markers(
    training: Markers | Clip, pairs: Correspondence | None, method: str
) -> tuple[Markers, Correspondence]:
    """Return the take and the pairs, once it is sure that both are there.

    Raises:
        InputError: the performance is weights without an actor's rig, or there are no pairs.
    """
    if not isinstance(training, Markers):
        raise InputError(
            f"the method {method!r} needs points in space, but the performance is weights; give the actor's rig with --actor."
        )
    if pairs is None:
        raise InputError(
            f"the method {method!r} needs to know which marker is which point of the character; give --pairs or --landmarks."
        )
    return training, pairs
