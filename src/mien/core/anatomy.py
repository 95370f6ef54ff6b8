"""What moves a face from within: muscles, deformers, and the expressions that play them.

Orvalho, Zacur, Susin, §3: a generic rig is a skin with landmarks, bones, muscles,
attributes and templates.  Skin and bones are a `Rig`'s own; the rest is here.

Controls are numbers with names.  A muscle's or flexor's own name is its contraction
or strength; `name.tx … name.rz` move and turn a muscle, cluster or joint in its own
frame, in metres of the face the expression was authored on and in radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mien.core.arrays import Floats, Ints, distinct, floats, indices
from mien.core.clip import Clip
from mien.core.errors import InputError

AXES = ("tx", "ty", "tz", "rx", "ry", "rz")
"""Endings of the controls that move an influence: along and about the axes of its frame."""

Controls = Mapping[str, float]
"""Values of controls by name; what is not named is at rest."""


@dataclass(frozen=True, eq=False)
class Muscle:
    """A muscle, or one side of a paired one.

    A linear muscle pulls the skin along its fibre towards the fixed end.  A ring draws
    the skin towards the seam where it closes, over the ball beneath it if there is one.

    Attributes:
        name: which muscle, side and part (`frontalis_medial_left`).
        fibre: `(P, 3)` [m] from the fixed end to the end in the skin; of a ring, once around it.
        weights: `(N,)` how fully each vertex follows, 0 to 1.
        frame: `(4, 4)` where it sits and how it is turned: a rotation and a place [m].
        scale: the length here of one metre of the face the templates were authored on.
        shortening: by what share of its length a linear muscle shortens at contraction 1.
        seam: `(S, 3)` [m] the line on which a ring closes at contraction 1; None for a linear muscle.
        pivot: `(3,)` [m] the centre of the ball that a ring's skin slides over, if any.
    """

    name: str
    fibre: Floats
    weights: Floats
    frame: Floats
    scale: float = 1.0
    shortening: float = 0.3
    seam: Floats | None = None
    pivot: Floats | None = None

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "fibre", floats(self.fibre, (None, 3), f"fibre of {self.name!r}"))
        if len(self.fibre) < 2:
            raise InputError(f"the fibre of muscle {self.name!r} needs at least 2 points, it has {len(self.fibre)}.")
        put(self, "weights", shares(self.weights, f"weights of {self.name!r}"))
        put(self, "frame", floats(self.frame, (4, 4), f"frame of {self.name!r}"))
        if self.seam is not None:
            put(self, "seam", floats(self.seam, (None, 3), f"seam of {self.name!r}"))
        if self.pivot is not None:
            put(self, "pivot", floats(self.pivot, (3,), f"pivot of {self.name!r}"))


@dataclass(frozen=True, eq=False)
class Cluster:
    """A set of vertices that is moved and turned as one, fading at its border.

    Attributes:
        name: what it is called.
        weights: `(N,)` how fully each vertex follows, 0 to 1.
        frame: `(4, 4)` where it sits and how it is turned [m].
        scale: the length here of one metre of the face the templates were authored on.
    """

    name: str
    weights: Floats
    frame: Floats
    scale: float = 1.0

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "weights", shares(self.weights, f"weights of {self.name!r}"))
        put(self, "frame", floats(self.frame, (4, 4), f"frame of {self.name!r}"))


@dataclass(frozen=True, eq=False)
class Flexor:
    """A correction of how the skin follows a joint.

    At strength 1 a vertex of weight 1 stays with the joint's parent: lips that stay
    closed while the jaw opens.

    Attributes:
        name: what it is called.
        joint: the joint whose hold on the skin it loosens.
        weights: `(N,)` how fully each vertex lets go, 0 to 1.
    """

    name: str
    joint: str
    weights: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "weights", shares(self.weights, f"weights of {self.name!r}"))


@dataclass(frozen=True, eq=False)
class Labels:
    """One label per vertex.

    Attributes:
        names: the labels.
        of: `(N,)` index of each vertex's label.
    """

    names: tuple[str, ...]
    of: Ints

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "names", distinct(self.names, "labels"))
        put(self, "of", indices(self.of, (None,), len(self.names), "vertex labels"))


@dataclass(frozen=True, eq=False)
class Anatomy:
    """Everything of a generic rig beyond skin, bones and shapes.

    Attributes:
        muscles, clusters, flexors: the influences and deformers; names are distinct over all three.
        fields: per-vertex attributes `(N,)` or `(N, C)`, by name (`muscle_stress`).
        labels: per-vertex labels, by name (`region`).
        templates: expressions as values of controls, by name.
        bases: the template that another is meant on top of, by name: `mouthClose` needs `jawOpen`.
        scripts: template weights over time, by name; channels are names of templates.
    """

    muscles: tuple[Muscle, ...] = ()
    clusters: tuple[Cluster, ...] = ()
    flexors: tuple[Flexor, ...] = ()
    fields: Mapping[str, Floats] = field(default_factory=dict)
    labels: Mapping[str, Labels] = field(default_factory=dict)
    templates: Mapping[str, Controls] = field(default_factory=dict)
    bases: Mapping[str, str] = field(default_factory=dict)
    scripts: Mapping[str, Clip] = field(default_factory=dict)

    def __post_init__(self) -> None:
        distinct([part.name for part in self.parts], "muscles, clusters and flexors")
        counts = {part.name: len(part.weights) for part in self.parts}
        counts |= {name: len(values) for name, values in self.fields.items()}
        counts |= {name: len(labels.of) for name, labels in self.labels.items()}
        if len(set(counts.values())) > 1:
            raise InputError(f"the parts of an anatomy cover different numbers of vertices: {counts}.")

    @property
    def parts(self) -> tuple[Muscle | Cluster | Flexor, ...]:
        """Everything that has weights on the skin."""
        return (*self.muscles, *self.clusters, *self.flexors)


def shares(values: Floats, what: str) -> Floats:
    """Return per-vertex shares, checked to lie between 0 and 1.

    Raises:
        InputError: a value outside.
    """
    checked = floats(values, (None,), what)
    if len(checked) and (checked.min() < -1e-9 or checked.max() > 1 + 1e-9):
        worst = int(np.argmax(np.maximum(-checked, checked - 1)))
        raise InputError(f"{what} must lie between 0 and 1; vertex {worst} has {checked[worst]:g}.")
    return checked
