"""How much each frame of the actor looks like each blendshape (Ribera et al. 2017, §4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats

STILL_CM = 1e-6
"""A total displacement below this is rounding, and its direction says nothing."""


@dataclass(frozen=True, eq=False)
class Similarity:
    """Similarities of `K` blendshapes and `F` frames.

    Attributes:
        correlation: `(K, F)` signed, eq. 5.
        trust: `(K,)` 1 for a shape unlike all larger ones, 0 for the most redundant, eq. 6.
        enhanced: `(K, F)` between 0 and 1, contrast raised by trust, eq. 7 and 8.
        between: `(K, K)` signed correlations among the blendshapes (figure 11).
    """

    correlation: Floats
    trust: Floats
    enhanced: Floats
    between: Floats


def similarity(actor: Floats, shapes: Floats, steepness: float = 15.0) -> Similarity:
    """Compare an actor's frames with a character's blendshapes.

    Args:
        actor: `(F, M, 3)` displacements from the actor's neutral.
        shapes: `(K, M, 3)` blendshapes at the same points.
        steepness: `r` of eq. 7; larger separates likely from unlikely more sharply.
    """
    frames, blendshapes = _directions(actor), _directions(shapes)
    correlation = blendshapes @ frames.T
    between = blendshapes @ blendshapes.T
    trust = trust_of(between, np.linalg.norm(shapes, axis=(1, 2)))
    positive = np.maximum(correlation, 0)
    enhanced = (1 - trust[:, None]) * positive + trust[:, None] * contrast(positive, steepness)
    return Similarity(correlation, trust, enhanced, between)


def contrast(positive: Floats, steepness: float) -> Floats:
    """Raise high similarities and lower low ones: `b(c) = e^{rc} / (e^{r/2} + e^{rc})` (eq. 7)."""
    return np.asarray(1 / (1 + np.exp(steepness * (0.5 - positive))))


def trust_of(between: Floats, size: Floats) -> Floats:
    """Return how far each shape can be told from larger ones (eq. 6).

    Args:
        between: `(K, K)` correlations among the blendshapes.
        size: `(K,)` their total displacement.
    """
    order = np.argsort(-size, kind="stable")
    ranked = np.maximum(between[np.ix_(order, order)], 0)
    above = np.tril(ranked, -1).sum(axis=1)
    trust = np.ones(len(size))
    if above.max(initial=0) > 0:
        trust[order] = 1 - above / above.max()
    return trust


def _directions(displacements: Floats) -> Floats:
    """Flatten and normalise; what does not move is like nothing."""
    flat = displacements.reshape(len(displacements), -1)
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    return np.asarray(np.divide(flat, length, out=np.zeros_like(flat), where=length > STILL_CM))
