"""What is learned from: a few labelled frames, and many that show only one of the two sides.

Every model that learns by example starts from these numbers and knows nothing of faces:
rows of source observations (markers), rows of target parameters (anything with numbers),
and which of them belong together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from mien.core import InputError, Note
from mien.core.arrays import Flags, Floats, floats


@dataclass(frozen=True, eq=False)
class Samples:
    """Labelled pairs, and observations of one side alone.

    NaN is "not seen" in a source row and "not labelled" in a target row.

    Attributes:
        X_labelled: `(l, dx)` source rows.
        Y_labelled: `(l, dy)` target rows, one for each source row.
        X_only: `(m, dx)` source rows that nobody labelled.
        Y_only: `(n, dy)` target rows without a source.

    Raises:
        InputError: shapes do not fit, there is no label, labels contradict each other, a
            dimension of the source is never seen or one of the target never given.
    """

    X_labelled: Floats
    Y_labelled: Floats
    X_only: Floats
    Y_only: Floats

    def __post_init__(self) -> None:
        for name in ("X_labelled", "Y_labelled", "X_only", "Y_only"):
            object.__setattr__(self, name, floats(getattr(self, name), (None, None), name, nan=True))
        if len(self.X_labelled) != len(self.Y_labelled):
            raise InputError(
                f"{len(self.X_labelled)} source rows are labelled with {len(self.Y_labelled)} target rows; "
                "give one target row for each."
            )
        for side, rows in (("X", self.X), ("Y", self.Y)):
            _check_columns(rows, side)
        if not (self.seen & self.given).any():
            raise InputError(
                "there are no labels: no row has both a source that is seen and a target that is given; "
                "label at least one frame, better 10 that show different expressions."
            )
        self._check_agreement()

    @property
    def X(self) -> Floats:
        """`(l + m, dx)` all source rows, the labelled ones first."""
        return _stacked(self.X_labelled, self.X_only, "X")

    @property
    def Y(self) -> Floats:
        """`(l + n, dy)` all target rows, the labelled ones first."""
        return _stacked(self.Y_labelled, self.Y_only, "Y")

    @property
    def seen(self) -> Flags:
        """`(l,)` whether a labelled row sees anything of the source."""
        return np.asarray(~np.isnan(self.X_labelled).all(axis=1))

    @property
    def given(self) -> Flags:
        """`(l,)` whether a labelled row gives anything of the target."""
        return np.asarray(~np.isnan(self.Y_labelled).all(axis=1))

    def __len__(self) -> int:
        return len(self.X_labelled)

    def paired(self) -> tuple[Samples, tuple[Note, ...]]:
        """Move labelled rows with an empty side to where they belong, and drop rows that are empty, counting both."""
        both = self.seen & self.given
        x_only = np.concatenate([self.X_only, self.X_labelled[self.seen & ~self.given]])
        y_only = np.concatenate([self.Y_only, self.Y_labelled[self.given & ~self.seen]])
        kept_x, kept_y = (~np.isnan(rows).all(axis=1) for rows in (x_only, y_only))
        notes = []
        if not both.all():
            text = f"{int((~both).sum())} labelled rows have no source or no target, and count as unlabelled."
            notes.append(Note("labels-empty", text, f"label {int(np.argmin(both))}"))
        empty = int((~kept_x).sum() + (~kept_y).sum())
        if empty:
            notes.append(Note("samples-empty", f"{empty} rows without a single value are left out."))
        found = Samples(self.X_labelled[both], self.Y_labelled[both], x_only[kept_x], y_only[kept_y])
        return found, tuple(notes)

    def supervised(self) -> Samples:
        """Return the labelled pairs alone."""
        return replace(self, X_only=self.X_only[:0], Y_only=self.Y_only[:0])

    def _check_agreement(self) -> None:
        """Refuse two labels of one and the same source row that differ."""
        rows = np.nan_to_num(self.X_labelled, nan=np.inf)
        _, group = np.unique(rows, axis=0, return_inverse=True)
        for twins in (np.flatnonzero(group == g) for g in np.flatnonzero(np.bincount(group.ravel()) > 1)):
            low, high = (reduce(np.nan_to_num(self.Y_labelled[twins], nan=fill), axis=0) for reduce, fill in _EXTREMES)
            apart = high > low + 1e-9
            if apart.any() and self.seen[twins[0]]:
                k = int(np.argmax(apart))
                raise InputError(
                    f"the labels {', '.join(map(str, twins[:4]))} have the same source row but contradict each other: "
                    f"target {k} is {low[k]:g} in one and {high[k]:g} in another; keep the right one."
                )


_EXTREMES = ((np.min, np.inf), (np.max, -np.inf))


def _check_columns(rows: Floats, side: str) -> None:
    if rows.shape[1] == 0:
        raise InputError(f"{side} has no dimensions; at least one is needed.")
    never = np.flatnonzero(np.isnan(rows).all(axis=0))
    if len(rows) and never.size:
        what = "seen" if side == "X" else "given a value"
        raise InputError(
            f"{never.size} dimensions of {side} are never {what} in {len(rows)} rows, the first {never[0]}; leave them out."
        )


def _stacked(labelled: Floats, only: Floats, side: str) -> Floats:
    if only.shape[1] != labelled.shape[1]:
        if len(only):
            raise InputError(
                f"{side}_only has {only.shape[1]} dimensions, but {side}_labelled has {labelled.shape[1]}; they must agree."
            )
        return labelled
    return np.concatenate([labelled, only])


def samples(
    labelled: ArrayLike, targets: ArrayLike, source_only: ArrayLike | None = None, target_only: ArrayLike | None = None
) -> Samples:
    """Make `Samples`, either kind of unlabelled rows being optional.

    Args:
        labelled: `(l, dx)` labelled source rows.
        targets: `(l, dy)` their targets.
        source_only: `(m, dx)` further source rows.
        target_only: `(n, dy)` further target rows.
    """
    x, y = np.asarray(labelled, dtype=np.float64), np.asarray(targets, dtype=np.float64)
    none_x, none_y = (np.zeros((0, a.shape[-1] if a.ndim else 0)) for a in (x, y))
    return Samples(
        x,
        y,
        none_x if source_only is None else np.asarray(source_only, dtype=np.float64),
        none_y if target_only is None else np.asarray(target_only, dtype=np.float64),
    )


class Learnt(Protocol):
    """A learned map from source rows to target rows: frozen, and the same for whole takes and row by row."""

    @property
    def notes(self) -> Sequence[Note]:
        """What was repaired, left out or doubtful."""
        ...

    def map(self, X: Floats) -> Floats:
        """Map source rows `(F, dx)`, NaN where not seen, in the order of time, to target rows `(F, dy)`."""
        ...

    def variance(self, X: Floats) -> Floats:
        """Return the predictive variance `(F, dy)` of what `map` returns, in squared units of the target."""
        ...

    def start(self) -> Any:
        """Return the state before the first row."""
        ...

    def step(self, state: Any, x: Floats) -> tuple[Any, Floats]:
        """Map one row `(dx,)`, knowing only what came before; return the next state and `(dy,)`."""
        ...


class Learner(Protocol):
    """Frozen settings of one model."""

    def learn(self, given: Samples) -> Learnt:
        """Learn from samples."""
        ...
