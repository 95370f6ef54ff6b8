"""`layers`: emotion, speech and blink, taken from the actor and put together on the character.

Kholgade, Matthews, Sheikh (2011): content is transferred, not motion.  Actor and character
need no point in common, only extremes of the same names, so the character may be a globe with
four mouths.

Differs from the paper: head motion is found robustly; the objective is `decompose`'s, whose
units do not depend on the capture; the bias towards closed lips is gentle by default
(`closure`), since at the published strength a face with closed lips is not fitted at all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, InputError, Labels, Markers, Note, Rig
from mien.core.units import human_centimetre
from mien.geometry.align import Similarity
from mien.retargeting.layers.actor import Actor, picked_face, train
from mien.retargeting.layers.compose import projection
from mien.retargeting.layers.decompose import Decomposer, Lips
from mien.retargeting.layers.model import Layer, LayeredFace, shared
from mien.retargeting.layers.retargeter import LayeredRetargeter
from mien.retargeting.layers.sources import SPEECH, picks_of, rig_face, split_notes
from mien.retargeting.prepare import Prepared, prepare
from mien.retargeting.settings import in_range
from mien.retargeting.shape_retargeter import check_markers
from mien.solve.layered import Bias

CLOSED = ("viseme_PP", "PP", "mm", "m", "mbp")
"""Names of the extreme with closed lips, the paper's `α_mm`."""
LIPS = (("ibug_62", "ibug_66"), ("ibug_51", "ibug_57"), ("Mouth_Up", "Mouth_Down"))
"""Markers known to sit at the centres of the lips."""
SAME_CM = 1e-3
"""Extremes that differ by less than this at every point cannot be told apart."""


@dataclass(frozen=True)
class Layers:
    """The layers method.

    Attributes:
        smooth: λ, resistance of weights and coefficients to change, at 30 frames a second and alike at any rate.
        sigma: σ, how near to closed the lips count as closed, in inter-ocular distances.
        closure: the most that closed lips draw the mouth to /m/, 0 to 1; 1 is as published.
        closing: seconds within which lips must have been open for closed ones to count, since lips that
            stay closed are at rest; 0 counts all closed lips, as published.
        lips: the markers at the centres of the upper and the lower lip; known ones are found if empty.
        masks: vertex groups of the character that are its regions, in the order of the actor's
            (face, mouth, eyes); told from what moves them if empty.
        planar: markers that are 2-D points of an image.
        bounds: lowest and highest blendshape weight, or None for no bounds.
        split: whether an animated file of the character gets shapes split by region where its own cannot
            make the layers' face; weights are always those of its own.
    """

    name: ClassVar[str] = "layers"
    about: ClassVar[str] = "emotion, speech and blink onto a face of any structure (Kholgade et al. 2011)"
    needs: ClassVar[str] = "markers or an animated face, and frames picked as extremes; or pairs or landmarks"
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "paper": {"sigma": 0.02, "closure": 1.0, "closing": 0.0, "split": False}
    }

    smooth: float = 0.0001
    sigma: float = 0.02
    closure: float = 0.0001
    closing: float = 0.05
    lips: Sequence[str] = ()
    masks: Sequence[str] = ()
    planar: Sequence[str] = ()
    bounds: tuple[float, float] | None = (0.0, 1.0)
    split: bool = True

    def __post_init__(self) -> None:
        in_range(self, smooth=(0, np.inf), sigma=(1e-6, np.inf), closure=(0, 1), closing=(0, np.inf))
        if len(self.lips) not in (0, 2):
            raise InputError(f"lips must be two markers, the upper and the lower lip, but are {', '.join(self.lips)}.")

    def fit(
        self,
        character: Rig,
        training: Markers | Clip,
        pairs: Correspondence | None = None,
        *,
        neutral: Neutral | None = None,
        rigid: Sequence[str] = (),
        head_moves: bool = True,
        examples: Examples | None = None,
    ) -> LayeredRetargeter:
        """Bring an actor and a character into the same layers.

        Args:
            character: the rig; its extremes are told from its blendshapes' names, see `table_of`.
            training: markers; the take in which the extremes were picked.
            pairs: which marker is which point of the character; used only without examples.
            neutral: the actor at rest; found in the take if None.
            rigid: markers known to ride on the skull.
            head_moves: whether there is head motion to take out.
            examples: the frames that show the actor's extremes, one each, named `layer.extreme`. Without
                them the character's own extremes, scaled and turned onto the actor, stand for the actor's.

        Raises:
            InputError: as `prepare` and `picked_face`; or the two sides have no layer in common.
        """
        if examples is None:
            take, correspondence = check_markers(training, pairs, self.name)
            prepared = prepare(character, take, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves)
            target = rig_face(character, masks=self.masks)
            actor = _actor_of(prepared)
            face, unseen = _guessed(prepared, target)
            placement, frame, notes = prepared.terms.placement, prepared.neutral.frame, (*prepared.notes, *unseen)
            importance = np.asarray(prepared.pairs.confidence)
        else:
            if not isinstance(training, Markers):
                raise InputError(
                    f"the method {self.name!r} needs points in space, but the performance is weights; give the actor's rig with --actor."
                )
            target = rig_face(character, masks=self.masks)
            trained = train(training, neutral=neutral, rigid=rigid, planar=self.planar, head_moves=head_moves)
            actor = trained.actor
            face = picked_face(trained, picks_of(examples))
            placement, frame, notes = _centred(actor, character), trained.neutral_frame, trained.notes
            importance = np.ones(len(actor.markers))
        face, target, dropped = shared(face, target)
        lips, said = self._lips(face, actor.markers)
        decomposer = Decomposer(face, importance / importance.mean(), self.smooth, lips)
        return LayeredRetargeter(
            character.blendshapes.names,
            actor,
            decomposer,
            target,
            projection(character, target, self.bounds),
            placement,
            training.fps,
            asdict(self),
            frame,
            (*notes, *split_notes(character), *dropped, *said),
        )

    def _lips(self, face: LayeredFace, markers: tuple[str, ...]) -> tuple[Lips | None, tuple[Note, ...]]:
        """Say when the lips are closed, where markers and extremes tell."""
        known = [tuple(self.lips)] if self.lips else LIPS
        pair = next((p for p in known if set(p) <= set(markers)), None)
        if self.lips and pair is None:
            raise InputError(f"the lips {' and '.join(self.lips)} are not both among the actor's markers.")
        speech = next((j for j, layer in enumerate(face.layers) if layer.name == SPEECH), None)
        extremes = () if speech is None else face.layers[speech].extremes
        shut = next((e for e in CLOSED if e in extremes), None)
        if pair is None or speech is None or shut is None or self.closure == 0:
            why = (
                "no marker is known to sit on the lips"
                if pair is None
                else "no extreme of speech is known to close the lips"
            )
            said = () if self.closure == 0 else (Note("lips-free", f"{why}, so nothing draws closed lips to closed."),)
            return None, said
        upper, lower = (markers.index(name) for name in pair)
        layer = face.layers[speech]
        target = np.eye(len(extremes))[extremes.index(shut)]
        posed = face.rest + layer.offsets[extremes.index(shut)]
        closed = float(np.linalg.norm(posed[upper] - posed[lower]))
        bias = Bias(int(face.regions.of[upper]), speech, target)
        return Lips(upper, lower, closed, self.sigma, self.closure, self.closing, bias), ()


