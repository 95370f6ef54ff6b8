"""What methods need besides a take: labelled frames, the actor's extremes, the recorded weights.

Each is made from the truth the way a careful person would make it, and named, so that a
table can say what every result cost to set up.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, Markers
from mien.core.arrays import Ints
from mien.evaluate.cases import Case
from mien.retargeting.by_example import ExampleMethod
from mien.retargeting.copying import Copy
from mien.retargeting.labelled import evenly
from mien.retargeting.layers import Layers
from mien.retargeting.layers.posed import posed_extremes, shared_table
from mien.retargeting.method import Method
from mien.retargeting.samples import samples
from mien.retargeting.suggest import suggest

LABELS = 20
"""Frames that are labelled for the methods that learn from labels."""
CANDIDATES = 1000
"""Frames of the training take, evenly, that the labelled ones are chosen from."""


class Given(NamedTuple):
    """What a method is fitted to.

    Attributes:
        what: in words, for a table; empty if nothing but the take and the pairs.
        training: what it learns from.
        test: what it then maps.
        pairs: which point is which; None if it does not need to know.
        neutral: the actor at rest, or None if it is to be found.
        examples: labels or extremes.
    """

    what: str
    training: Markers | Clip
    test: Markers | Clip
    pairs: Correspondence | None
    neutral: Neutral | None
    examples: Examples | None = None


def given(case: Case, method: Method | Any) -> Given:
    """Return what a method gets in a case."""
    if isinstance(method, Copy):
        return Given("recorded weights", case.recording, case.recording, None, None)
    usual = Given("", case.training, case.test, case.pairs, case.neutral)
    if isinstance(method, ExampleMethod):
        return usual._replace(what=f"{LABELS} labels", examples=case.labels(chosen_frames(case, LABELS)))
    if isinstance(method, Layers):
        return _extremes(case) or usual._replace(what="the character's extremes")
    return usual


def chosen_frames(case: Case, count: int) -> Ints:
    """Return frames of the training take worth labelling: the calmest, and those that then tell most (`suggest`)."""
    points = np.asarray(case.prepared.take)
    rows = points.reshape(len(points), -1)
    among = evenly(len(rows), CANDIDATES)
    still = among[int(np.nanargmin(np.nanmean(rows[among] ** 2, axis=1)))]
    others = np.setdiff1d(among, [still])
    told = samples(rows[[still]], np.zeros((1, 1)), rows[others])
    return np.sort(np.append(others[suggest(told, count - 1).frames], still))


def _extremes(case: Case) -> Given | None:
    """Return the actor's own shapes as its extremes, one clean frame each; None if the character knows none of them."""
    shared = shared_table(case.actor, case.character)
    if not shared or case.pairs.source is None:
        return None
    take, examples = posed_extremes(case.actor, case.pairs, shared, case.training.fps)
    rest = Neutral(case.pairs.source.of(case.actor.neutral.vertices), None, 0.0)
    return Given("the actor's extremes", take, case.test, None, rest, examples)
