"""One sweep for each figure of Bouaziz and Pauly 2014: rows of numbers, one per setting and method."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks.latent.cases import Draw, Take, draw, rms
from benchmarks.report import Row
from mien.core.arrays import Floats
from mien.retargeting.latent import LatentModel
from mien.retargeting.regression import CrossMappingModel, GprModel, RidgeModel, SvrModel
from mien.retargeting.samples import Samples
from mien.retargeting.suggest import suggest
from mien.retargeting.transport import TransportModel
from mien.retargeting.transport.learnt import LOOSE
from mien.retargeting.transport.principal import PrincipalSpace

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


def errors(
    learners: Learners, draws: Sequence[Draw], fixed: Row, spoil: Callable[[Floats], Floats] | None = None
) -> list[Row]:
    """Return a row for each learner with its error over draws and the seconds it took to learn."""
    rows = []
    for name, learner in learners.items():
        found, seconds = [], []
        for one in draws:
            start = time.perf_counter()
            learnt = learner.learn(one.given)
            seconds.append(time.perf_counter() - start)
            markers = one.markers if spoil is None else spoil(one.markers)
            found.append(rms(learnt.map(markers), one.targets))
        spread = float(np.std(found))
        rows.append(
            {
                **fixed,
                "method": name,
                "rms": float(np.mean(found)),
                "spread": spread,
                "learn_s": float(np.mean(seconds)),
            }
        )
    return rows


def by_labels(takes: Sequence[Take], learners: Learners, labels: Sequence[int], draws: int) -> list[Row]:
    """Figure 4: error against the number of labels, 100 unlabelled rows of each side."""
    rows = []
    for take in takes:
        for count in labels:
            fixed = {"take": take.name, "targets": take.kind, "labels": count}
            rows += errors(learners, [draw(take, count, seed) for seed in range(draws)], fixed)
    return rows


def by_unlabelled(takes: Sequence[Take], learners: Learners, counts: Sequence[int], draws: int) -> list[Row]:
    """Figure 5: error against the number of unlabelled rows of each side, 20 labels."""
    rows = []
    for take in takes:
        for count in counts:
            fixed = {"take": take.name, "targets": take.kind, "unlabelled": count}
            rows += errors(learners, [draw(take, 20, seed, unlabelled=count) for seed in range(draws)], fixed)
    return rows


def by_noise(takes: Sequence[Take], learners: Learners, levels: Sequence[float], draws: int) -> list[Row]:
    """Figure 6: error against the noise of every marker coordinate [mm], 20 labels."""
    rows = []
    for take in takes:
        for level in levels:
            fixed = {"take": take.name, "targets": take.kind, "noise_mm": level}
            rows += errors(learners, [draw(take, 20, seed, noise=level) for seed in range(draws)], fixed)
    return rows


def by_missing(takes: Sequence[Take], learners: Learners, shares: Sequence[float], draws: int) -> list[Row]:
    """Figure 7: error against the share of markers missing in each frame mapped, 20 labels."""
    rows = []
    for take in takes:
        for share in shares:
            fixed = {"take": take.name, "targets": take.kind, "missing": share}
            rows += errors(
                learners, [draw(take, 20, seed) for seed in range(draws)], fixed, partial(without, share=share)
            )
    return rows


def without(markers: Floats, share: float) -> Floats:
    """Return rows with a share of the markers of each missing, always the same ones."""
    rng = np.random.default_rng(3)
    unseen = rng.random((len(markers), markers.shape[1] // 3)) < share
    return np.where(np.repeat(unseen, 3, axis=1), np.nan, markers)


def by_foreign(takes: Sequence[Take], learners: Learners, labels: Sequence[int], draws: int) -> list[Row]:
    """Error where the target-only rows come from another take with the same targets."""
    rows = []
    for take in takes:
        for other in takes:
            if other is take or other.kind != take.kind or other.targets.shape[1] != take.targets.shape[1]:
                continue
            for count in labels:
                fixed = {"take": take.name, "targets": take.kind, "target_only": other.name, "labels": count}
                rows += errors(learners, [draw(take, count, seed, other=other) for seed in range(draws)], fixed)
    return rows


def by_posing(takes: Sequence[Take], draws: int) -> list[Row]:
    """Figure 8: error of the entries that were not given, when the two or three strongest of a pose are."""
    rows: list[Row] = []
    for take in takes:
        for given in (2, 3):
            found: dict[str, list[float]] = {"all rows": [], "labels only": [], "the rest at rest": []}
            for seed in range(draws):
                one = draw(take, 20, seed)
                away = np.abs(one.targets - np.median(one.given.Y, axis=0))
                free = np.argsort(np.argsort(-away, axis=1), axis=1) >= given
                asked = np.where(free, np.nan, one.targets)
                spaces = {
                    "all rows": PrincipalSpace.of(one.given.Y),
                    "labels only": PrincipalSpace.of(one.given.Y_labelled),
                }
                for name, space in spaces.items():
                    found[name].append(rms(space.loosened(LOOSE).completed(asked)[free], one.targets[free]))
                rest = np.broadcast_to(np.median(one.given.Y, axis=0), one.targets.shape)
                found["the rest at rest"].append(rms(rest[free], one.targets[free]))
            rows += [
                {
                    "take": take.name,
                    "targets": take.kind,
                    "entries": given,
                    "method": name,
                    "rms": float(np.mean(values)),
                }
                for name, values in found.items()
            ]
    return rows


def by_suggestion(takes: Sequence[Take], labels: Sequence[int], draws: int) -> list[Row]:
    """Error after labelling the suggested frames and after labelling random ones, three random labels first."""
    rows: list[Row] = []
    model = TransportModel()
    for take in takes:
        for count in labels:
            found: dict[str, list[float]] = {"suggested": [], "random": []}
            for seed in range(draws):
                one = draw(take, count, seed, unlabelled=200)
                found["random"].append(rms(model.learn(one.given).map(one.markers), one.targets))
                found["suggested"].append(rms(model.learn(with_suggested(one, count)).map(one.markers), one.targets))
            rows += [
                {
                    "take": take.name,
                    "targets": take.kind,
                    "labels": count,
                    "method": name,
                    "rms": float(np.mean(values)),
                }
                for name, values in found.items()
            ]
    return rows


def with_suggested(one: Draw, count: int) -> Samples:
    """Return the first three labels of a draw, and suggested ones up to a count."""
    x, y, only = one.given.X_labelled[:3], one.given.Y_labelled[:3], one.given.X_only
    if count <= 3:
        return Samples(x, y, only, one.given.Y_only)
    picked = suggest(Samples(x, y, only, one.given.Y_only), count - 3).frames
    rest = np.delete(only, picked, axis=0)
    return Samples(np.vstack([x, only[picked]]), np.vstack([y, one.hidden[picked]]), rest, one.given.Y_only)
