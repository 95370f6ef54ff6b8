"""Layers put together again: as curves to edit, as vertices, as weights of blendshapes (eq. 5).

The curves of a performance are a clip with the channels `layer.extreme` (the paper's `α`)
and `weight.region.layer` (its `W`).  They belong to no face: the same curves play on every
character with layers, and survive a table program.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mien.core import Anatomy, Blendshapes, Clip, InputError, Note, Rig
from mien.core.arrays import Flags, Floats
from mien.core.units import human_centimetre
from mien.retargeting.layers.model import LayeredFace
from mien.solve import LassoProblem, solve_lasso
from mien.solve.layered import layer_weights
from mien.vocabularies.expressions import LAYER_REGION

SUM_OFF = 1e-4
"""Shares that miss the sum 1 by more than this were edited, not only rounded, and are counted."""


def layer_clip(
    face: LayeredFace, weights: Floats, coefficients: Floats, fps: float, head: Floats | None = None
) -> Clip:
    """Return the curves of a performance in layers.

    Args:
        face: whose layers and regions they are.
        weights: `(F, m, J)`.
        coefficients: `(F, N)`.
        fps: frames per second.
        head: `(F, 4, 4)` head motion, in the space of the character.
    """
    values = np.concatenate([coefficients, weights.reshape(len(weights), -1)], axis=1)
    return Clip((*face.extremes, *face.shares), values, fps, head)


def curves_of(face: LayeredFace, clip: Clip) -> tuple[Floats, Floats, tuple[Note, ...]]:
    """Return weights `(F, m, J)` and coefficients `(F, N)` from edited curves.

    Shares are divided by their sum: raising one lowers the others.  A frame of NaN holds the
    one before.

    Raises:
        InputError: the clip lacks a channel, or shares are negative or all 0 (the frame is named).
    """
    wanted = (*face.extremes, *face.shares)
    missing = [name for name in wanted if name not in clip.names]
    if missing:
        raise InputError(
            f"the curves lack {len(missing)} channels of {face.name} ({', '.join(missing[:6])}); its layers are "
            f"{', '.join(layer.name for layer in face.layers)} and its regions {', '.join(face.regions.names)}."
        )
    values = clip.channels(wanted)
    good = ~np.isnan(values).any(axis=1)
    if not good.any():
        raise InputError("no frame of the curves has values.")
    last = np.maximum.accumulate(np.where(good, np.arange(len(values)), -1))
    values = values[np.where(last < 0, int(np.argmax(good)), last)]
    n, edited = len(face.extremes), np.zeros(len(values), bool)
    coefficients = np.empty((len(values), n))
    for layer, a, b in zip(face.layers, face.starts[:-1], face.starts[1:], strict=True):
        coefficients[:, a:b], off = _shares(values[:, a:b], f"the layer {layer.name!r}")
        edited |= off
    weights = values[:, n:].reshape(len(values), len(face.regions.names), len(face.layers)).copy()
    for region, name in enumerate(face.regions.names):
        weights[:, region], off = _shares(weights[:, region], f"the region {name!r}")
        edited |= off
    notes = []
    if edited.any():
        notes.append(
            Note(
                "shares-scaled", f"in {int(edited.sum())} frames shares did not sum to 1 and were divided by their sum."
            )
        )
    if not good.all():
        notes.append(Note("frames-held", f"{int((~good).sum())} frames without values hold the one before."))
    return weights, coefficients, tuple(notes)


def composed(face: LayeredFace, clip: Clip) -> Floats:
    """Return the face `(F, P, 3)` that curves make of it (eq. 5), without head motion.

    Raises:
        InputError: as `curves_of`.
    """
    weights, coefficients, _ = curves_of(face, clip)
    return face.compose(weights, coefficients)


def split_rig(rig: Rig, face: LayeredFace) -> Rig:
    """Return the rig with its shapes replaced by its extremes, split by region: `emotion.joy@mouth`.

    On it the composition is exact: each split shape's weight is `w_jl α_jk`, see `split_clip`.
    Extremes that do not move a region have no shape for it.  The regions stay with the rig as a
    label of its anatomy.
    """
    names, deltas = [], []
    for name, offsets in zip(face.extremes, face.basis, strict=True):
        for region, label in enumerate(face.regions.names):
            delta = np.where((face.regions.of == region)[:, None], offsets, 0.0)
            if delta.any():
                names.append(f"{name}@{label}")
                deltas.append(delta)
    shapes = Blendshapes(tuple(names), np.array(deltas).reshape(len(names), -1, 3))
    anatomy = rig.anatomy or Anatomy()
    said = replace(anatomy, labels={**anatomy.labels, LAYER_REGION: face.regions})
    return replace(rig, blendshapes=shapes, anatomy=said, correctives=None)


def split_clip(face: LayeredFace, clip: Clip) -> Clip:
    """Return curves as exact weights of the split rig.

    Raises:
        InputError: as `curves_of`.
    """
    weights, coefficients, notes = curves_of(face, clip)
    mixed = layer_weights(face.starts, weights, coefficients)
    names = tuple(f"{name}@{label}" for label in face.regions.names for name in face.extremes)
    values = mixed.reshape(len(mixed), -1)
    moving = np.concatenate(
        [face.basis[:, face.regions.of == region].any(axis=(1, 2)) for region in range(len(face.regions.names))]
    )
    kept = tuple(name for name, m in zip(names, moving, strict=True) if m)
    return Clip(kept, values[:, moving], clip.fps, clip.head, clip.eyes, start=clip.start, notes=(*clip.notes, *notes))


@dataclass(frozen=True, eq=False)
class Projection:
    """The closest weights of a rig's own blendshapes, whatever face the layers make.

    It minimises the mean squared distance over the vertices, with bounds; a rig whose extremes
    are its own shapes and whose shapes stay inside the regions loses nothing.

    Attributes:
        problem: least squares over the shapes [cm of a human face].
        match: `(K, m N)` products of the shapes with every extreme in every region.
        energy: `(m N, m N)` products of those with themselves, for the loss.
    """

    problem: LassoProblem
    match: Floats
    energy: Floats

    def weights(self, mixed: Floats, before: Floats | None = None) -> Floats:
        """Return blendshape weights `(F, K)` for `y_lk` `(F, m, N)`."""
        return solve_lasso(self.problem, mixed.reshape(len(mixed), -1) @ self.match.T, before, tol=1e-9).weights

    def loss(self, mixed: Floats, weights: Floats) -> Floats:
        """Return `(F,)` how far the face that weights make is from the layers' [mm of a human face]."""
        flat = mixed.reshape(len(mixed), -1)
        own = ((weights @ self.problem.gram - 2 * (flat @ self.match.T)) * weights).sum(axis=1)
        left = ((flat @ self.energy) * flat).sum(axis=1) + own
        return np.asarray(10 * np.sqrt(np.maximum(left, 0.0)))