def _actor_of(prepared: Prepared) -> Actor:
    count = len(prepared.pairs)
    return Actor(
        prepared.pairs.names,
        prepared.neutral.points,
        np.full(count, prepared.terms.centimetre),
        prepared.stabiliser,
        np.zeros(count, bool),
    )


def _guessed(prepared: Prepared, target: LayeredFace) -> tuple[LayeredFace, tuple[Note, ...]]:
    """Return the character's own extremes at the paired points, on the actor [cm], without those the points cannot tell apart."""
    terms, points = prepared.terms, prepared.pairs.target
    layers, hidden = [], []
    for layer in target.layers:
        offsets = terms.placement.invert_vectors(points.of(layer.offsets)) / terms.centimetre
        flat = offsets.reshape(len(offsets), -1)
        distance = np.abs(flat[:, None] - flat).max(axis=2)
        kept = [k for k in range(len(flat)) if not (distance[k, :k] <= SAME_CM).any()]
        hidden += [f"{layer.name}.{e}" for k, e in enumerate(layer.extremes) if k not in kept]
        if len(kept) > 1:
            layers.append(Layer(layer.name, tuple(layer.extremes[k] for k in kept), offsets[kept]))
    if not layers:
        raise InputError("no extreme of the character moves a paired point; spread the pairs over the face.")
    face = LayeredFace(terms.actor_neutral, tuple(layers), _regions_at(prepared.pairs, target), "the actor")
    text = f"{len(hidden)} extremes look the same as another at the paired points and are left out: {', '.join(hidden[:12])}."
    return face, (Note("extremes-unseen", text),) if hidden else ()


def _regions_at(pairs: Correspondence, target: LayeredFace) -> Labels:
    """Return the region of the character that each pair lies in."""
    nearest = pairs.target.corners[np.arange(len(pairs)), pairs.target.weights.argmax(axis=1)]
    return Labels(target.regions.names, target.regions.of[nearest])


def _centred(actor: Actor, character: Rig) -> Similarity:
    """Place the actor on a character without any point in common: upright, of the same size, centre on centre."""
    solid = actor.rest[~actor.planar] if (~actor.planar).any() else actor.rest
    vertices = character.neutral.vertices
    scale = human_centimetre(vertices) / human_centimetre(solid)
    shift = vertices.mean(axis=0) - scale * solid.mean(axis=0)
    return Similarity(scale, np.eye(3), shift, float("nan"), float("nan"))
