"""Where the extremes of a face come from: a rig's blendshapes by name, or frames picked from a take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mien.core import Examples, InputError, Labels, Note, Rig
from mien.core.arrays import Floats
from mien.core.errors import unknown
from mien.retargeting.layers.model import Layer, LayeredFace, natural_regions, regions_of_groups, told_apart
from mien.vocabularies import arkit_name, shape_key
from mien.vocabularies.expressions import BLINKS, LAYER_EMOTIONS, LAYER_REGION, NEUTRAL, VISEMES

Recipe = Mapping[str, float]
"""Weights of blendshapes; none for the face at rest."""
Table = Mapping[str, Mapping[str, Recipe]]
"""Per layer and extreme, the blendshapes that make it."""

EMOTION, SPEECH, BLINK = "emotion", "speech", "blink"
SPLIT = "@"
"""Between an extreme and its region in the name of a split shape: `emotion.joy@mouth`."""
_SPEAKING = ("jaw", "mouthClose", "mouthFunnel", "mouthPucker", "tongue")


class Pick(NamedTuple):
    """A frame that shows an extreme.

    Attributes:
        layer, extreme: what it shows.
        frame: where in the take.
    """

    layer: str
    extreme: str
    frame: int


def table_of(rig: Rig) -> Table:
    """Tell from a rig's names which blendshapes are extremes of which layer.

    Shapes split by region (`emotion.joy@mouth`) go back together.  Names of emotions, visemes
    and blinks are taken as they are.  A rig without them has its own shapes as extremes: lids
    that close are blinks, the jaw and rounded lips speech, the rest emotion; the two halves of
    a shape are also joined, since a layer shows one extreme at a time.
    """
    names = [name for name in rig.blendshapes.names if name not in rig.blendshapes.empty]
    split = _split_table(names)
    if split:
        return split
    spelled = {shape_key(name): name for name in names}

    def named(wanted: Sequence[str]) -> dict[str, Recipe]:
        return {w: {spelled[shape_key(w)]: 1.0} for w in wanted if shape_key(w) in spelled}

    emotions, visemes, blinks = named(LAYER_EMOTIONS), named(tuple(VISEMES)), named(BLINKS)
    used = {shape for part in (emotions, visemes, blinks) for recipe in part.values() for shape in recipe}
    own = _joined([name for name in names if name not in used])
    lids = {e: r for e, r in own.items() if all((arkit_name(s) or s.lower()).lower().find("blink") >= 0 for s in r)}
    spoken = {
        e: r for e, r in own.items() if e not in lids and all((arkit_name(s) or s).startswith(_SPEAKING) for s in r)
    }
    felt = {e: r for e, r in own.items() if e not in lids and e not in spoken}
    table: dict[str, dict[str, Recipe]] = {
        EMOTION: {NEUTRAL: {}, **({k: v for k, v in emotions.items() if k != NEUTRAL} or felt)},
        SPEECH: visemes if len(visemes) > 1 else {"viseme_sil": {}, **spoken},
        BLINK: {"blink_open": {}, **({k: v for k, v in blinks.items() if k != "blink_open"} or lids)},
    }
    return {layer: extremes for layer, extremes in table.items() if len(extremes) > 1}


def layers_of_rig(rig: Rig, table: Table | None = None) -> tuple[Layer, ...]:
    """Return the layers of a rig.

    Args:
        rig: a rig with blendshapes.
        table: which blendshapes make which extreme; told from their names if None.

    Raises:
        InputError: there are no layers, the table names an unknown shape, or two extremes are the same.
    """
    found = table_of(rig) if table is None else table
    if not found:
        raise InputError(
            f"nothing in the names of {rig.name} ({', '.join(rig.blendshapes.names[:8])} …) says which shapes are emotions, "
            "visemes or blinks; give a table of extremes."
        )
    shapes = rig.blendshapes
    layers = []
    for name, extremes in found.items():
        recipes = np.zeros((len(extremes), len(shapes)))
        for row, recipe in zip(recipes, extremes.values(), strict=True):
            for shape, weight in recipe.items():
                row[shapes.index(shape)] = weight
        offsets = np.tensordot(recipes, shapes.deltas, axes=1)
        layers.append(told_apart(Layer(name, tuple(extremes), offsets)))
    return tuple(layers)


def rig_face(rig: Rig, table: Table | None = None, masks: Sequence[str] = ()) -> LayeredFace:
    """Return a rig as a face in layers.

    Args:
        rig: the character, or the actor's own rig.
        table: which blendshapes make which extreme; told from their names if None.
        masks: vertex groups that are the regions, in their order; if none, those that the rig says itself
            (label `LAYER_REGION` of its anatomy), or else told from what moves them.

    Raises:
        InputError: as `layers_of_rig`, a mask is unknown, or masks leave vertices uncovered or overlap.
    """
    layers = layers_of_rig(rig, table)
    return LayeredFace(rig.neutral.vertices, layers, _masked(rig, layers, masks), rig.name, rig.notes)


def _masked(rig: Rig, layers: Sequence[Layer], masks: Sequence[str]) -> Labels:
    told = None if rig.anatomy is None else rig.anatomy.labels.get(LAYER_REGION)
    groups = dict(rig.neutral.groups)
    if told is not None:
        groups |= {name: np.flatnonzero(told.of == k) for k, name in enumerate(told.names)}
    for name in masks:
        if name not in groups:
            raise InputError(unknown(f"vertex group of {rig.name}", name, groups))
    if masks:
        return regions_of_groups(
            {name: groups[name] for name in masks}, len(rig.neutral.vertices), f"vertices of {rig.name}"
        )
    if told is not None:
        return told
    split = [name.rpartition(SPLIT) for name in rig.blendshapes.names if SPLIT in name]
    if not split:
        return natural_regions(layers)
    regions = tuple(dict.fromkeys(region for _, _, region in split))
    of = np.zeros(len(rig.neutral.vertices), np.int64)
    for name, _, region in split:
        moved = rig.blendshapes.deltas[rig.blendshapes.index(f"{name}{SPLIT}{region}")].any(axis=1)
        of[moved] = regions.index(region)
    return Labels(regions, of)


def picks_of(examples: Examples) -> tuple[Pick, ...]:
    """Return picked frames from labelled ones: `layer.extreme` is labelled above 0 at exactly one frame.

    Raises:
        InputError: a name without a layer, or an extreme labelled at no or several frames.
    """
    picks = []
    for name, values in zip(examples.names, examples.values.T, strict=True):
        layer, dot, extreme = name.partition(".")
        if not (layer and dot and extreme):
            raise InputError(f"the examples label {name!r}, but an extreme is named layer.extreme, as in emotion.joy.")
        frames = examples.frames[np.nan_to_num(values) > 0]
        if len(frames) != 1:
            raise InputError(f"the extreme {name!r} must be labelled at exactly one frame, but is at {len(frames)}.")
        picks.append(Pick(layer, extreme, int(frames[0])))
    return tuple(picks)


def picked_layers(picks: Sequence[Pick], take: Floats, names: Sequence[str]) -> tuple[Layer, ...]:
    """Return the layers that picked frames of a take show.

    Args:
        picks: which frame shows which extreme.
        take: `(F, P, 3)` displacements from rest with the head held still; NaN where missing.
        names: `P` names of the points, for errors.

    Raises:
        InputError: a frame does not exist or misses a point, two extremes are the same; or as `Layer`.
    """
    if not picks:
        raise InputError("no frames are picked as extremes; name at least two of one layer.")
    offsets: dict[str, dict[str, Floats]] = {}
    for layer, extreme, frame in picks:
        if not 0 <= frame < len(take):
            raise InputError(
                f"{layer}.{extreme} is picked at frame {frame}, but the take has frames 0 … {len(take) - 1}."
            )
        gone = np.isnan(take[frame]).any(axis=1)
        if gone.any():
            missing = [name for name, g in zip(names, gone, strict=True) if g]
            raise InputError(
                f"{layer}.{extreme} is picked at frame {frame}, which misses {', '.join(missing[:6])}; "
                "pick a frame near it that sees every marker, or leave these markers out."
            )
        own = offsets.setdefault(layer, {})
        if extreme in own:
            raise InputError(f"{layer}.{extreme} is picked at two frames; an extreme is one frame.")
        own[extreme] = take[frame]
    return tuple(told_apart(Layer(name, tuple(own), np.stack(list(own.values())))) for name, own in offsets.items())


def split_notes(rig: Rig) -> tuple[Note, ...]:
    """Say which shapes are empty and thus no extremes."""
    empty = rig.blendshapes.empty
    if not empty:
        return ()
    return (
        Note("extremes-empty", f"{len(empty)} blendshapes move nothing and are no extremes: {', '.join(empty[:12])}."),
    )


def _joined(names: Sequence[str]) -> dict[str, Recipe]:
    """Return each shape as an extreme, and the two halves of a shape together as one."""
    found: dict[str, Recipe] = {name: {name: 1.0} for name in names}
    sides: dict[str, dict[str, str]] = {}
    for name in names:
        key = shape_key(name)
        if key.side:
            sides.setdefault(key.stem, {})[key.side] = name
    for stem, halves in sides.items():
        if len(halves) == 2 and stem not in found:
            found[stem] = dict.fromkeys(halves.values(), 1.0)
    return found


def _split_table(names: Sequence[str]) -> Table:
    table: dict[str, dict[str, dict[str, float]]] = {}
    for name in names:
        whole, at, _ = name.rpartition(SPLIT)
        layer, dot, extreme = whole.partition(".")
        if at and dot and layer and extreme:
            table.setdefault(layer, {}).setdefault(extreme, {})[name] = 1.0
    rest = {EMOTION: NEUTRAL, SPEECH: "viseme_sil", BLINK: "blink_open"}
    return {layer: {**({rest[layer]: {}} if layer in rest else {}), **own} for layer, own in table.items()}
