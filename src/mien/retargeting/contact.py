"""Where the actor's lids and lips touch, the character's are to touch, too.

A few markers say little about the last millimetre of a blink, and a solve that weighs all of
them alike leaves it open.  Each opening of the character, an eye or the mouth, is known by
opposing landmarks; the actor's is read from the paired points above and below it.  As the
actor's closes, the character's gap is brought to what that reading says, after the solve and
with the least movement of the skin: inside the solve, shapes that no marker tells apart would
pay for the gap.  Lids are only closed further; lips follow both ways, because sparsity also
holds lips shut that the actor parts a little.
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
CLOSING = (0.5, 0.7)
"""Lids closed this far of the way: contact begins to count, and counts in full."""
TOUCHING_CM = (0.10, 0.02)
"""Lips read as this far apart: the same.  At rest, which is 0, they touch on every face; nearer than the second they do."""
LEAST_MOVED = 1e-3
"""A shape whose squared movement of the skin is below this share of the largest counts as having this share."""
SETTLED_CM = 1e-6
"""A gap this near to what is wanted is there."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """The openings of a character, and how to read the actor's.

    Attributes:
        names: `R` openings.
        reading: `(R, M, 3)` how displacements of the markers [cm] open the actor's.
        begin, full: `(R,)` read where contact begins to count, and counts in full [cm].
        shut: `(R,)` read where the character's is closed [cm]; less is no more closed.
        follow: `(R,)` how far the character's opens for each centimetre read beyond that.
        parts: `(R,)` whether an opening is parted, too, if it is less open than what is read.
        rest: `(R,)` the character's gap at rest [cm].
        opening: `(R, K)` what each weight adds to it [cm].
        ways: `(R, K)` in which proportion weights change to close it.
    """

    names: tuple[str, ...]
    reading: Floats
    begin: Floats
    full: Floats
    shut: Floats
    follow: Floats
    parts: Flags
    rest: Floats
    opening: Floats
    ways: Floats

    def read(self, take: Floats) -> tuple[Floats, Floats]:
        """Return how closed each opening of the actor is, and the gap it asks of the character.

        Args:
            take: `(F, M, 3)` displacements of the markers [cm]; NaN where one is missing.

        Returns:
            `(F, R)` from 0 to 1, 0 where a marker of the opening is missing; and `(F, R)` [cm].
        """
        read = np.tensordot(np.nan_to_num(take), self.reading, axes=([1, 2], [1, 2]))
        missing = np.asarray(np.isnan(take).any(axis=2), dtype=np.float64)
        blind = missing @ np.asarray(self.reading.any(axis=2), dtype=np.float64).T > 0
        t = np.clip((self.begin - read) / (self.begin - self.full), 0, 1)
        return np.where(blind, 0.0, t * t * (3 - 2 * t)), self.follow * np.maximum(read - self.shut, 0)

    def touching(self, weights: Floats, take: Floats, limits: tuple[Floats, Floats], strength: float) -> Floats:
        """Return weights `(F, K)` whose gaps go with the actor's where these close.

        Args:
            weights: `(F, K)` as solved.
            take: `(F, M, 3)` displacements of the markers [cm].
            limits: `(K,)` the lowest and the highest weights.
            strength: how much of the way from the gap that was solved for to the one that is asked for.
        """
        found = weights.copy()
        closed, wanted = self.read(take)
        for r in range(len(self.names)):
            lack = wanted[:, r] - self.rest[r] - found @ self.opening[r]
            if self.parts[r]:  # skin that overlaps is closed
                lack = np.where(wanted[:, r] > 0, lack, np.minimum(lack, 0))
            else:
                lack = np.minimum(lack, 0)
            lack *= strength * closed[:, r]
            frames = np.flatnonzero(np.abs(lack) > SETTLED_CM)
            found[frames] = _moved(found[frames], lack[frames], self.opening[r], self.ways[r], limits)
        return found


def _moved(weights: Floats, lack: Floats, opening: Floats, ways: Floats, limits: tuple[Floats, Floats]) -> Floats:
    """Return weights `(F, K)` that change a gap by `lack` `(F,)`, or as far as the limits let them.

    The least movement within limits is a common step along the ways, cut off at the limits: weights
    that meet one are left there, and the others make up for them.
    """
    lower, upper = limits
    found, left = weights.copy(), lack.copy()
    for _ in range(weights.shape[1]):
        onward = np.sign(left)[:, None] * ways
        room = np.where(onward > 0, found < upper, found > lower) & (ways != 0)
        slope = room @ (ways * opening)
        step = np.divide(left, slope, out=np.zeros_like(left), where=slope > 0)
        found = np.clip(found + step[:, None] * room * ways, lower, upper)
        left = lack - (found - weights) @ opening
        if not (np.abs(left) > SETTLED_CM)[slope > 0].any():
            break
    return found


@dataclass(frozen=True, eq=False)
class _Opening:
    """An opening of the character: points above and below it, and the way they stand apart."""

    above: SurfacePoints
    below: SurfacePoints
    up: Floats

    def apart(self, vertices: Floats) -> Floats:
        """Return how far the upper points are above the lower ones on average, `(…)`."""
        return np.asarray(((self.above.of(vertices) - self.below.of(vertices)) @ self.up).mean(axis=-1))


def find_contacts(character: Rig, prepared: Prepared, shapes: Floats, movable: Flags) -> tuple[Contacts | None, Note]:
    """Return the openings that both character and take know, and a note that says which; None if there is none.

    Args:
        character: a rig with iBUG landmarks.
        prepared: the training take beside it.
        shapes: `(K, M, 3)` the actor's own blendshapes [cm].
        movable: `(K,)` which weights may be changed.
    """
    up = _upwards(character)
    deltas, centimetre = character.blendshapes.deltas, prepared.terms.character_centimetre
    movement: Floats = (deltas**2).sum(axis=(1, 2)) / centimetre**2
    ease = np.where(movable, 1 / np.maximum(movement, LEAST_MOVED * float(movement.max())), 0.0)
    rows = {}
    for name, pairs in {**LIDS, **LIPS}.items():
        if up is None or not _named(character, pairs):
            continue
        opening = _Opening(*_sides(character, pairs), up)
        reading = _reading(opening, character, prepared)
        if reading is None:
            continue
        change = opening.apart(deltas) / centimetre
        rest = float(opening.apart(character.neutral.vertices)) / centimetre
        shown = np.tensordot(shapes, reading, axes=([1, 2], [0, 1]))
        ratio = float(shown @ change / max(float(shown @ shown), 1e-12))
        limits = _limits(name in LIPS, rest, ratio, reading, prepared)
        if limits is not None:
            rows[name] = (reading, *limits, name in LIPS, 0.0 if name in LIPS else rest, change, ease * change)
    if not rows:
        text = "no contact is made: it needs iBUG landmarks on lids or lips, markers above and below, and a take that closes them."
        return None, Note("contact-unknown", text, character.name)
    contacts = Contacts(tuple(rows), *(np.array(part) for part in zip(*rows.values(), strict=True)))
    return contacts, Note("contact", f"made to touch where the actor's do: {', '.join(rows)}.", character.name)


def _limits(
    lips: bool, rest: float, ratio: float, reading: Floats, prepared: Prepared
) -> tuple[float, float, float, float] | None:
    """Return `begin`, `full`, `shut` and `follow` of an opening; None if the take does not show it.

    `ratio` is how far the character's opens where the actor's is read as opening by one.  Lids are
    shut when by that the character's are, or, where markers off their edges never show as much,
    as close as they ever come.
    """
    take = prepared.take[~np.isnan(prepared.take).any(axis=(1, 2))]
    if not len(take) or not ratio > 0:
        return None
    read = np.tensordot(take, reading, axes=([1, 2], [0, 1]))
    if lips:
        return (*TOUCHING_CM, TOUCHING_CM[1], ratio) if np.quantile(read, 0.95) > PARTED_CM else None
    closest = float(np.quantile(read, 0.005))
    shut = max(closest, -rest / ratio)
    return (CLOSING[0] * shut, CLOSING[1] * shut, shut, -rest / shut) if closest < -BLINK * rest else None


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
