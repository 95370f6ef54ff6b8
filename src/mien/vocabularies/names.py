"""Telling that two spellings name the same shape, and mapping weights between them.

`eyeBlinkLeft`, `EyeBlink.L` and `blendShape1.eye_blink_left` are one shape; a rig
may also hold one `browInnerUp` where another has a left and a right one.  Comparing
names as strings loses most of a performance on the way, so names are compared as
(stem, side).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mien.core import InputError
from mien.core.arrays import Floats

_SIDES = {"l": "L", "left": "L", "r": "R", "right": "R"}
_MOVES_SIDEWAYS = {"jaw", "jawsideways", "mouth", "lips", "tongue", "head", "eyelook", "eyeslook"}
"""Stems after which left and right are directions of the whole, not halves of it."""

_NAMESPACE = re.compile(r"[.:|]")
_WORD_BREAK = re.compile(r"[\W_]+|(?<=[a-z0-9])(?=[A-Z])")


class ShapeKey(NamedTuple):
    """What a shape is, whatever its spelling.

    Attributes:
        stem: lower-case letters and digits without separators.
        side: `L`, `R`, or empty for a shape of the whole face.
    """

    stem: str
    side: str


@dataclass(frozen=True, eq=False)
class NameMatch:
    """How the weights of one list of shapes give the weights of another.

    Attributes:
        source: `K_source` names.
        target: `K_target` names.
        matrix: `(K_target, K_source)`; `target_weights = matrix @ source_weights`.
        unmatched_source: names that drive nothing.
        unmatched_target: names that nothing drives; their weight is 0.
    """

    source: tuple[str, ...]
    target: tuple[str, ...]
    matrix: Floats
    unmatched_source: tuple[str, ...]
    unmatched_target: tuple[str, ...]

    def apply(self, values: Floats) -> Floats:
        """Map weights over time, `(F, K_source)` to `(F, K_target)`.

        A NaN reaches only the shapes it drives, which a plain matrix product would not keep.

        Raises:
            InputError: the number of columns is not `K_source`.
        """
        if values.ndim != 2 or values.shape[1] != len(self.source):
            raise InputError(f"weights of shape {values.shape} do not fit the {len(self.source)} source shapes.")
        mapped = np.zeros((len(values), len(self.target)))
        for row, factors in enumerate(self.matrix):
            used = np.flatnonzero(factors)
            mapped[:, row] = values[:, used] @ factors[used]
        return mapped


def shape_key(name: str) -> ShapeKey:
    """Return the stem and side of a shape's name.

    A leading `blendShape1.` or `face:` is dropped; the side may stand at either end.
    `jawLeft` and its like have no side: the whole jaw moves left.
    """
    words = [word.lower() for word in _WORD_BREAK.split(_without_namespace(name)) if word]
    if len(words) > 1:
        stem = "".join(words[:-1])
        if words[-1] in _SIDES and stem not in _MOVES_SIDEWAYS:
            return ShapeKey(stem, _SIDES[words[-1]])
        if words[0] in _SIDES:
            return ShapeKey("".join(words[1:]), _SIDES[words[0]])
    return ShapeKey("".join(words) or name, "")


def match(source: Sequence[str], target: Sequence[str]) -> NameMatch:
    """Map shapes of one list to the same shapes of another under any spelling.

    A target that the source has split into left and right takes their mean; a
    target that is one half of a source shape takes the whole of its weight.

    Args:
        source: `K_source` names that have weights.
        target: `K_target` names that want them.
    """
    exact = {name: i for i, name in reversed(list(enumerate(source)))}
    by_key = {shape_key(name): i for i, name in reversed(list(enumerate(source)))}
    matrix = np.zeros((len(target), len(source)))
    for row, name in enumerate(target):
        columns = [exact[name]] if name in exact else _drivers(shape_key(name), by_key)
        for column in columns:
            matrix[row, column] = 1 / len(columns)
    return NameMatch(
        tuple(source),
        tuple(target),
        matrix,
        tuple(name for column, name in enumerate(source) if not matrix[:, column].any()),
        tuple(name for row, name in enumerate(target) if not matrix[row].any()),
    )


def _drivers(wanted: ShapeKey, by_key: dict[ShapeKey, int]) -> list[int]:
    """Return the columns whose mean drives a shape: itself, its two halves, or the whole it is half of."""
    if wanted in by_key:
        return [by_key[wanted]]
    others = [ShapeKey(wanted.stem, "")] if wanted.side else [ShapeKey(wanted.stem, side) for side in "LR"]
    return [by_key[key] for key in others if key in by_key]


def _without_namespace(name: str) -> str:
    pieces = [piece for piece in _NAMESPACE.split(name) if piece]
    if len(pieces) > 1 and pieces[-1].lower() in _SIDES:
        return ".".join(pieces[-2:])
    return pieces[-1] if pieces else name
