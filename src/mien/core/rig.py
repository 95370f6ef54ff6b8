"""A face that can be posed: neutral mesh, blendshapes, and skin where there is one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from mien.core.anatomy import Anatomy
from mien.core.arrays import Floats, Ints, distinct, floats, indices
from mien.core.correctives import Correctives
from mien.core.errors import InputError, Note, unknown
from mien.core.mesh import Mesh, SurfacePoints

Colour = tuple[float, float, float]
"""Linear red, green and blue between 0 and 1."""


@dataclass(frozen=True, eq=False)
class Blendshapes:
    """Named displacements from the neutral.

    Attributes:
        names: `K` distinct names, in the order of the file.
        deltas: `(K, N, 3)` displacements [m].
    """

    names: tuple[str, ...]
    deltas: Floats

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "names", distinct(self.names, "blendshapes"))
        put(self, "deltas", floats(self.deltas, (len(self.names), None, 3), "blendshape deltas"))

    def __len__(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """Return the row of a shape.

        Raises:
            InputError: there is no shape of that name.
        """
        if name not in self.names:
            raise InputError(unknown("blendshape", name, self.names))
        return self.names.index(name)

    @property
    def empty(self) -> tuple[str, ...]:
        """Names of the shapes that move nothing."""
        still = np.asarray(~self.deltas.any(axis=(1, 2)))
        return tuple(name for name, s in zip(self.names, still, strict=True) if s)


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints in a tree; `rest` are world matrices at rest.

    Attributes:
        names: `J` joint names.
        parents: `(J,)` index of the parent, -1 at a root.
        rest: `(J, 4, 4)` world transforms at rest [m].
    """

    names: tuple[str, ...]
    parents: Ints
    rest: Floats

    def __post_init__(self) -> None:
        put = object.__setattr__
        j = len(self.names)
        put(self, "names", tuple(str(n) for n in self.names))
        parents = indices(np.asarray(self.parents) + 1, (j,), j + 1, "joint parents") - 1
        parents.flags.writeable = False
        put(self, "parents", parents)
        put(self, "rest", floats(self.rest, (j, 4, 4), "joint rest matrices"))


@dataclass(frozen=True, eq=False)
class Skin:
    """Linear blend skinning of the mesh by the skeleton's joints.

    Attributes:
        joints: `(N, I)` joint index of each influence.
        weights: `(N, I)` its weight; each row sums to 1.
        inverse_bind: `(J, 4, 4)` from the mesh's own space to each joint's.
    """

    joints: Ints
    weights: Floats
    inverse_bind: Floats

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "weights", floats(self.weights, (None, None), "skin weights"))
        put(self, "inverse_bind", floats(self.inverse_bind, (None, 4, 4), "inverse bind matrices"))
        put(self, "joints", indices(self.joints, self.weights.shape, len(self.inverse_bind), "skin joints"))

    def blend(self, world: Floats) -> Floats:
        """Blend joint matrices `(…, J, 4, 4)` into one per vertex `(…, N, 4, 4)`."""
        local = world @ self.inverse_bind
        return np.asarray(np.einsum("...niab,ni->...nab", local[..., self.joints, :, :], self.weights))


