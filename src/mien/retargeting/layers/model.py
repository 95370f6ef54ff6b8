"""A face in layers: its points at rest, its regions, and the extremes of each layer.

Actor and character are the same kind of thing with other points (Kholgade, Matthews,
Sheikh 2011, §3):

    x = x_µ + Σ_jl w_jl M_l B_j α_j

Because the weights of a region and the coefficients of a layer sum to 1, adding an offset
to the mean and taking it from every extreme changes nothing: `x_µ` may be any face, and
here it is the one at rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mien.core import InputError, Labels, Note
from mien.core.arrays import Floats, Ints, distinct, floats
from mien.core.errors import unknown
from mien.solve.layered import layer_weights

RESTING = ("neutral", "blink_open", "viseme_sil")
"""Extremes that are the face at rest: a side that lacks one has it all the same."""
ALIKE = 1e-9
"""Extremes that differ by less than this share of the largest offset are the same."""


@dataclass(frozen=True, eq=False)
class Layer:
    """One process that moves the face, by its extremes.

    Attributes:
        name: what it is (`emotion`).
        extremes: `K` distinct names (`neutral`, `joy`, …); at least 2.
        offsets: `(K, P, 3)` of the points from rest, the columns of the paper's `B_j`.

    Raises:
        InputError: fewer than two extremes, or repeated names.
    """

    name: str
    extremes: tuple[str, ...]
    offsets: Floats

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "extremes", distinct(self.extremes, f"extremes of the layer {self.name!r}"))
        put(self, "offsets", floats(self.offsets, (len(self.extremes), None, 3), f"extremes of {self.name!r}"))
        if len(self.extremes) < 2:
            raise InputError(
                f"the layer {self.name!r} has {len(self.extremes)} extremes ({', '.join(self.extremes) or 'none'}), which "
                "nothing can be mixed between; give it at least two, the face at rest among them, or leave it out."
            )


def told_apart(layer: Layer) -> Layer:
    """Return the layer, once it is sure that no two of its extremes are the same face.

    Raises:
        InputError: two are.
    """
    flat = layer.offsets.reshape(len(layer.extremes), -1)
    close = ALIKE * max(float(np.abs(flat).max(initial=0.0)), 1e-300)
    for i, row in enumerate(flat):
        same = [k for k in range(i) if np.abs(flat[k] - row).max(initial=0.0) <= close]
        if same:
            raise InputError(
                f"the extremes {layer.extremes[same[0]]!r} and {layer.extremes[i]!r} of the layer {layer.name!r} are the same "
                "face at these points, so nothing tells them apart; pick other frames, or leave one out."
            )
    return layer


@dataclass(frozen=True, eq=False)
class LayeredFace:
    """A face in layers.

    Attributes:
        rest: `(P, 3)` the points at rest.
        layers: the `J` layers.
        regions: which region each point belongs to, the paper's masks: exactly one.
        name: how notes call it.
        notes: what was settled or left out when it was made.

    Raises:
        InputError: no layer, repeated names, or layers and regions for another number of points.
    """

    rest: Floats
    layers: tuple[Layer, ...]
    regions: Labels
    name: str = "face"
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "rest", floats(self.rest, (None, 3), f"points of {self.name!r}"))
        distinct([layer.name for layer in self.layers], f"layers of {self.name!r}")
        if not self.layers:
            raise InputError(f"{self.name} has no layers; give it at least one with two extremes.")
        counts = {layer.name: layer.offsets.shape[1] for layer in self.layers} | {"regions": len(self.regions.of)}
        wrong = {name: n for name, n in counts.items() if n != len(self.rest)}
        if wrong:
            raise InputError(f"{self.name} has {len(self.rest)} points, but these are for others: {wrong}.")

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """`K_j` of each layer."""
        return tuple(len(layer.extremes) for layer in self.layers)

    @cached_property
    def starts(self) -> Ints:
        """`(J + 1,)` where each layer's extremes begin among all `N`."""
        return np.concatenate([[0], np.cumsum(self.sizes)]).astype(np.int64)

    @cached_property
    def basis(self) -> Floats:
        """`(N, P, 3)` all extremes, layer after layer."""
        return np.ascontiguousarray(np.concatenate([layer.offsets for layer in self.layers]))

    @property
    def extremes(self) -> tuple[str, ...]:
        """`N` names `layer.extreme`: the channels of the coefficients."""
        return tuple(f"{layer.name}.{extreme}" for layer in self.layers for extreme in layer.extremes)

    @property
    def shares(self) -> tuple[str, ...]:
        """`m J` names `weight.region.layer`: the channels of the weights."""
        return tuple(f"weight.{region}.{layer.name}" for region in self.regions.names for layer in self.layers)

    def layer(self, name: str) -> int:
        """Return which layer has this name.

        Raises:
            InputError: none has.
        """
        names = [layer.name for layer in self.layers]
        if name not in names:
            raise InputError(unknown("layer", name, names))
        return names.index(name)

    def compose(self, weights: Floats, coefficients: Floats) -> Floats:
        """Return the face for layer weights and coefficients (eq. 4, 5), without head motion.

        Args:
            weights: `(…, m, J)`, the paper's `W`.
            coefficients: `(…, N)`, the paper's `α`.

        Returns:
            `(…, P, 3)` positions.
        """
        mixed = layer_weights(self.starts, weights, coefficients)
        points = np.empty((*mixed.shape[:-2], *self.rest.shape))
        for region in range(len(self.regions.names)):
            own = self.regions.of == region
            points[..., own, :] = np.tensordot(mixed[..., region, :], self.basis[:, own], axes=1)
        return points + self.rest

    def only(self, extremes: Mapping[str, Sequence[str]]) -> LayeredFace:
        """Return the face with these extremes of these layers, in this order."""
        layers = []
        for name, wanted in extremes.items():
            layer = self.layers[self.layer(name)]
            rows = [layer.extremes.index(extreme) for extreme in wanted]
            layers.append(Layer(name, tuple(wanted), layer.offsets[rows]))
        return replace(self, layers=tuple(layers))


