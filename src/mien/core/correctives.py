"""Shapes that follow from others: combinations that correct two shapes at once, and in-betweens of one.

A corrective is said by the pose at which it is full.  Full at jawOpen 1 and smile 1, it is a
combination: its weight is the product of both.  Full at jawOpen 0.5, it is an in-between: its
weight rises from 0 to 1 there and falls again to 0 at the next in-between, or at 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mien.core.arrays import Floats, Ints, indices
from mien.core.errors import InputError, unknown


@dataclass(frozen=True, eq=False)
class Correctives:
    """Which shapes are driven by which, of a set of `K` blendshapes.

    The weight of corrective `c` is `Π_j h(w_j; at_cj)` over its drivers `j`.  With `at` 1, `h` is
    the weight itself; below 1 it is the hat that peaks there and ends at the driver's
    neighbouring places, among which 0 and 1 always are.

    Attributes:
        shapes: `(C,)` rows of the driven shapes.
        drivers: `(C, J)` rows of their drivers, -1 where there are fewer than `J`.
        at: `(C, J)` weight of each driver at which the corrective is full; 1 where there is none.

    Raises:
        InputError: a corrective without drivers, driven by itself, by another corrective, or by one
            shape at 1 alone; or a place outside 0 … 1.
    """

    shapes: Ints
    drivers: Ints
    at: Floats

    def __post_init__(self) -> None:
        put = object.__setattr__
        most = np.iinfo(np.int64).max
        put(self, "shapes", indices(self.shapes, (None,), most, "corrective shapes"))
        put(self, "drivers", indices(np.asarray(self.drivers) + 1, (len(self.shapes), None), most, "drivers") - 1)
        put(self, "at", np.where(self.drivers < 0, 1.0, np.asarray(self.at, dtype=np.float64)))
        if not ((self.at > 0) & (self.at <= 1)).all():
            raise InputError("a corrective must be full at weights above 0 and up to 1 of its drivers.")
        for shape, drivers, at in zip(self.shapes, self.drivers, self.at, strict=True):
            self._check(int(shape), drivers[drivers >= 0], at)

    def _check(self, shape: int, drivers: Ints, at: Floats) -> None:
        if (self.shapes == shape).sum() > 1:
            raise InputError(f"shape {shape} is driven by two rules; one says all.")
        if np.isin(drivers, self.shapes).any():
            raise InputError(f"shape {shape} is driven by a corrective; name the shapes behind that one instead.")
        if len(np.unique(drivers)) < len(drivers):
            raise InputError(f"shape {shape} names a driver twice.")
        if len(drivers) == 0 or (len(drivers) == 1 and (at == 1).all()):
            raise InputError(
                f"shape {shape} needs two drivers (a combination), or one below 1 (an in-between), to be a corrective."
            )

    def __len__(self) -> int:
        return len(self.shapes)

    @property
    def last(self) -> int:
        """The highest row they name; -1 if there are none."""
        return int(max(self.shapes.max(initial=-1), self.drivers.max(initial=-1)))

    @cached_property
    def spans(self) -> tuple[Floats, Floats]:
        """Where each hat begins and ends, `(C, J)` each; 0 and infinity where the weight itself is the factor."""
        begin, end = np.zeros_like(self.at), np.full_like(self.at, np.inf)
        for c, j in zip(*np.nonzero(self.at < 1), strict=True):
            places = self.places(int(self.drivers[c, j]))
            begin[c, j] = places[places < self.at[c, j]].max()
            end[c, j] = places[places > self.at[c, j]].min()
        return begin, end

    def places(self, driver: int) -> Floats:
        """Return the weights of a driver at which hats begin, peak or end, ascending; none if it has no in-between."""
        peaks = self.at[(self.drivers == driver) & (self.at < 1)]
        return np.unique([0.0, *peaks, 1.0]) if len(peaks) else np.empty(0)

    def complete(self, weights: Floats) -> Floats:
        """Return weights `(…, K)` with those of the correctives as their drivers say."""
        result = np.array(weights, dtype=np.float64)
        begin, end = self.spans
        driven = np.ones((*result.shape[:-1], len(self)))
        for j in range(self.drivers.shape[1]):
            w, at = result[..., self.drivers[:, j]], self.at[:, j]
            rising = (w - begin[:, j]) / (at - begin[:, j])
            hat = np.maximum(np.minimum(rising, (end[:, j] - w) / np.where(at < 1, end[:, j] - at, 1.0)), 0.0)
            driven *= np.where(self.drivers[:, j] < 0, 1.0, np.where(at < 1, hat, w))
        result[..., self.shapes] = driven
        return result


def correctives_of(rules: Mapping[str, Mapping[str, float]], names: Sequence[str]) -> Correctives:
    """Make correctives of rules in names.

    Args:
        rules: for each corrective the pose at which it is full, by the names of its drivers.
        names: the `K` blendshapes.

    Raises:
        InputError: an unknown shape, or a rule that makes no corrective.
    """
    place = {name: k for k, name in enumerate(names)}
    for name in (n for shape, pose in rules.items() for n in (shape, *pose)):
        if name not in place:
            raise InputError(f"the correctives name an {unknown('blendshape', name, names)}")
    width = max((len(pose) for pose in rules.values()), default=0)
    drivers, at = np.full((len(rules), width), -1, np.int64), np.ones((len(rules), width))
    for c, pose in enumerate(rules.values()):
        drivers[c, : len(pose)] = [place[name] for name in pose]
        at[c, : len(pose)] = list(pose.values())
    return Correctives(np.array([place[name] for name in rules], np.int64), drivers, at)
