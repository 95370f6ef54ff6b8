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
from mien.library.expressions.scripts import SCRIPTS, Cue
from mien.library.expressions.scripts import scripted as acted
from mien.retargeting import make_method
from mien.retargeting.layers import LayeredRetargeter, layer_clip, rig_face, split_clip, split_rig, table_of
from mien.rigging.baking import scripted
from mien.vocabularies import match
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


def arkit_actor() -> Rig:
    """Return the actor with ARKit's shapes."""
    return cast_member("actor", tuple(ARKIT_NAMES))


def in_arkit(clip: Clip) -> Clip:
    """Return a clip in ARKit's names, matched by name."""
    return Clip(tuple(ARKIT_NAMES), clip.values @ match(clip.names, ARKIT_NAMES).matrix.T, clip.fps)


def seen(clip: Clip, rig: Rig | None = None) -> Markers:
    """Return the actor's points while it plays a clip of its extremes, or of a rig's shapes on the same vertices."""
    rig = rig or cast("actor")
    source = points().source
    assert source is not None
    return trace(rig, clip, source, points().names)


@cache
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
    settings = {} if closure is None else {"closure": closure} | ({"closing": 0.0} if closure == 1 else {})
    rest = Neutral(source.of(actor.neutral.vertices), None, 0.0)
    made = make_method("layers", settings).fit(
        cast(character), seen(clip), neutral=rest, head_moves=False, examples=examples
    )
    assert isinstance(made, LayeredRetargeter)
    return made


def sentence() -> Clip:
    """Return the built-in sentence as weights of the actor's extremes."""
    return scripted(SCRIPTS["sentence"], cast("actor").blendshapes)


FEELINGS = ("neutral", "joy", "surprise")
SAYING = 2.0
"""Seconds that each feeling lasts."""
_SOUNDS = tuple(
    cue
    for start in np.arange(0.0, SAYING * len(FEELINGS), 0.5)
    for cue in (
        Cue("viseme_PP", start + 0.06, start + 0.34, 1.0, 0.08),
        Cue("viseme_aa", start + 0.24, start + 0.56, 1.0, 0.1),
    )
)


def babble() -> tuple[Rig, Clip, Clip]:
    """Let the actor say /pa/ four times with each feeling, its lips closing fully.

    Returns:
        The actor with a shape per extreme and region, weights of those, and the weights of `viseme_PP`
        and `viseme_aa` over time.
    """
    said = acted(_SOUNDS, SAYING * len(FEELINGS))
    face = rig_face(cast("actor"))
    spoken = said.values.sum(axis=1).clip(0, 1)
    weights = np.zeros((len(said), len(face.regions.names), len(face.layers)))
    weights[:, :, face.layer("emotion")] = 1.0
    mouth = face.regions.names.index("mouth")
    weights[:, mouth, face.layer("speech")], weights[:, mouth, face.layer("emotion")] = spoken, 1 - spoken
    shares = np.zeros((len(said), len(face.extremes)))
    feeling = np.minimum((np.arange(len(said)) / said.fps / SAYING).astype(int), len(FEELINGS) - 1)
    for k, name in enumerate(FEELINGS):
        shares[:, face.extremes.index(f"emotion.{name}")] = feeling == k
    total = np.maximum(said.values.sum(axis=1), 1e-9)
    for name, level in zip(said.names, said.values.T, strict=True):
        shares[:, face.extremes.index(f"speech.{name}")] = np.where(total > 1e-6, level / total, said.names[0] == name)
    shares[:, face.extremes.index("blink.blink_open")] = 1.0
    rig = split_rig(cast("actor"), face)
    clip = split_clip(face, layer_clip(face, weights, shares, said.fps))
    return rig, Clip(rig.blendshapes.names, clip.channels(rig.blendshapes.names), clip.fps), said
