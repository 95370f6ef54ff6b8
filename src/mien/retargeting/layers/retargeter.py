"""An actor and a character in the same layers: what one is taken apart into, the other is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from mien.core import Clip, InputError, Markers, Note, Report
from mien.core.arrays import Floats
from mien.geometry.align import Similarity
from mien.retargeting.layers.actor import Actor
from mien.retargeting.layers.compose import Projection, layer_clip
from mien.retargeting.layers.decompose import BEGINNING, Decomposer, Memory, outside, residual_mm
from mien.retargeting.layers.model import LayeredFace
from mien.solve.layered import LayeredSolution, layer_weights

NOTHING_MM = 0.01
"""A projection that moves no more than this on average loses nothing."""


class State(NamedTuple):
    """What a frame needs of the one before.

    Attributes:
        memory: of the layers.
        weights: `(K,)` the last blendshape weights; None before the first frame.
        motion: `(4, 4)` the last head motion, in the actor's space.
    """

    memory: Memory
    weights: Floats | None
    motion: Floats


@dataclass(frozen=True, eq=False)
class LayeredRetargeter:
    """A fitted pair of faces.

    Attributes:
        names: `K` blendshapes of the character.
        actor: the actor's points.
        decomposer: takes them apart.
        character: the character in the same layers.
        projection: makes its blendshape weights of them.
        placement: from the actor's space to the character's.
        fps: frame rate of the training take, and of live frames.
        settings: as asked for.
        neutral_frame: where the rest was found.
        notes: of the fit.
    """

    names: tuple[str, ...]
    actor: Actor
    decomposer: Decomposer
    character: LayeredFace
    projection: Projection
    placement: Similarity
    fps: float
    settings: Mapping[str, Any] = field(default_factory=dict)
    neutral_frame: int | None = None
    notes: tuple[Note, ...] = ()

    @property
    def markers(self) -> tuple[str, ...]:
        """Names of the actor's points."""
        return self.actor.markers

    def retarget(self, performance: Markers) -> tuple[Clip, Report]:
        """Map a take onto the character: weights of its blendshapes, and head motion.

        Raises:
            InputError: a marker is unknown, or no frame sees any.
        """
        found, moved, head, markers = self._take(performance)
        mixed = layer_weights(self.character.starts, found.weights, found.coefficients)
        weights = self.projection.weights(mixed)
        loss = self.projection.loss(mixed, weights)
        return Clip(self.names, weights, markers.fps, head), self._report(found, moved, loss, markers)

    def layers(self, performance: Markers) -> Clip:
        """Return the layers of a take as curves, to edit and to compose on any character, see `compose`."""
        found, _, head, markers = self._take(performance)
        return layer_clip(self.character, found.weights, found.coefficients, markers.fps, head)

    def splits(self, report: Report) -> bool:
        """Return whether an animated file of the character needs shapes split by region to show this result."""
        loss = report.figures["projection_loss_mm"]["max"]
        return bool(self.settings.get("split", True)) and loss > NOTHING_MM

    def start(self) -> State:
        """Begin with no frame before."""
        return State(BEGINNING, None, np.eye(4))

    def step(self, state: State, frame: Floats) -> tuple[State, Floats]:
        """Map one frame of markers `(M, 3)`, NaN where missing, to `(K,)` weights."""
        moved, motion = self.actor.displacements(np.asarray(frame, np.float64)[None], state.motion)
        found, memory = self.decomposer.follow(moved, self.fps, state.memory)
        mixed = layer_weights(self.character.starts, found.weights, found.coefficients)
        weights = self.projection.weights(mixed, state.weights)[0]
        return State(memory, weights, state.motion if motion is None else motion[0]), weights

    def _take(self, performance: Markers) -> tuple[LayeredSolution, Floats, Floats | None, Markers]:
        markers = performance.only(self.markers)
        if not markers.seen.any():
            raise InputError("no frame of the performance sees any of the actor's markers.")
        moved, motion = self.actor.displacements(markers.points)
        head = None if motion is None else self.placement.conjugate(motion)
        return self.decomposer.decompose(moved, markers.fps), moved, head, markers

    def _report(self, found: LayeredSolution, moved: Floats, loss: Floats, markers: Markers) -> Report:
        face = self.decomposer.face
        seen = ~np.isnan(moved[..., 0])
        actual = np.where(seen[..., None], moved, 0.0)
        fitted = (face.compose(found.weights, found.coefficients) - face.rest) * seen[..., None]
        power = float((actual**2).sum())
        beyond = outside(face, found, moved)
        blind = int((~seen.any(axis=1)).sum())
        notes = list(self.notes)
        if blind:
            notes.append(Note("frames-held", f"{blind} frames see no marker and hold the frame before."))
        if not found.converged:
            count = int((found.kkt > 1e-8).sum())
            notes.append(
                Note("not-converged", f"{count} frames stopped with a KKT residual of up to {found.kkt.max():.1e}.")
            )
        figures = {
            "frames": len(moved),
            "fps": markers.fps,
            "neutral_frame": self.neutral_frame,
            "missing_samples": int((~seen).sum()),
            "kkt_residual": float(found.kkt.max()),
            "rounds_per_frame": round(float(found.rounds.mean()), 3),
            "outside": {"mean": round(float(beyond.mean()), 4), "per_frame": np.round(beyond, 4).tolist()},
            "projection_loss_mm": {"mean": round(float(loss.mean()), 4), "max": round(float(loss.max()), 4)},
            "layer_weight": {
                name: round(float(w), 4)
                for name, w in zip(face.shares, found.weights.mean(axis=0).ravel(), strict=True)
            },
        }
        gain = float((fitted * actual).sum() / power) if power > 0 else float("nan")
        report = Report("layers", residual_mm(face, found, moved), gain, {}, dict(self.settings), figures)
        if self.splits(report):
            text = (
                f"the character's own shapes make the layers' face only to within {loss.mean():.2f} mm on average "
                f"({loss.max():.2f} in the worst frame): so do weights (.csv, .npz); an animated file (.glb, .gltf) gets "
                "shapes split by region beside its own, and is exact. --set split=false keeps to its own."
            )
            notes.append(Note("shapes-split", text, self.character.name))
        return replace(report, notes=tuple(notes))