@dataclass(frozen=True, eq=False)
class Rig:
    """A face and its controls.

    The neutral and the deltas are in world space at rest, whatever nodes and bind
    matrices the file had.

    Attributes:
        neutral: the mesh at rest.
        blendshapes: the shapes; may be none.
        skeleton, skin: given together, or neither.
        anatomy: muscles, deformers, attributes and templates, if it has them.
        landmarks: named points on the neutral.
        name: how reports call it.
        source: the file it was read from, which writers use to keep what mien does not understand.
        notes: what was repaired on reading.
        colours: linear red, green and blue of vertex groups, later ones over earlier; what has none is not said.
        correctives: which shapes follow from others; None if all are free.
    """

    neutral: Mesh
    blendshapes: Blendshapes
    skeleton: Skeleton | None = None
    skin: Skin | None = None
    anatomy: Anatomy | None = None
    landmarks: Mapping[str, SurfacePoints] = field(default_factory=dict)
    name: str = "character"
    source: Path | None = None
    notes: tuple[Note, ...] = ()
    colours: Mapping[str, Colour] = field(default_factory=dict)
    correctives: Correctives | None = None

    def __post_init__(self) -> None:
        n = len(self.neutral.vertices)
        if self.blendshapes.deltas.shape[1] != n:
            raise InputError(
                f"the blendshapes of {self.name!r} have {self.blendshapes.deltas.shape[1]} vertices, its neutral {n}."
            )
        if (self.skeleton is None) != (self.skin is None):
            raise InputError(f"{self.name!r} needs both a skeleton and a skin, or neither.")
        if self.skin is not None and len(self.skin.weights) != n:
            raise InputError(f"the skin of {self.name!r} covers {len(self.skin.weights)} of {n} vertices.")
        for part in () if self.anatomy is None else self.anatomy.parts:
            if len(part.weights) != n:
                raise InputError(f"{part.name!r} of {self.name!r} covers {len(part.weights)} of {n} vertices.")
        if self.correctives is not None and self.correctives.last >= len(self.blendshapes):
            raise InputError(
                f"the correctives of {self.name!r} name shape {self.correctives.last}, but it has {len(self.blendshapes)}."
            )
        for group, colour in self.colours.items():
            if group not in self.neutral.groups:
                raise InputError(unknown("vertex group", group, self.neutral.groups))
            shade = floats(colour, (3,), f"the colour of {group!r}")
            if shade.min() < 0 or shade.max() > 1:
                raise InputError(f"the colour of {group!r} must lie between 0 and 1, but is {shade.tolist()}.")

    def pose(self, weights: Floats, joints: Floats | None = None) -> Floats:
        """Return the vertices of one or many poses (Ribera et al. 2017, eq. 1).

        Args:
            weights: `(…, K)` blendshape weights; those of correctives follow from their drivers.
            joints: `(…, J, 4, 4)` world matrices of the joints; at rest if None.

        Returns:
            `(…, N, 3)` positions [m].
        """
        w = np.asarray(weights, dtype=np.float64)
        if self.correctives is not None:
            w = self.correctives.complete(w)
        flat = self.blendshapes.deltas.reshape(len(self.blendshapes), 3 * len(self.neutral.vertices))
        moved = (w @ flat).reshape(*w.shape[:-1], -1, 3)
        moved += self.neutral.vertices
        if joints is None or self.skin is None or self.skeleton is None:
            return moved
        move = self.skin.blend(joints) @ self._from_rest
        return np.asarray(np.einsum("...nab,...nb->...na", move[..., :3, :3], moved) + move[..., :3, 3])

    @cached_property
    def _from_rest(self) -> Floats:
        """`(N, 4, 4)` from the world at rest to each vertex's own space, the same for every pose."""
        assert self.skin is not None
        assert self.skeleton is not None
        return np.asarray(np.linalg.inv(self.skin.blend(self.skeleton.rest)))

    def only(self, vertices: Ints) -> Rig:
        """Return the rig of a few vertices, without triangles: all that tracing points needs."""
        ids = np.asarray(vertices, dtype=np.int64)
        skin = self.skin
        if skin is not None:
            skin = Skin(skin.joints[ids], skin.weights[ids], skin.inverse_bind)
        return replace(
            self,
            neutral=Mesh(self.neutral.vertices[ids], np.empty((0, 3), np.int64)),
            blendshapes=Blendshapes(self.blendshapes.names, self.blendshapes.deltas[:, ids]),
            skin=skin,
            anatomy=None,
            landmarks={},
            colours={},
        )


def no_blendshapes(vertex_count: int) -> Blendshapes:
    """Return an empty set for a mesh of `vertex_count` vertices."""
    return Blendshapes((), np.zeros((0, vertex_count, 3)))