def projection(rig: Rig, face: LayeredFace, bounds: tuple[float, float] | None = (0.0, 1.0)) -> Projection:
    """Prepare the projection of a layered character on its rig's blendshapes.

    Args:
        rig: the character.
        face: the same in layers, on the same vertices.
        bounds: lowest and highest weight, or None.
    """
    centimetre = human_centimetre(rig.neutral.vertices[_moving(rig)])
    scale = 1 / (centimetre * np.sqrt(max(int(_moving(rig).sum()), 1)))
    shapes = rig.blendshapes.deltas.reshape(len(rig.blendshapes), -1) * scale
    masked = []
    for region in range(len(face.regions.names)):
        own = np.repeat(face.regions.of == region, 3)
        masked.append(np.where(own, face.basis.reshape(len(face.basis), -1), 0.0) * scale)
    stacked = np.concatenate(masked)
    low, high = bounds or (-np.inf, np.inf)
    problem = LassoProblem(shapes @ shapes.T, np.array(0.0), np.array(low), np.array(high))
    return Projection(problem, shapes @ stacked.T, stacked @ stacked.T)


def _moving(rig: Rig) -> Flags:
    """Return which vertices any shape moves: the face, without the back of the head."""
    return np.asarray(rig.blendshapes.deltas.any(axis=(0, 2)))


def _shares(values: Floats, what: str) -> tuple[Floats, Flags]:
    total = values.sum(axis=1, keepdims=True)
    wrong = (values < -SUM_OFF).any(axis=1) | ~(total[:, 0] > 0)
    if wrong.any():
        frame = int(np.argmax(wrong))
        raise InputError(
            f"the shares of {what} at frame {frame} are {np.round(values[frame], 4).tolist()[:6]}: none may be negative, "
            "and at least one must be above 0."
        )
    positive = np.maximum(values, 0.0)
    return positive / positive.sum(axis=1, keepdims=True), np.asarray(np.abs(total[:, 0] - 1) > SUM_OFF)