def shared(actor: LayeredFace, character: LayeredFace) -> tuple[LayeredFace, LayeredFace, tuple[Note, ...]]:
    """Return both faces with the extremes that both have, in the actor's order, and what was left out.

    An extreme that is the face at rest (`RESTING`) is kept if either side has it.  Regions
    correspond by their order, whatever each side calls them.

    Raises:
        InputError: the numbers of regions differ, or no layer has two extremes on both sides.
    """
    mine, theirs = actor.regions.names, character.regions.names
    if len(mine) != len(theirs):
        raise InputError(
            f"{actor.name} has the regions {', '.join(mine)}, {character.name} has {', '.join(theirs)}: regions correspond "
            "in their order, so both need as many."
        )
    actor, character = _with_rest(actor, character), _with_rest(character, actor)
    kept: dict[str, list[str]] = {}
    notes = []
    for layer in actor.layers:
        other = next((c for c in character.layers if c.name == layer.name), None)
        known = () if other is None else other.extremes
        both = [extreme for extreme in layer.extremes if extreme in known]
        for face, own, others in ((actor, layer.extremes, known), (character, known, layer.extremes)):
            alone = [extreme for extreme in own if extreme not in others]
            if alone:
                listed = ", ".join(alone)
                text = (
                    f"{len(alone)} extremes of {layer.name!r} are left out because only {face.name} has them: {listed}."
                )
                notes.append(Note("extremes-unshared", text, face.name))
        if len(both) >= 2:
            kept[layer.name] = both
        else:
            notes.append(
                Note(
                    "layer-dropped", f"the layer {layer.name!r} has fewer than two extremes on both sides.", layer.name
                )
            )
    notes += [
        Note("layer-dropped", f"only {character.name} has the layer {layer.name!r}; it is left out.", layer.name)
        for layer in character.layers
        if layer.name not in [own.name for own in actor.layers]
    ]
    if not kept:
        raise InputError(
            f"no layer has two extremes that both {actor.name} ({', '.join(actor.extremes[:8])} …) and {character.name} "
            f"({', '.join(character.extremes[:8])} …) have; name them alike."
        )
    return actor.only(kept), character.only(kept), tuple(notes)


