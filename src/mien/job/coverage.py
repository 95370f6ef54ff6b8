"""What a take shows of a character's shapes, so that a calibration take can be mended before it is used.

The verdict goes by the weights that the take is explained with.  How much a frame looks
like a shape says less: a movement of the whole face hides the small shapes in it and
resembles shapes that it does not contain (docs/calibration-take.md).  Only a close
likeness counts, because a character's shapes may be so large that no actor fills them.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Clip, InputError, Note, Rig
from mien.core.arrays import Floats
from mien.io.formats import read_rig
from mien.job.pairs import find_pairs
from mien.job.performance import load_performance
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.range_of_motion.method import UNSEEN_CM
from mien.retargeting.range_of_motion.refit import SHOWN
from mien.retargeting.shape_retargeter import ShapeRetargeter
from mien.vocabularies import match

WELL = 0.5
"""A shape that is reached at half its strength is shown well."""
ALIKE = 0.8
"""A frame this like a shape shows it well, however little of it the actor fills."""
FULL = 0.99
"""The quantile over the frames that counts as reached; one odd frame does not."""

SAID = ("shapes-unseen", "shapes-without-evidence", "shapes-off")
"""Notes of the fit that the verdicts replace."""
BESIDE = 2.0
"""A shape that moves the face this much farther somewhere than at any captured point happens beside the points."""

VERDICTS = NOT_SHOWN, WEAKLY, SHOWN_WELL, UNSEEN, AT_REST = (
    "not shown",
    "shown weakly",
    "shown well",
    "cannot be seen",
    "kept at rest",
)
"""What a take says of a shape, what it lacks first, what no take could change last."""


@dataclass(frozen=True)
class ShapeCoverage:
    """What a take shows of one shape.

    Attributes:
        name: of the shape, or of the channel.
        reached: the largest weight, the 99th percentile of the frames.
        correlation: how much the frame most like the shape looks like it; None for weights.
        second: when that frame is, or for weights when the channel is strongest.
        verdict: one of `VERDICTS`.
    """

    name: str
    reached: float
    correlation: float | None
    second: float
    verdict: str


@dataclass(frozen=True)
class Coverage:
    """What a take shows.

    Attributes:
        take, character: the files; the character is None for bare weights.
        shapes: what needs attention first.
        notes: of the fit.
    """

    take: Path
    character: Path | None
    shapes: tuple[ShapeCoverage, ...]
    notes: tuple[Note, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the coverage as `mien inspect --coverage --json` prints it."""
        counts = Counter(shape.verdict for shape in self.shapes)
        return {
            "take": str(self.take),
            "character": None if self.character is None else str(self.character),
            "verdicts": {verdict: counts[verdict] for verdict in VERDICTS},
            "shapes": [asdict(shape) for shape in self.shapes],
            "warnings": [asdict(note) for note in self.notes],
        }


def coverage(
    take: Path,
    character: Path | None = None,
    *,
    actor: Path | None = None,
    pairs: Path | None = None,
    landmarks: tuple[Path, Path] | None = None,
    neutral: str | None = None,
) -> Coverage:
    """Say which shapes a take shows, how strongly, and which it does not show.

    Weights without the actor's rig are judged channel by channel; with a character, the
    channels that its shapes take their names from.

    Args:
        take: markers, an animated face, or weights.
        character: the rig whose shapes are asked about.
        actor: the rig that weights play on.
        pairs: which point is which.
        landmarks: a landmark file for each side.
        neutral: frame number or file of the actor's neutral; found if None.

    Raises:
        FileError: a file is wrong.
        InputError: points are to be judged without a character, or they do not fit it.
    """
    performance = load_performance(take, actor)
    rig = None if character is None else read_rig(character)
    clip = performance.clip
    if clip is not None and (performance.actor is None or rig is None):
        return Coverage(take, character, _ranked(_of_weights(clip, rig)), clip.notes)
    if rig is None:
        raise InputError(f"{take} holds markers; what they show depends on the character, so give its file as well.")
    found, notes = find_pairs(performance, rig, pairs=pairs, landmarks=landmarks, neutral=neutral)
    markers = performance.points(found)
    rest = performance.neutral(found, neutral)
    # strength as performed: a calibrated fit would call every shape it saw full
    fitted = RangeOfMotion(full_range=False).fit(rig, markers, found, neutral=rest, head_moves=performance.head_moves)
    shapes = _of_points(fitted, fitted.retarget(markers)[0], rig)
    remarks = (note for note in (*rig.notes, *notes, *fitted.notes) if note.code not in SAID)
    return Coverage(take, character, _ranked(shapes), tuple(dict.fromkeys(remarks)))


def _of_points(fitted: ShapeRetargeter, clip: Clip, rig: Rig) -> list[ShapeCoverage]:
    """Judge shapes by the weights that the take is explained with, if the points see them."""
    points = np.linalg.norm(fitted.alignment.original, axis=2).max(axis=1)
    anywhere = np.linalg.norm(rig.blendshapes.deltas, axis=2).max(axis=1)
    anywhere /= fitted.centimetre * fitted.placement.scale
    unseen = (points < UNSEEN_CM) | (anywhere > BESIDE * points)
    off = fitted.solver.settings.kept_at_rest(clip.names)
    reached, likest = _reached(clip.values), fitted.alignment.similarity.correlation.argmax(axis=1)
    found = []
    for k, name in enumerate(clip.names):
        verdict = AT_REST if name in off else UNSEEN if unseen[k] else _verdict(reached[k], fitted.evidence[name])
        second = round(float(likest[k]) / clip.fps, 2)
        found.append(ShapeCoverage(name, round(float(reached[k]), 3), fitted.evidence[name], second, verdict))
    return found


def _of_weights(clip: Clip, rig: Rig | None) -> list[ShapeCoverage]:
    """Judge channels, or the shapes that take their names from channels, by their own values."""
    tracked = np.asarray(~np.isnan(clip.values).any(axis=1))
    if not tracked.any() or not clip.names:
        raise InputError("the take holds no weights in any frame, so it shows no shape.")
    found = match(clip.names, clip.names if rig is None else rig.blendshapes.names)
    values = np.where(tracked[:, None], found.apply(np.nan_to_num(clip.values)), 0.0)
    driven = ~np.isin(found.target, found.unmatched_target)
    rows = zip(found.target, _reached(values[tracked]), values.argmax(axis=0), driven.tolist(), strict=True)
    return [
        ShapeCoverage(name, round(float(w), 3), None, round(frame / clip.fps, 2), _verdict(w) if known else UNSEEN)
        for name, w, frame, known in rows
    ]


def _reached(weights: Floats) -> Floats:
    return np.asarray(np.quantile(weights, FULL, axis=0))


def _verdict(reached: float, likeness: float = 0.0) -> str:
    if reached < SHOWN:
        return NOT_SHOWN
    return SHOWN_WELL if reached >= WELL or likeness >= ALIKE else WEAKLY


def _ranked(shapes: list[ShapeCoverage]) -> tuple[ShapeCoverage, ...]:
    return tuple(sorted(shapes, key=lambda shape: (VERDICTS.index(shape.verdict), shape.reached, shape.name)))
