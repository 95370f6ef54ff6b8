"""Joints posed by a few numbers, and the skin they carry: positions and exact derivatives.

A parameter is a named pose, or one turn or displacement of one joint.  Each adds its share
to the rotation vector and to the displacement of every joint it poses, so that half a pose
is half of every turn, parameters add up in any order, and the posed skin is a smooth
function of them, whose derivatives are worked out here (linear blend skinning;
Magnenat-Thalmann, Laperrière, Thalmann 1988).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from mien.core import InputError, Rig, Skeleton, SurfacePoints
from mien.core.arrays import Floats, Ints, distinct, floats, matching
from mien.geometry.bones_kernels import derivatives, motions

LEAST_TURN, LEAST_MOVE = 1e-4, 1e-5
"""A joint that turns [rad] and moves [m] less than this in every pose is not posed: files are rounded."""


@dataclass(frozen=True, eq=False)
class Bones:
    """Parameters of a skeleton.

    Attributes:
        names: `K` parameters.
        skeleton: the joints.
        turns: `(K, J, 3)` rotation vector [rad] that each parameter at 1 gives each joint, relative
            to the joint's parent, along the axes of the world at rest.
        moves: `(K, J, 3)` displacement [m], likewise.
        two_sided: whether parameters go to -1 as well.
    """

    names: tuple[str, ...]
    skeleton: Skeleton
    turns: Floats
    moves: Floats
    two_sided: bool = False

    def __post_init__(self) -> None:
        put, shape = object.__setattr__, (len(self.names), len(self.skeleton.names), 3)
        put(self, "names", distinct(self.names, "parameters of bones"))
        put(self, "turns", floats(self.turns, shape, "turns of bones"))
        put(self, "moves", floats(self.moves, shape, "moves of bones"))

    @classmethod
    def of_poses(cls, skeleton: Skeleton, poses: Mapping[str, Floats]) -> Bones:
        """Return one parameter per named pose, `(J, 4, 4)` world matrices; at 1 it is the pose.

        Raises:
            InputError: the joints do not form a tree, or a joint is scaled to nothing.
        """
        places, parents = skeleton.rest[:, :3, 3], skeleton.parents
        shape = (len(poses), len(skeleton.names), 3)
        motions = np.array([*poses.values()]).reshape(*shape[:2], 4, 4) @ _inverse_of(skeleton.rest, skeleton)
        above = np.where((parents >= 0)[:, None, None], motions[:, np.maximum(parents, 0)], np.eye(4))
        own = np.linalg.solve(above, motions)
        turns = Rotation.from_matrix(own[..., :3, :3].reshape(-1, 3, 3)).as_rotvec().reshape(shape)
        moves = np.einsum("kjab,jb->kja", own[..., :3, :3], places) + own[..., :3, 3] - places
        turns[:, (np.linalg.norm(turns, axis=2) < LEAST_TURN).all(axis=0)] = 0
        moves[:, (np.linalg.norm(moves, axis=2) < LEAST_MOVE).all(axis=0)] = 0
        return cls(tuple(poses), skeleton, turns, moves)

    def on(self, skeleton: Skeleton) -> Bones:
        """Return the same parameters of another skeleton, whose joints are known by their names.

        Displacements grow with the distances between the joints.

        Raises:
            InputError: a joint that is posed is missing there.
        """
        own = np.flatnonzero(self.turns.any(axis=(0, 2)) | self.moves.any(axis=(0, 2)))
        there = matching(skeleton.names, [self.skeleton.names[j] for j in own])
        if (there < 0).any():
            lost = [self.skeleton.names[j] for j in own[there < 0]]
            raise InputError(
                f"the poses move {len(own)} joints, but the character lacks {len(lost)} of them ({', '.join(lost[:5])}); "
                "give poses of a skeleton whose joints have the same names."
            )
        turns, moves = np.zeros((2, len(self.names), len(skeleton.names), 3))
        turns[:, there] = self.turns[:, own]
        spans = [np.ptp(rest[:, :3, 3], axis=0).max() for rest in (self.skeleton.rest[own], skeleton.rest[there])]
        moves[:, there] = self.moves[:, own] * (spans[1] / spans[0] if min(spans) > 0 else 1.0)
        return replace(self, skeleton=skeleton, turns=turns, moves=moves)

    @cached_property
    def moved(self) -> Ints:
        """`B` joints that a parameter turns or moves, and all that hang below them, parents first.

        Raises:
            InputError: the joints do not form a tree.
        """
        own = np.asarray(self.turns.any(axis=(0, 2)) | self.moves.any(axis=(0, 2)))
        order = parents_first(self.skeleton.parents)
        for j in order:
            parent = self.skeleton.parents[j]
            own[j] |= parent >= 0 and own[parent]
        return np.array([j for j in order if own[j]], dtype=np.int64)

    @cached_property
    def above(self) -> Ints:
        """`(B,)` row of each moved joint's parent among them, -1 where it stays at rest."""
        row = {int(j): b for b, j in enumerate(self.moved)}
        return np.array([row.get(int(self.skeleton.parents[j]), -1) for j in self.moved], dtype=np.int64)

    def world(self, weights: Floats) -> Floats:
        """Return the joints' world matrices `(…, J, 4, 4)` under parameters `(…, K)`."""
        found, _ = self.motions(weights)
        rest = self.skeleton.rest
        world = np.array(np.broadcast_to(rest, (*found.shape[:-3], *rest.shape)))
        world[..., self.moved, :3, :] = found @ rest[self.moved]
        return world

    def motions(self, weights: Floats) -> tuple[Floats, Floats]:
        """Return how the moved joints are moved from rest, and how their turns change with the parameters.

        Args:
            weights: `(…, K)` parameters.

        Returns:
            `(…, B, 3, 4)` rigid motions in the world, and `(…, B, 3, 3)` what takes a change of a joint's
            rotation vector to the turn it makes (the left Jacobian of the rotation group).
        """
        w = np.asarray(weights, dtype=np.float64)
        flat = w.reshape(-1, len(self.names))
        turns = (flat @ self.turn_rows).reshape(len(flat), -1, 3)
        moves = (flat @ self.move_rows).reshape(len(flat), -1, 3)
        found, changes = motions(turns, moves, self.places, self.above)
        return found.reshape(*w.shape[:-1], -1, 3, 4), changes.reshape(*w.shape[:-1], -1, 3, 3)

    @cached_property
    def places(self) -> Floats:
        """`(B, 3)` where the moved joints are at rest [m]."""
        return self.skeleton.rest[self.moved, :3, 3]

    @cached_property
    def turn_rows(self) -> Floats:
        """`(K, 3 B)` the turns of the moved joints alone."""
        return self.turns[:, self.moved].reshape(len(self.names), -1)

    @cached_property
    def move_rows(self) -> Floats:
        """`(K, 3 B)` the displacements of the moved joints alone."""
        return self.moves[:, self.moved].reshape(len(self.names), -1)

    @cached_property
    def rows(self) -> csr_array:
        """`(K, 6 B)` turns and displacements of the moved joints: most parameters pose few of them."""
        return csr_array(np.concatenate([self.turn_rows, self.move_rows], axis=1))


