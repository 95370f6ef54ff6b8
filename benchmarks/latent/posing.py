"""Figure 8 of Bouaziz and Pauly 2014: how well the rest of a held-out pose is told from two or three of its entries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.latent.cases import Take, draw, rms
from benchmarks.latent.sweeps import Score
from benchmarks.report import Row
from mien.core.arrays import Floats
from mien.retargeting.transport.posing import LOOSE, completed
from mien.retargeting.transport.principal import PrincipalSpace

LABELS = 20
ACTIVE = 0.05
"""An entry farther from the median pose than this counts as active."""


def by_posing(takes: Sequence[Take], seed: int) -> Iterator[Score]:
    """Score the entries that were not given, when the two or three strongest of a pose are; and count the active ones."""
    for take in takes:
        one = draw(take, LABELS, seed)
        every, labels = one.given.Y, one.given.Y_labelled
        rest, space = np.median(every, axis=0), PrincipalSpace.of(every)
        for given in (2, 3):
            away = np.abs(one.targets - rest)
            free = np.argsort(np.argsort(-away, axis=1), axis=1) >= given
            asked = np.where(free, np.nan, one.targets)
            whole = np.where(free, rest, one.targets)
            found = {
                "poses alike": _each(asked, space, every),
                "poses alike, labels only": _each(asked, PrincipalSpace.of(labels), labels),
                "linear-Gaussian": space.completed(asked),
                "linear-Gaussian, loose": space.loosened(LOOSE).completed(asked),
                "mean pose": np.where(free, every.mean(axis=0), asked),
                "the rest at rest": whole,
            }
            acted = float((np.abs(one.targets - rest)[free] > ACTIVE).sum() / len(free))
            for name, poses in found.items():
                setting: Row = {"take": take.name, "targets": take.kind, "entries": given}
                active = float((np.abs(poses - rest)[free] > ACTIVE).sum() / len(free))
                outside = float(((poses < every.min(axis=0)) | (poses > every.max(axis=0)))[free].sum() / len(free))
                counts = {"active": active, "acted": acted, "out of range": outside}
                yield Score(setting, name, rms(poses[free], one.targets[free]), counts=counts)


def _each(asked: Floats, space: PrincipalSpace, poses: Floats) -> Floats:
    return np.array([completed(row, space, poses) for row in asked])
