"""Ways to read the same labels: a linear map, a Gaussian process, and one that is also told weak labels.

A weak label is what the unlabelled target rows say about an unlabelled source row.  If both
sides were recorded of the same kind of performance, their two clouds are the same cloud seen
twice: the optimal transport plan from the poses predicted so far to the poses that exist says
which could be which, and its barycentre is a better pose than the prediction.  Told so,
the process predicts better, and the plan is made again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.spatial.distance import cdist

from mien.core.arrays import Flags, Floats
from mien.retargeting.transport.hull import LocalHull
from mien.retargeting.transport.plan import transport_plan
from mien.retargeting.transport.principal import PrincipalSpace
from mien.retargeting.transport.process import LinearRadialKernel, Process, kernel_for, most_evident
from mien.solve.ridge import linear_map


@dataclass(frozen=True)
class Matching:
    """How unlabelled rows are matched.

    Attributes:
        rounds: of matching and learning.
        softness: of the plan, over the median cost.
        weak_noise: noise variance of a weak label, the targets' variance being 1.
        radial: amplitude of the process's radial part beside its linear one.
        source_power, target_power: principal coordinates are divided by their spread to this power:
            0 keeps their sizes, 1 makes them all equal.
        relevance: how far, in each round, coordinates are rescaled by what the targets make of them.
    """

    rounds: int = 5
    softness: float = 0.04
    weak_noise: float = 0.4
    radial: float = 0.3
    source_power: float = 0.5
    target_power: float = 0.3
    relevance: float = 0.5


@dataclass(frozen=True, eq=False)
class Seen:
    """Source rows as experts look at them.

    Attributes:
        rows: `(m, d)` as they were seen, gaps filled.
        coordinates: `(m, r)` principal coordinates, noise taken off.
    """

    rows: Floats
    coordinates: Floats

    @classmethod
    def of(cls, space: PrincipalSpace, rows: Floats) -> Seen:
        """Return rows `(m, d)`, NaN where not seen, in both ways."""
        coordinates = space.coordinates(rows)
        unseen = np.isnan(rows)
        whole = np.where(unseen, space.mean + coordinates @ space.axes, rows) if unseen.any() else rows
        return cls(whole, coordinates)

    def only(self, which: Flags) -> Seen:
        """Return some of the rows."""
        return Seen(self.rows[which], self.coordinates[which])


class Expert(Protocol):
    """What predicts targets, and doubts them."""

    def expected(self, seen: Seen) -> Floats:
        """Return the expected targets `(m, k)`."""
        ...

    def variance(self, seen: Seen) -> Floats:
        """Return the predictive variance `(m, k)`."""
        ...


@dataclass(frozen=True, eq=False)
class LinearExpert:
    """A ridge regression on the rows as they were seen: where labels solve a linear rig exactly, nothing beats it.

    Attributes:
        slopes: `(d, k)`.
        offset: `(k,)`.
        error: `(k,)` mean squared error of labels left out.
    """

    slopes: Floats
    offset: Floats
    error: Floats

    @classmethod
    def told(cls, rows: Floats, targets: Floats) -> LinearExpert:
        """Learn from labelled rows `(l, d)` and targets `(l, k)`, the penalty chosen by leaving labels out."""
        return cls(*linear_map(rows, targets))

    def expected(self, seen: Seen) -> Floats:
        """Return the expected targets `(m, k)`."""
        return np.asarray(seen.rows @ self.slopes + self.offset)

    def variance(self, seen: Seen) -> Floats:
        """Return the predictive variance `(m, k)`."""
        return np.broadcast_to(self.error, (len(seen.rows), len(self.error)))


@dataclass(frozen=True, eq=False)
class ProcessExpert:
    """A process over stretched principal coordinates of the source.

    Attributes:
        stretch: `(r,)` factors of the coordinates.
        process: from stretched coordinates to targets.
        hull: where poses are drawn to, if anywhere.
    """

    stretch: Floats
    process: Process
    hull: LocalHull | None = None

    def expected(self, seen: Seen) -> Floats:
        """Return the expected targets `(m, k)`."""
        poses = self.process.expected(seen.coordinates * self.stretch)
        return poses if self.hull is None else self.hull(poses)

    def variance(self, seen: Seen) -> Floats:
        """Return the predictive variance `(m, k)`."""
        return self.process.variance(seen.coordinates * self.stretch)

    def doubt(self, seen: Seen) -> Floats:
        """Return the variance left of a target of unit amplitude, `(m,)`."""
        return self.process.doubt(seen.coordinates * self.stretch)


def stretch_of(space: PrincipalSpace, power: float) -> Floats:
    """Return the factors that divide coordinates by their spread to a power, the first becoming 1."""
    return np.asarray((space.spread / space.spread[0]) ** -power / space.spread[0])


def alone(
    stretch: Floats, coordinates: Floats, targets: Floats, kernel: LinearRadialKernel | None = None
) -> ProcessExpert:
    """Learn from the labelled rows only: the process of most evidence, or of a kernel already chosen."""
    inputs = coordinates * stretch
    return ProcessExpert(stretch, Process.told(kernel or most_evident(inputs, targets), inputs, targets))


def matched(
    beginning: ProcessExpert, labelled: tuple[Floats, Floats], source_only: Floats, hull: LocalHull, how: Matching
) -> ProcessExpert:
    """Learn from the labelled rows, and from the target-only rows matched with the source-only ones.

    Args:
        beginning: what the first plan goes by.
        labelled: coordinates `(l, r)` and targets `(l, k)`.
        source_only: `(m, r)` coordinates.
        hull: the target rows, the labelled ones first.
        how: the settings.
    """
    coordinates, targets = labelled
    every = np.concatenate([coordinates, source_only])
    known = beginning.process.kernel
    own_noise = np.clip(known.noise / (known.linear + known.radial), 1e-3, 0.1)
    noise = np.concatenate([np.full(len(coordinates), own_noise), np.full(len(source_only), how.weak_noise)])
    goals = hull.rows[len(targets) :]
    places = hull.space.coordinates(goals) * hull.stretch
    found = beginning
    for number in range(how.rounds):
        poses = found.process.expected(source_only * found.stretch)
        cost = cdist(hull.space.coordinates(poses) * hull.stretch, places, "sqeuclidean")
        plan = transport_plan(cost, how.softness * max(float(np.median(cost)), 1e-300))
        told = np.concatenate([targets, len(plan) * plan @ goals])
        stretch = found.stretch
        if number > 1:
            stretch = stretch * relevance(every * stretch, told, noise) ** how.relevance
        inputs = every * stretch
        kernel = kernel_for(inputs, (1.0, how.radial, 1.0, own_noise))
        found = ProcessExpert(stretch, Process.told(kernel, inputs, told, noise))
    return ProcessExpert(found.stretch, found.process, hull if hull.neighbours else None)


def relevance(inputs: Floats, targets: Floats, noise: Floats) -> Floats:
    """Return how much each input matters to the targets, `(r,)`: between 1/9 and 9, about 1 on average.

    It is the size of the coefficients of the linear regression with the process's own prior.
    """
    size = (inputs**2).sum(axis=1).mean()
    weighed = inputs.T / noise
    slopes = np.linalg.solve(
        weighed @ inputs + size * np.eye(inputs.shape[1]), weighed @ (targets - targets.mean(axis=0))
    )
    matters, spread = (slopes**2).mean(axis=1), inputs.var(axis=0)
    average = (matters * spread).sum() / max(float(spread.sum()), 1e-300)
    if average <= 0:
        return np.ones(inputs.shape[1])
    return np.asarray(np.clip(np.sqrt(matters / average), 1 / 9, 9))
