"""An actor's own shapes as the extremes that the layers method needs: no frame has to be picked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.capture.trace import trace
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Note, Rig
from mien.core.arrays import Floats
from mien.core.units import human_centimetre
from mien.retargeting.layers.sources import Recipe, Table, table_of

SAME_CM = 1e-3
"""Extremes of a layer that differ by less than this at every point cannot be told apart."""


def shared_table(actor: Rig, character: Rig) -> Table:
    """Return the extremes of an actor's rig, by layer, of those layers in which the character has two of the same names."""
    mine, theirs = table_of(actor), table_of(character)
    return {layer: own for layer, own in mine.items() if len(set(own) & set(theirs.get(layer, ()))) > 1}


def posed_extremes(actor: Rig, points: Correspondence, table: Table, fps: float) -> tuple[Markers, Examples]:
    """Pose an actor's rig in each of its extremes, one frame each.

    Args:
        actor: the rig.
        points: where it is seen.
        table: layer → extreme → shapes and weights.
        fps: frames per second of the take that is made.

    Returns:
        The take, and which frame shows which extreme.  Extremes that look the same as another of
        their layer at these points are left out, with a note.

    Raises:
        InputError: the points do not say where they are on the actor.
    """
    if points.source is None:
        raise InputError("posing an actor's extremes needs points on the actor's mesh.")
    same = SAME_CM * human_centimetre(points.source.of(actor.neutral.vertices))
    deltas = points.source.of(actor.blendshapes.deltas)
    names: list[str] = []
    hidden: list[str] = []
    rows: list[Floats] = []
    for layer, extremes in table.items():
        weights = np.array([_row(actor, recipe) for recipe in extremes.values()])
        moved = np.tensordot(weights, deltas, axes=1).reshape(len(weights), -1)
        for k, extreme in enumerate(extremes):
            told = (np.abs(moved[:k] - moved[k]).max(axis=1) > same).all()
            (names if told else hidden).append(f"{layer}.{extreme}")
            rows += [weights[k]] * bool(told)
    take = trace(actor, Clip(actor.blendshapes.names, np.array(rows), fps), points.source, points.names)
    if hidden:
        text = (
            f"{len(hidden)} extremes look the same as another at the points and are left out: {', '.join(hidden[:12])}."
        )
        take = replace(take, notes=(*take.notes, Note("extremes-unseen", text)))
    return take, Examples(np.arange(len(names)), tuple(names), np.where(np.eye(len(names)) > 0, 1.0, np.nan))


def _row(actor: Rig, recipe: Recipe) -> Floats:
    """Return `(K,)` weights of the actor's shapes."""
    row = np.zeros(len(actor.blendshapes))
    for shape, weight in recipe.items():
        row[actor.blendshapes.index(shape)] = weight
    return row
