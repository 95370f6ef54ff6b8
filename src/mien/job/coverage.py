"""What a take shows of a character's shapes, so that a calibration take can be mended before it is used.

The verdict goes by the weights that the take is explained with, not by how much a frame
looks like a shape: a movement of the whole face hides the small shapes in it and
resembles shapes that it does not contain (docs/calibration-take.md).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Clip, FileError, InputError, Note, Rig
from mien.core.arrays import Floats
from mien.io.formats import read_rig
from mien.job.pairs import DEFAULT_COUNT, find_pairs
from mien.job.performance import Performance, load_performance
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.range_of_motion.method import UNSEEN_CM
from mien.retargeting.range_of_motion.refit import SHOWN
from mien.retargeting.shape_retargeter import ShapeRetargeter
from mien.vocabularies import match

WELL = 0.5
"""A shape that is reached at half its strength is shown well."""
FULL = 0.99
"""The quantile over the frames that counts as reached; one odd frame does not."""

UNSEEN, NOT_SHOWN, WEAKLY, SHOWN_WELL = VERDICTS = ("cannot be seen", "not shown", "shown weakly", "shown well")


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
    count: int = DEFAULT_COUNT,
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
        count: how many pairs to make from landmarks between meshes.
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
    found, notes = find_pairs(performance, rig, pairs=pairs, landmarks=landmarks, count=count, neutral=neutral)
    markers = performance.points(found)
    rest = performance.neutral(found, neutral)
    # strength as performed: a calibrated fit would call every shape it saw full
    fitted = RangeOfMotion(full_range=False).fit(rig, markers, found, neutral=rest, head_moves=performance.head_moves)
    shapes = _of_points(fitted, fitted.retarget(markers)[0])
    return Coverage(take, character, _ranked(shapes), tuple(dict.fromkeys((*rig.notes, *notes, *fitted.notes))))
