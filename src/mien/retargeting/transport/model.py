"""Learning from few labels and many unlabelled rows by optimal transport.

Not the published latent model, but an answer to the same question.  Three parts, each of which
measured better than what it replaced: principal components of all source rows seen, denoised and
partly whitened; weak labels by optimal transport between the unlabelled rows of both
sides; shares of the predictions with and without weak labels, and of a linear map, by cross-validation
over the labels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mien.core import Note
from mien.core.arrays import Flags, Floats
from mien.retargeting.samples import Samples
from mien.retargeting.settings import in_range
from mien.retargeting.transport.experts import (
    Expert,
    LinearExpert,
    Matching,
    ProcessExpert,
    Seen,
    alone,
    matched,
    stretch_of,
)
from mien.retargeting.transport.hull import LocalHull
from mien.retargeting.transport.learnt import LearntTransport
from mien.retargeting.transport.principal import PrincipalSpace
from mien.retargeting.transport.process import LinearRadialKernel, most_evident
from mien.retargeting.transport.shares import Shares, shares

FEWEST = 3
"""Labels below which nothing can be held out, and weak labels are not believed."""
DOUBTFUL = 4.0
"""Weak labels of so many times the noise are tried as well."""

ALONE = 2
"""Experts that learn from labels alone: the process and the linear map."""
UNTOLD = 3
"""Experts without weak labels: those, and the process drawn to the poses that exist."""
UNHEEDED = 0.9
"""Share of the process without weak labels above which that is worth saying."""


@dataclass(frozen=True)
class TransportModel:
    """Gaussian processes over principal components, told weak labels by optimal transport.

    Attributes:
        source_power, target_power: principal coordinates are divided by their spread to this power.
        rounds: of matching and learning; 0 leaves the unlabelled target rows aside.
        softness: of the transport plan, over the median cost.
        weak_noise: noise variance of a weak label, the targets' variance being 1.
        relevance: how far coordinates are rescaled by what the targets make of them.
        neighbours: target rows that a pose is drawn to where weak labels were told; 0 leaves it where it is.
        most: unlabelled rows of each side that are matched.
    """

    source_power: float = 0.5
    target_power: float = 0.3
    rounds: int = 5
    softness: float = 0.04
    weak_noise: float = 0.4
    relevance: float = 0.5
    neighbours: int = 12
    most: int = 600

    def __post_init__(self) -> None:
        in_range(self, source_power=(0, 1), target_power=(0, 1), rounds=(0, 100), softness=(1e-3, 10))
        in_range(self, weak_noise=(1e-3, 1e3), relevance=(0, 1), neighbours=(0, 1000), most=(2, 5000))

    def learn(self, given: Samples) -> LearntTransport:
        """Learn from samples; deterministic, and the order of unlabelled rows does not matter."""
        given, notes = given.paired()
        source, target = PrincipalSpace.of(given.X), PrincipalSpace.of(given.Y)
        count = int(np.isnan(given.Y_labelled).sum())
        if count:
            notes = (*notes, Note("targets-completed", f"{count} entries of labels were not given and were completed."))
        seen, targets = Seen.of(source, given.X_labelled), target.completed(given.Y_labelled)
        unlabelled, goals = source.coordinates(given.X_only), target.completed(given.Y_only)
        if self.rounds and max(len(unlabelled), len(goals)) > self.most:
            text = f"of {len(unlabelled)} source rows and {len(goals)} target rows without label, {self.most} each are matched."
            notes = (*notes, Note("unlabelled-thinned", text))
        unlabelled = unlabelled[_spread(unlabelled[:, 0], self.most)]
        goals = goals[_spread(target.coordinates(goals)[:, 0], self.most)]
        kernel = most_evident(seen.coordinates * stretch_of(source, self.source_power), targets)
        learn = _Learning(self, source, target, kernel, seen, targets, unlabelled, goals)
        experts = tuple(learn(np.ones(len(targets), bool)))
        found = shares(learn, seen, targets, ALONE) if len(targets) >= FEWEST else Shares.whole(len(experts))
        believed = float(found.doubtful[:UNTOLD].sum())
        if len(experts) > UNTOLD and believed > UNHEEDED:
            text = (
                f"predictions with weak labels get {1 - believed:.0%} of the say: the target-only rows seem to be of "
                "another kind of performance than the source."
            )
            notes = (*notes, Note("weak-labels-unheeded", text))
        poses = np.concatenate([targets, goals])
        heard = found.heard
        kept = tuple(one for one, has in zip(experts, heard, strict=True) if has)
        return LearntTransport(source, target, kept, found.only(heard), poses, notes)


@dataclass(frozen=True, eq=False)
class _Learning:
    """All experts, learned from some of the labels."""

    settings: TransportModel
    source: PrincipalSpace
    target: PrincipalSpace
    kernel: LinearRadialKernel
    seen: Seen
    targets: Floats
    source_only: Floats
    target_only: Floats

    def __call__(self, used: Flags) -> Sequence[Expert]:
        s = self.settings
        labelled = self.seen.coordinates[used], self.targets[used]
        first = alone(stretch_of(self.source, s.source_power), *labelled, self.kernel)
        experts: list[Expert] = [first, LinearExpert.told(self.seen.rows[used], self.targets[used])]
        few = len(self.targets) < FEWEST or min(len(self.source_only), len(self.target_only)) < FEWEST
        if s.rounds == 0 or few:
            return experts
        rows = np.concatenate([labelled[1], self.target_only])
        hull = LocalHull(rows, self.target, stretch_of(self.target, s.target_power), s.neighbours)
        ways = [
            Matching(s.rounds, s.softness, noise, 0.3, s.relevance) for noise in (s.weak_noise, DOUBTFUL * s.weak_noise)
        ]
        drawn = ProcessExpert(first.stretch, first.process, hull if hull.neighbours else None)
        return [*experts, drawn, *(matched(first, labelled, self.source_only, hull, way) for way in ways)]


def _spread(along: Floats, most: int) -> Flags:
    """Choose at most so many rows, spread over a coordinate whatever their order."""
    used = np.zeros(len(along), bool)
    order = np.argsort(along, kind="stable")
    used[
        order[np.unique(np.linspace(0, len(along) - 1, min(most, len(along))).astype(int))] if len(along) else order
    ] = True
    return used
