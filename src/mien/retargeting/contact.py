"""Where the actor's lids and lips touch, the character's are to touch, too.

A few markers say little about the last millimetre of a blink.  Each opening of the character,
an eye or the mouth, is known by opposing landmarks; the actor's is read from the paired points
above and below it.  As the actor's closes, a gap between the character's landmarks costs more
and more: a quadratic form in the weights for each opening, which enters the solve of a frame
in the measure in which the actor's opening is `closed`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.core import Note, Rig, SurfacePoints
from mien.core.arrays import Flags, Floats
from mien.geometry.surface import unit
from mien.retargeting.prepare import Prepared
from mien.vocabularies.openings import LIDS, LIPS

WIDTH_CM = 1.0
"""A marker tells of an opening if it is within this of a landmark there, on the same side of it."""
BLINK = 0.3
"""A take whose lids never come closer by this share of the character's opening shows no blink."""
PARTED_CM = 0.15
"""A take whose lips never part by this shows nothing about their contact."""
TOUCHING_CM = 0.06
"""Lips touch while they are less than this above the rest, in which they do on every face."""
ALMOST = (0.75, 0.95)
"""Closed this far of the way, contact begins to count, and counts in full."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """The openings of a character, and how to read the actor's.

    Attributes:
        names: `R` openings.
        forms: `(R, K, K)` cost of a gap as a quadratic form in the weights, as added to a Gram matrix.
        pulls: `(R, K)` the same as added to a data vector.
        reading: `(R, M, 3)` how displacements of the markers [cm] open the actor's.
        open, shut: `(R,)` what is read where nothing is closed, and where all is [cm].
    """

    names: tuple[str, ...]
    forms: Floats
    pulls: Floats
    reading: Floats
    open: Floats
    shut: Floats

    def closed(self, take: Floats) -> Floats:
        """Return how closed each opening of the actor is, `(…, R)` from 0 to 1, in frames `(…, M, 3)` [cm].

        An opening of which a marker is missing counts as open.
        """
        read = np.tensordot(np.nan_to_num(take), self.reading, axes=([-2, -1], [1, 2]))
        missing = np.asarray(np.isnan(take).any(axis=-1), dtype=np.float64)
        blind = missing @ np.asarray(self.reading.any(axis=2), dtype=np.float64).T > 0
        way = (self.open - read) / (self.open - self.shut)
        t = np.clip((way - ALMOST[0]) / (ALMOST[1] - ALMOST[0]), 0, 1)
        return np.where(blind, 0.0, t * t * (3 - 2 * t))


@dataclass(frozen=True, eq=False)
class _Opening:
    """An opening of the character: points above and below it, and the way they stand apart."""

    above: SurfacePoints
    below: SurfacePoints
    up: Floats

    def apart(self, vertices: Floats) -> Floats:
        """Return how far the upper points are above the lower ones, `(…, P)`."""
        return np.asarray((self.above.of(vertices) - self.below.of(vertices)) @ self.up)


def find_contacts(character: Rig, prepared: Prepared, strength: float) -> tuple[Contacts | None, Note]:
    """Return the openings that both character and take know, and a note that says which; None if there is none.

    Args:
        character: a rig with iBUG landmarks.
        prepared: the training take beside it.
        strength: the cost of a squared gap [1/cm²], beside the mean squared misfit.
    """
    up = _upwards(character)
    rows = {}
    for name, pairs in {**LIDS, **LIPS}.items():
        if up is not None and _named(character, pairs):
            opening = _Opening(*_sides(character, pairs), up)
            reading = _reading(opening, character, prepared)
            limits = None if reading is None else _limits(name, opening, reading, character, prepared)
            if limits is not None:
                rows[name] = (*_cost(name, opening, character, prepared, strength), reading, *limits)
    if not rows:
        text = "no contact is made: it needs iBUG landmarks on lids or lips, markers above and below, and a take that closes them."
        return None, Note("contact-unknown", text, character.name)
    contacts = Contacts(tuple(rows), *(np.array(part) for part in zip(*rows.values(), strict=True)))
    return contacts, Note("contact", f"made to touch where the actor's do: {', '.join(rows)}.", character.name)


def _cost(name: str, opening: _Opening, character: Rig, prepared: Prepared, strength: float) -> tuple[Floats, Floats]:
    """Return `(K, K)` and `(K,)` of the mean squared gap; lips meet at rest, so their rest is no gap."""
    centimetre = prepared.terms.character_centimetre
    change = opening.apart(character.blendshapes.deltas) / centimetre
    rest = opening.apart(character.neutral.vertices) / centimetre * (name not in LIPS)
    share = 2 * strength / len(rest)
    return np.asarray(share * change @ change.T), np.asarray(-share * change @ rest)


def _limits(
    name: str, opening: _Opening, reading: Floats, character: Rig, prepared: Prepared
) -> tuple[float, float] | None:
    """Return what is read where nothing is closed and where all is; None if the take does not show it.

    Lids are shut when they have come as close as the character's are apart, or, where markers
    off their edges never show as much, as close as they ever come.
    """
    take = prepared.take[~np.isnan(prepared.take).any(axis=(1, 2))]
    read = np.tensordot(take, reading, axes=([1, 2], [0, 1]))
    if name in LIPS:
        return (TOUCHING_CM / (1 - ALMOST[0]), 0.0) if np.quantile(read, 0.95) > PARTED_CM else None
    most = float(np.quantile(read, 0.005))
    rest = opening.apart(character.neutral.vertices).mean() / prepared.terms.character_centimetre
    return (0.0, max(most, -float(rest))) if most < -BLINK * rest else None


def _reading(opening: _Opening, character: Rig, prepared: Prepared) -> Floats | None:
    """Return `(M, 3)`: the mean rise of the markers above an opening less that of those below; None if a side has none."""
    vertices, terms = character.neutral.vertices, prepared.terms
    markers = prepared.pairs.target.of(vertices)
    tops, bottoms = opening.above.of(vertices), opening.below.of(vertices)
    middle = np.concatenate([tops, bottoms]).mean(axis=0) @ opening.up
    along = unit(terms.placement.invert_vectors(opening.up))
    reading = np.zeros((len(markers), 3))
    for ends, side in ((tops, 1.0), (bottoms, -1.0)):
        away = np.linalg.norm(markers[:, None] - ends, axis=2).min(axis=1) / terms.character_centimetre
        beside: Flags = (side * (markers @ opening.up - middle) >= 0) & (away < WIDTH_CM)
        share = np.where(beside, np.exp(-((2 * away / WIDTH_CM) ** 2)), 0.0)
        if not share.any():
            return None
        reading += side * (share / share.sum())[:, None] * along
    return reading


def _upwards(character: Rig) -> Floats | None:
    """Return the direction in which lids stand apart at rest; None without their landmarks."""
    pairs = [pair for pairs in LIDS.values() for pair in pairs]
    if not _named(character, pairs):
        return None
    above, below = (side.of(character.neutral.vertices) for side in _sides(character, pairs))
    return np.asarray(unit(unit(above - below).mean(axis=0)))


def _named(character: Rig, pairs: Sequence[tuple[int, int]]) -> bool:
    return all(f"ibug_{n}" in character.landmarks for pair in pairs for n in pair)


def _sides(character: Rig, pairs: Sequence[tuple[int, int]]) -> tuple[SurfacePoints, SurfacePoints]:
    above, below = ([character.landmarks[f"ibug_{pair[i]}"] for pair in pairs] for i in (0, 1))
    return _joined(above), _joined(below)


def _joined(points: Sequence[SurfacePoints]) -> SurfacePoints:
    return SurfacePoints(np.concatenate([p.corners for p in points]), np.concatenate([p.weights for p in points]))
