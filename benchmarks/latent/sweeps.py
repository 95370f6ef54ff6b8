"""One sweep for each figure of Bouaziz and Pauly 2014: what one random draw of every setting scores with every method.

A whole figure is many draws; the caller goes through them one by one, so that what was measured so far is
always a figure of fewer draws.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.latent.cases import LIVELINK, Draw, Take, draw, rms
from benchmarks.report import Row
from mien.core.arrays import Floats
from mien.retargeting.divide import UPPER
from mien.retargeting.latent import LatentModel
from mien.retargeting.regions import ApartModel
from mien.retargeting.regression import CrossMappingModel, GprModel, RidgeModel, SvrModel
from mien.retargeting.samples import Samples
from mien.retargeting.suggest import suggest
from mien.retargeting.transport import TransportModel

Learners = Mapping[str, Any]

TRANSPORT = "transport"
PEERS: Learners = {
    TRANSPORT: TransportModel(),
    "ridge": RidgeModel(),
    "gpr": GprModel(),
    "svr": SvrModel(),
    "cross-mapping": CrossMappingModel(),
    "sgplvm": LatentModel(unlabelled=False),
    "paper": LatentModel(),
}
"""Every method, with its own defaults on every draw."""

VARIANTS: Learners = {
    TRANSPORT: TransportModel(),
    "no target rows": TransportModel(rounds=0),
    "nor whitening": TransportModel(rounds=0, source_power=0),
    "one round": TransportModel(rounds=1),
    "no relevance": TransportModel(relevance=0),
    "no hull": TransportModel(neighbours=0),
    "ridge": RidgeModel(),
}
"""The transport with one part taken away at a time."""


@dataclass(frozen=True)
class Score:
    """One method on one draw of one setting.

    Attributes:
        setting: what was varied.
        method: its name.
        rms: its error.
        seconds: processor time that learning took; 0 if it is not of interest.
        counts: further numbers by name.
    """

    setting: Row
    method: str
    rms: float
    seconds: float = 0.0
    counts: Mapping[str, float] = field(default_factory=dict)


def table(scores: Sequence[Score]) -> list[Row]:
    """Return a row for each setting and method: mean and spread over the draws."""
    found: dict[tuple[tuple[Any, ...], str], list[Score]] = {}
    for score in scores:
        found.setdefault((tuple(score.setting.items()), score.method), []).append(score)
    return [
        {
            **dict(setting),
            "method": method,
            "rms": float(np.mean([score.rms for score in same])),
            "spread": float(np.std([score.rms for score in same])),
            "draws": len(same),
            "learn_cpu_s": round(float(np.mean([score.seconds for score in same])), 4),
            **{name: float(np.mean([score.counts[name] for score in same])) for name in same[0].counts},
        }
        for (setting, method), same in found.items()
    ]


def scored(learners: Learners, one: Draw, tests: Sequence[tuple[Row, Floats]]) -> Iterator[Score]:
    """Learn each method once, and score it on test markers of several settings."""
    for name, learner in learners.items():
        start = time.process_time()
        learnt = learner.learn(one.given)
        seconds = time.process_time() - start
        for setting, markers in tests:
            yield Score(setting, name, rms(learnt.map(markers), one.targets), seconds)


def by_labels(takes: Sequence[Take], learners: Learners, labels: Sequence[int], seed: int) -> Iterator[Score]:
    """Figure 4: error against the number of labels, 100 unlabelled rows of each side."""
    for take in takes:
        for count in labels:
            one = draw(take, count, seed)
            yield from scored(learners, one, [({**_of(take), "labels": count}, one.markers)])


def by_clean_labels(takes: Sequence[Take], learners: Learners, labels: Sequence[int], seed: int) -> Iterator[Score]:
    """The same without noise: where labels come to suffice to solve a linear rig exactly."""
    for take in takes:
        for count in labels:
            one = draw(take, count, seed, noise=0.0)
            yield from scored(learners, one, [({**_of(take), "labels": count}, one.markers)])


def by_unlabelled(takes: Sequence[Take], learners: Learners, counts: Sequence[int], seed: int) -> Iterator[Score]:
    """Figure 5: error against the number of unlabelled rows of each side, 20 labels."""
    for take in takes:
        for count in counts:
            one = draw(take, 20, seed, unlabelled=count)
            yield from scored(learners, one, [({**_of(take), "unlabelled": count}, one.markers)])


def by_noise(takes: Sequence[Take], learners: Learners, levels: Sequence[float], seed: int) -> Iterator[Score]:
    """Figure 6: error against the noise of every marker coordinate [mm], 20 labels."""
    for take in takes:
        for level in levels:
            one = draw(take, 20, seed, noise=level)
            yield from scored(learners, one, [({**_of(take), "noise_mm": level}, one.markers)])


def by_missing(takes: Sequence[Take], learners: Learners, shares: Sequence[float], seed: int) -> Iterator[Score]:
    """Figure 7: error against the share of markers missing in each frame mapped, 20 labels."""
    for take in takes:
        one = draw(take, 20, seed)
        yield from scored(
            learners, one, [({**_of(take), "missing": share}, without(one.markers, share)) for share in shares]
        )


def _of(take: Take) -> Row:
    return {"take": take.name, "targets": take.kind}


def without(markers: Floats, share: float) -> Floats:
    """Return rows with a share of the markers of each missing, always the same ones."""
    rng = np.random.default_rng(3)
    unseen = rng.random((len(markers), markers.shape[1] // 3)) < share
    return np.where(np.repeat(unseen, 3, axis=1), np.nan, markers)


def by_foreign(takes: Sequence[Take], learners: Learners, labels: Sequence[int], seed: int) -> Iterator[Score]:
    """Error where the target-only rows come from another take with the same targets."""
    for take in takes:
        for other in takes:
            if other is take or other.kind != take.kind or not {take.name, other.name} <= set(LIVELINK):
                continue
            for count in labels:
                one = draw(take, count, seed, other=other)
                setting = {**_of(take), "target_only": other.name, "labels": count}
                yield from scored(learners, one, [(setting, one.markers)])


def by_regions(takes: Sequence[Take], labels: Sequence[int], seed: int) -> Iterator[Score]:
    """Error with the face learned whole, and with its upper and lower half learned apart; weights, told by their names."""
    for take in takes:
        if not any(word in name.lower() for name in take.names for word in UPPER):
            continue
        upper = np.array([any(word in name.lower() for word in UPPER) for name in take.names])
        above = np.repeat(take.heights > np.median(take.heights), 3)
        halves = [(np.flatnonzero(of), np.flatnonzero(~of)) for of in (above, upper)]
        learners = {TRANSPORT: TransportModel(), "regions apart": ApartModel(TransportModel(), *halves)}
        for count in labels:
            one = draw(take, count, seed)
            yield from scored(learners, one, [({**_of(take), "labels": count}, one.markers)])


def by_suggestion(takes: Sequence[Take], labels: Sequence[int], seed: int) -> Iterator[Score]:
    """Error after labelling the suggested frames and after labelling random ones, three random labels first."""
    model = TransportModel()
    for take in takes:
        for count in labels:
            one = draw(take, count, seed, unlabelled=200)
            setting = {**_of(take), "labels": count}
            for name, given in (("random", one.given), ("suggested", with_suggested(one, count))):
                yield Score(setting, name, rms(model.learn(given).map(one.markers), one.targets))


def with_suggested(one: Draw, count: int) -> Samples:
    """Return the first three labels of a draw, and suggested ones up to a count."""
    x, y, only = one.given.X_labelled[:3], one.given.Y_labelled[:3], one.given.X_only
    if count <= 3:
        return Samples(x, y, only, one.given.Y_only)
    picked = suggest(Samples(x, y, only, one.given.Y_only), count - 3).frames
    rest = np.delete(only, picked, axis=0)
    return Samples(np.vstack([x, only[picked]]), np.vstack([y, one.hidden[picked]]), rest, one.given.Y_only)
