"""The built-in actor speaking, and the cast in the same layers."""

from __future__ import annotations

from functools import cache

import numpy as np

from mien.capture import Neutral
from mien.capture.trace import trace
from mien.core import Clip, Correspondence, Examples, Markers, Rig
from mien.job.layers import own_points
from mien.library.cast import EXTREMES, cast_member
from mien.library.characters import globe, radio
from mien.library.expressions.scripts import Cue
from mien.library.expressions.scripts import scripted as acted
from mien.library.generic import generic_rig
from mien.retargeting import make_method
from mien.retargeting.layers import LayeredRetargeter, table_of
from mien.rigging.baking import scripted
from mien.vocabularies.arkit import ARKIT_NAMES

COUNT = 99
CAST = ("actor", "cartoon", "tortoise", "globe", "radio")


@cache
def cast(name: str) -> Rig:
    """Return one of the cast with 29 emotions, 12 visemes and 3 blinks."""
    if name == "globe":
        return globe()
    return radio() if name == "radio" else cast_member(name, EXTREMES)


@cache
def points() -> Correspondence:
    """Return the points that the actor is seen at, the lips' centres among them."""
    return own_points(cast("actor"), None, COUNT)


def seen(clip: Clip, arkit: bool = False) -> Markers:
    """Return the actor's points while it plays a clip of its extremes, or of ARKit's shapes."""
    rig = cast_member("actor", tuple(ARKIT_NAMES)) if arkit else cast("actor")
    source = points().source
    assert source is not None
    return trace(rig, clip, source, points().names)


def fitted(character: str, closure: float | None = None) -> LayeredRetargeter:
    """Bring the actor and one of the cast into the same layers.

    Args:
        character: one of `CAST`.
        closure: the strength of the bias to closed lips, 1 as published; the method's own if None.
    """
    actor, source = cast("actor"), points().source
    assert source is not None
    rows, names = [], []
    for layer, extremes in table_of(actor).items():
        for extreme, recipe in extremes.items():
            rows.append([recipe.get(shape, 0.0) for shape in actor.blendshapes.names])
            names.append(f"{layer}.{extreme}")
    clip = Clip(actor.blendshapes.names, np.array(rows), 60.0)
    examples = Examples(np.arange(len(names)), tuple(names), np.where(np.eye(len(names)) > 0, 1.0, np.nan))
    settings = {} if closure is None else {"closure": closure}
    rest = Neutral(source.of(actor.neutral.vertices), None, 0.0)
    made = make_method("layers", settings).fit(
        cast(character), seen(clip), neutral=rest, head_moves=False, examples=examples
    )
    assert isinstance(made, LayeredRetargeter)
    return made


def sentence() -> Clip:
    """Return the built-in sentence as weights of the actor's extremes."""
    return scripted(generic_rig().anatomy.scripts["sentence"], cast("actor").blendshapes)


BABBLE = tuple(
    cue
    for start, feeling in ((0.0, None), (2.0, "joy"), (4.0, "surprise"))
    for cue in (
        *(Cue("viseme_PP", start + 0.5 * i + 0.1, start + 0.5 * i + 0.34, 1.0, 0.08) for i in range(4)),
        *(Cue("viseme_aa", start + 0.5 * i + 0.3, start + 0.5 * i + 0.6, 0.8, 0.1) for i in range(4)),
        *((Cue(feeling, start, start + 2.0, 0.5, 0.3),) if feeling else ()),
    )
)
"""/pa/ twelve times: without feeling, with joy, with surprise."""


def babble() -> Clip:
    """Return `BABBLE` as weights of the actor's extremes."""
    return scripted(acted(BABBLE, 6.2), cast("actor").blendshapes)