def _with_rest(face: LayeredFace, other: LayeredFace) -> LayeredFace:
    """Give a face the resting extremes that only the other side names, where it has none at rest itself."""
    layers = []
    for layer in face.layers:
        twin = next((o for o in other.layers if o.name == layer.name), None)
        missing = [e for e in (() if twin is None else twin.extremes) if e in RESTING and e not in layer.extremes]
        moving = bool(layer.offsets.any(axis=(1, 2)).all())
        if missing and moving:
            zero = np.zeros((1, *face.rest.shape))
            layer = Layer(layer.name, (*missing[:1], *layer.extremes), np.concatenate([zero, layer.offsets]))
        layers.append(layer)
    return replace(face, layers=tuple(layers))


def regions_of_groups(groups: Mapping[str, Ints], count: int, what: str = "points") -> Labels:
    """Return regions from groups of points.

    Args:
        groups: indices of each region's points, by the region's name.
        count: how many points there are.
        what: what to call them in errors.

    Raises:
        InputError: a point is in no group or in several.
    """
    covered = np.zeros(count, np.int64)
    of = np.zeros(count, np.int64)
    for region, (name, members) in enumerate(groups.items()):
        ids = np.unique(np.asarray(members, np.int64))
        if len(ids) and (ids[0] < 0 or ids[-1] >= count):
            raise InputError(
                f"the mask {name!r} holds index {ids[-1] if ids[-1] >= count else ids[0]}, but there are {count} {what}."
            )
        covered[ids] += 1
        of[ids] = region
    for wrong, why in ((covered == 0, "in no mask"), (covered > 1, "in more than one mask")):
        if wrong.any():
            first = np.flatnonzero(wrong)
            names = [name for name, members in groups.items() if first[0] in members]
            raise InputError(
                f"{len(first)} of {count} {what} are {why} ({', '.join(map(str, first[:6]))}{' …' if len(first) > 6 else ''}"
                f"{': ' + ', '.join(names) if names else ''}); every one must be in exactly one of {', '.join(groups)}."
            )
    return Labels(tuple(groups), of)


def natural_regions(layers: Sequence[Layer]) -> Labels:
    """Tell the face's regions from what moves them: `face`, `mouth` and `eyes`.

    Each layer is compared with its own largest movement, since a body that swells with
    emotion moves everything, its lids and lips too.  A point belongs to the eyes where
    blinking moves it, and more so than speech; else to the mouth where speech moves it; else to
    the rest of the face, as do points that emotions move far and the others hardly.

    Args:
        layers: the layers; those not called `speech` or `blink` count as emotion.
    """
    count = layers[0].offsets.shape[1]
    reach = {name: np.zeros(count) for name in ("emotion", "speech", "blink")}
    for layer in layers:
        kind = layer.name if layer.name in reach else "emotion"
        spread = layer.offsets - layer.offsets.mean(axis=0)
        reach[kind] = np.maximum(reach[kind], np.linalg.norm(spread, axis=2).max(axis=0))
    part = {name: values / max(float(values.max(initial=0.0)), 1e-300) for name, values in reach.items()}
    least = np.maximum(FAINT, SHARE * part["emotion"])
    eyes = (part["blink"] > least) & (part["blink"] > part["speech"])
    mouth = ~eyes & (part["speech"] > least)
    of = np.where(eyes, 2, np.where(mouth, 1, 0))
    return Labels(("face", "mouth", "eyes"), of)


SHARE = 1 / 5
"""A layer rules a region where its share of its largest movement is at least this part of the emotions'."""
FAINT = 0.05
"""Less than this share of a layer's largest movement is no movement."""
