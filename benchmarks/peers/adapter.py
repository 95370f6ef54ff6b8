"""What an adapter is, and how another solver takes the place of mien's own."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Rig
from mien.core.arrays import Floats
from mien.retargeting import make_method
from mien.retargeting.method import Method
from mien.retargeting.shape_retargeter import ShapeRetargeter

Solve = Callable[[Floats, Floats, float], Floats]
"""From shapes `(K, M, 3)` and a take `(F, M, 3)` [human cm, NaN where not seen] at a frame rate to weights `(F, K)`."""
SHAPES = "range-of-motion"
"""Whose personalised shapes other solvers are given, so that only the solve differs."""


@dataclass(frozen=True)
class Peer:
    """Something by others.

    Attributes:
        name: in the table.
        about: what it does, and where it is from.
        install: how to get it.
        method: makes it; raises `Absent` where it is not installed.
    """

    name: str
    about: str
    install: str
    method: Callable[[], Method]


class Absent(Exception):
    """A peer is not installed."""


@dataclass(frozen=True, eq=False)
class PeerRetargeter(ShapeRetargeter):
    """The actor's own shapes under another solve."""

    other: Solve | None = None

    def solved(self, take: Floats, fps: float) -> tuple[Floats, float]:
        """Return the other solver's weights; it tells no residual."""
        assert self.other is not None
        return self.other(self.shapes, take, fps), float("nan")

    def start(self) -> Any:
        """Refuse: peers are measured on whole takes."""
        raise InputError("a peer maps whole takes only.")


@dataclass(frozen=True)
class SolverMethod:
    """The shapes of one of mien's methods, and somebody else's solve."""

    name: ClassVar[str] = "peer"
    about: ClassVar[str] = "another solver on the same shapes"
    needs: ClassVar[str] = "markers"

    solve: Solve

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
    ) -> PeerRetargeter:
        """Fit mien's method and put the other solver in its place."""
        base = make_method(SHAPES).fit(
            character, training, pairs, neutral=neutral, rigid=rigid, head_moves=head_moves, examples=examples
        )
        return with_solver(base, self.solve)


def with_solver(base: Any, solve: Solve, shapes: Floats | None = None) -> PeerRetargeter:
    """Return a fitted method with another solver, and perhaps other shapes of the actor."""
    parts = {f.name: getattr(base, f.name) for f in fields(ShapeRetargeter)}
    if shapes is not None:
        parts["shapes"] = shapes
    return PeerRetargeter(**parts, other=solve)


def frame_by_frame(one: Callable[[Floats, Floats], Floats]) -> Solve:
    """Return a solve that does each frame alone, from what it sees.

    Args:
        one: from a matrix `(rows, K)` and a vector `(rows,)` to weights `(K,)`.
    """

    def solve(shapes: Floats, take: Floats, fps: float) -> Floats:
        del fps
        matrix, rows = shapes.reshape(len(shapes), -1).T, take.reshape(len(take), -1)
        weights = np.zeros((len(take), len(shapes)))
        for frame, row in enumerate(rows):
            seen = ~np.isnan(row)
            weights[frame] = one(matrix[seen], row[seen]) if seen.any() else weights[frame - 1]
        return weights

    return solve


def checkout(variable: str, inside: str, wanted: str) -> None:
    """Let Python import from a checkout that an environment variable names.

    Args:
        variable: the environment variable.
        inside: the folder of it to import from.
        wanted: a file that has to be in that folder.

    Raises:
        Absent: it is not set, or names something else.
    """
    named = os.environ.get(variable, "")
    folder = Path(named) / inside
    if not named or not (folder / wanted).is_file():
        raise Absent(f"set {variable} to a checkout that has {Path(inside) / wanted}")
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