@dataclass(frozen=True, eq=False)
class CarriedPoints:
    """Points of a skin, and how the joints of some bones carry them.

    Attributes:
        bones: what poses the joints.
        shares: `(B, M, 4)` each point's place [m] and 1 at rest, times the weight there of each moved joint.
        still: `(M, 3)` the same of all other joints.
    """

    bones: Bones
    shares: Floats
    still: Floats

    @classmethod
    def of(cls, rig: Rig, points: SurfacePoints, bones: Bones) -> CarriedPoints:
        """Bind points of a rig's neutral to its joints.

        Raises:
            InputError: the rig has no skin.
        """
        if rig.skin is None or rig.skeleton is None:
            raise InputError(f"{rig.name!r} has no skin, so no joint can carry its points.")
        used, corners = np.unique(points.corners, return_inverse=True)
        skin, vertices = rig.only(used).skin, rig.neutral.vertices[used]
        assert skin is not None
        at_rest = np.concatenate([vertices, np.ones((len(used), 1))], axis=1)
        own = np.linalg.solve(skin.blend(rig.skeleton.rest), at_rest[..., None])[..., 0]
        to_rest = rig.skeleton.rest @ rig.skin.inverse_bind
        carried = np.einsum("niab,nb,ni->nia", to_rest[skin.joints], own, skin.weights)
        per_joint = np.zeros((len(rig.skeleton.names), len(used), 4))
        np.add.at(per_joint, (skin.joints, np.arange(len(used))[:, None]), carried)
        shares = np.einsum("jmca,mc->jma", per_joint[:, corners.reshape(points.corners.shape)], points.weights)
        moved = np.isin(np.arange(len(shares)), bones.moved)
        return cls(bones, shares[bones.moved], shares[~moved, :, :3].sum(axis=0))

    @cached_property
    def rest(self) -> Floats:
        """`(M, 3)` the points with every parameter at 0 [m]."""
        return self.at(np.zeros(len(self.bones.names)))

    @cached_property
    def chords(self) -> Floats:
        """`(K, M, 3)` how far each parameter at 1 carries the points [m]; of two-sided ones half the way from -1."""
        one = np.eye(len(self.bones.names))
        return (self.at(one) - self.at(-one)) / 2 if self.bones.two_sided else self.at(one) - self.rest

    def at(self, weights: Floats) -> Floats:
        """Return the points `(…, M, 3)` [m] under parameters `(…, K)`."""
        found, _ = self.bones.motions(weights)
        rows = found.swapaxes(-3, -2).reshape(*found.shape[:-3], 3, -1)
        return np.asarray(self.still + (rows @ self._columns).swapaxes(-1, -2))

    @cached_property
    def _columns(self) -> Floats:
        """`(4 B, M)` shares, as `at` multiplies them."""
        return np.ascontiguousarray(self.shares.swapaxes(1, 2)).reshape(-1, len(self.still))

    def around(self, weights: Floats) -> tuple[Floats, Floats]:
        """Return the points `(M, 3)` [m] under parameters `(K,)`, and their derivatives `(K, M, 3)`."""
        bones, size = self.bones, self.still.size
        found, change = bones.motions(weights)
        points, slopes = derivatives(found, change, bones.places, bones.above, self.shares)
        slope = bones.rows @ slopes.reshape(-1, size)
        return self.still + points, np.asarray(slope).reshape(-1, *self.still.shape)


def parents_first(parents: Ints) -> list[int]:
    """Return the joints in an order in which each comes after its parent.

    Raises:
        InputError: joints are each other's parents.
    """
    children: dict[int, list[int]] = {}
    for j, parent in enumerate(parents.tolist()):
        children.setdefault(parent, []).append(j)
    order: list[int] = []
    waiting = children.get(-1, [])[::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += children.get(order[-1], [])[::-1]
    if len(order) < len(parents):
        raise InputError(f"of {len(parents)} joints, {len(parents) - len(order)} hang on each other, not on a root.")
    return order


def _inverse_of(rest: Floats, skeleton: Skeleton) -> Floats:
    linear = rest[:, :3, :3]
    flat = np.abs(np.linalg.det(linear)) <= 1e-12 * np.linalg.norm(linear, axis=(1, 2)) ** 3
    if flat.any():
        raise InputError(f"the joint {skeleton.names[int(np.argmax(flat))]!r} has no extent (scale 0); it cannot pose.")
    return np.asarray(np.linalg.inv(rest))
