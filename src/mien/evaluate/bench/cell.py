"""One method on one case: every figure of the benchmark."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mien.core import MienError
from mien.core.arrays import Floats, Ints
from mien.evaluate.bench.figures import ACCURACY
from mien.evaluate.bench.memory import Peak
from mien.evaluate.bench.table import Entrant
from mien.evaluate.cases import Case
from mien.evaluate.intersections import crossing_pairs, new_crossings
from mien.evaluate.played import FLOOR, Played, play
from mien.evaluate.suite import COPY, TRUTHS, compare
from mien.vocabularies import match

STRONGEST = 5
"""Frames at which crossings are counted, and that pictures show …"""
APART_S = 0.4
"""… at least this far from each other."""


@dataclass(frozen=True, eq=False)
class Witness:
    """A case with what is counted once for all methods.

    Attributes:
        case: the case.
        frames: the frames of the test in which the truth moves most, in order of time.
        at_rest: pairs of triangles that cross at rest.
        crossings: how many new ones the truth has at those frames, on average.
    """

    case: Case
    frames: Ints
    at_rest: Ints
    crossings: float

    @staticmethod
    def of(case: Case) -> Witness:
        """Look at a case."""
        truth = np.asarray(case.truth_range.values)
        frames = strongest(case, truth)
        rest = crossing_pairs(case.character.neutral.vertices, case.character.neutral.triangles)
        return Witness(case, frames, rest, float(new_crossings(case.character, truth[frames], rest).mean()))


@dataclass(frozen=True, eq=False)
class Cell:
    """What a method made of a case.

    Attributes:
        method: the entrant's name.
        identity: who acted.
        given: what the method got besides take and pairs, in words.
        figures: by key; those against the truth are of the range truth.
        absolute: the same against the absolute truth.
        busy_ms: for how long a frame keeps processors busy [ms]: steadier than its time, where others use the machine.
        poses: `(P, K)` weights at the witness's frames; None if it failed.
        failed: why there is no result; empty if there is.
    """

    method: str
    identity: str
    given: str = ""
    figures: Mapping[str, float] = field(default_factory=dict)
    absolute: Mapping[str, float] = field(default_factory=dict)
    busy_ms: float = float("nan")
    poses: Floats | None = None
    failed: str = ""


def measure(witness: Witness, entrant: Entrant, identity: str) -> Cell:
    """Let a method play a case, and measure it; a method that cannot says why."""
    case = witness.case
    if entrant.method == COPY and not match(case.recording.names, case.character.blendshapes.names).matrix.any():
        return Cell(entrant.name, identity, failed="actor and character share no names")
    peak = Peak()
    try:
        played = play(case, entrant.method, entrant.settings)
    except MienError as error:
        return Cell(entrant.name, identity, failed=str(error))
    memory = peak.above()
    poses = played.clip.channels(case.character.blendshapes.names)[witness.frames]
    truths = {truth: compare(case, played.clip, truth) for truth in TRUTHS}
    if entrant.method == FLOOR:
        truths["absolute"] = compare(case, play(case, FLOOR, entrant.settings, "absolute").clip, "absolute")
    figures = {key: float(truths["range"].get(key, np.nan)) for key in ACCURACY}
    figures |= {
        "fit_mm": _fit(played),
        "crossings": float(new_crossings(case.character, poses, witness.at_rest).mean()),
        "frame_ms": 1000 * played.play_s / len(played.clip),
        "fit_s": played.fit_s,
        "memory_mb": memory,
    }
    busy = 1000 * played.busy_s / len(played.clip)
    absolute = {key: float(truths["absolute"].get(key, np.nan)) for key in ACCURACY}
    return Cell(entrant.name, identity, played.given, figures, absolute, busy, poses)


def strongest(case: Case, truth: Floats) -> Ints:
    """Return the frames in which the truth moves the character most, some time apart, ascending."""
    surface = case.yardsticks["range"].surface
    assert surface is not None
    motion = np.zeros(len(truth))
    for axis in surface:
        motion += ((truth @ axis[:, :: max(1, axis.shape[1] // 300)]) ** 2).sum(axis=1)
    gap = round(APART_S * case.test.fps)
    chosen: list[int] = []
    for frame in np.argsort(-motion, kind="stable"):
        if all(abs(int(frame) - other) >= gap for other in chosen):
            chosen.append(int(frame))
        if len(chosen) == STRONGEST:
            break
    return np.sort(np.array(chosen, dtype=np.int64))


def _fit(played: Played) -> float:
    per_frame = played.report.fit_mm[np.isfinite(played.report.fit_mm)]
    return float(per_frame.mean()) if per_frame.size else float("nan")
