"""What the right answer is: an actor's weights in the terms of a character's shapes.

Two notions of right are kept apart.  *Absolute*: the weights as recorded.  *Range*: each
of the actor's shapes divided by the most the actor showed of it in training, so that the
actor's full range is the character's full range; the paper's own notion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mien.core import Blendshapes, InputError, Rig
from mien.core.arrays import Floats
from mien.core.errors import unknown
from mien.geometry.surface import unit
from mien.vocabularies import match, shape_key

SHOWN = 0.1
"""A shape whose 99th percentile in training is below this was not shown: its range says nothing and is left alone."""
MAIN = 0.5
"""A part of a shape with at least this share of the largest part drives it."""
SEAM = 0.15
"""Half the width over which a split shape passes from one side to the other, as a share of the eyes' distance."""


@dataclass(frozen=True, eq=False)
class Semantics:
    """What a character's shapes mean in the actor's.

    Attributes:
        parts: `(K, J)` the actor's own version of shape k is the sum of these shares of the actor's shapes.
        drivers: `(K, J)` the weight of shape k is this mean of the actor's weights; a row sums to 1, or to 0 if
            nothing drives the shape.
    """

    parts: Floats
    drivers: Floats

    @property
    def driven(self) -> np.ndarray:
        """`(K,)` whether the actor has something for each shape."""
        return np.asarray(self.drivers.any(axis=1))


def semantics(
    actor: Sequence[str], character: Sequence[str], table: Mapping[str, Mapping[str, float]] | None = None
) -> Semantics:
    """Relate a character's shapes to an actor's.

    Args:
        actor: `J` shape names.
        character: `K` shape names.
        table: for each shape of the character the shares of the actor's shapes in it; by their names if None.

    Raises:
        InputError: the table names a shape that the actor or the character does not have.
    """
    if table is None:
        parts = (match(actor, character).matrix > 0).astype(np.float64)
    else:
        parts = np.zeros((len(character), len(actor)))
        for name, shares in table.items():
            if name not in character:
                raise InputError(f"the table of meanings names an {unknown('blendshape', name, character)}")
            for part, share in shares.items():
                if part not in actor:
                    raise InputError(f"the table of meanings names an {unknown('shape of the actor', part, actor)}")
                parts[list(character).index(name), list(actor).index(part)] = share
    most = np.abs(parts).max(axis=1, keepdims=True)
    parts = np.divide(parts, most, out=np.zeros_like(parts), where=most > 0)
    main = parts * (np.abs(parts) >= MAIN)
    total = main.sum(axis=1, keepdims=True)
    return Semantics(parts, np.divide(main, total, out=np.zeros_like(main), where=total > 0))


def shown_range(training: Floats) -> tuple[Floats, np.ndarray]:
    """Return `(J,)` the full range of each of the actor's shapes in training `(F, J)`, and whether it was shown.

    The range of a shape that was not shown is 1: it stays as recorded.
    """
    most = np.nanquantile(training, 0.99, axis=0)
    shown = most >= SHOWN
    return np.where(shown, most, 1.0), shown


def split_sides(actor: Rig, character: Sequence[str]) -> Rig:
    """Split shapes of the whole face where a character has a left and a right one.

    The two halves add up to the whole, passing smoothly into each other across the
    midline, so an actor who uses both alike moves as before.

    Args:
        actor: a rig with the landmarks `ibug_36` and `ibug_45`, the outer corners of its right and left eye.
        character: the names of the character's shapes.
    """
    wanted = {shape_key(name).stem for name in character if shape_key(name).side}
    whole = [n for n in actor.blendshapes.names if not shape_key(n).side and shape_key(n).stem in wanted]
    if not whole:
        return actor
    vertices = actor.neutral.vertices
    right, left = (actor.landmarks[name].of(vertices)[0] for name in ("ibug_36", "ibug_45"))
    across = (vertices - (left + right) / 2) @ unit(left - right)
    t = np.clip(across / (2 * SEAM * np.linalg.norm(left - right)) + 0.5, 0, 1)
    to_left = (t * t * (3 - 2 * t))[:, None]
    names, deltas = [], []
    for name, delta in zip(actor.blendshapes.names, actor.blendshapes.deltas, strict=True):
        halves = {name + "_L": delta * to_left, name + "_R": delta * (1 - to_left)} if name in whole else {name: delta}
        names += list(halves)
        deltas += list(halves.values())
    return replace(actor, blendshapes=Blendshapes(tuple(names), np.stack(deltas)))
