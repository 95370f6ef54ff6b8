"""A rig played by its bones and muscles (Orvalho, Zacur, Susin, §4.6 and §5).

Controls are numbers by name.  Muscles and clusters displace the skin at rest, all from
the same neutral, so their order does not matter; the joints then carry the result, so
that every expression rides with the jaw and the head.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mien.core import InputError, Rig
from mien.core.anatomy import AXES, Anatomy, Cluster, Controls, Flexor, Muscle
from mien.core.arrays import Floats, Ints
from mien.core.errors import unknown
from mien.geometry.muscles import across, beside, drawn, pull


def controls_of(rig: Rig) -> tuple[str, ...]:
    """Return the names of all controls: contractions, strengths, and six per influence."""
    anatomy = rig.anatomy or Anatomy()
    own = [*(muscle.name for muscle in anatomy.muscles), *(flexor.name for flexor in anatomy.flexors)]
    joints = rig.skeleton.names if rig.skeleton is not None else ()
    moved = [*(part.name for part in _influences(rig)), *joints]
    return (*own, *(f"{name}.{axis}" for name in moved for axis in AXES))


@dataclass(frozen=True, eq=False)
class _Pull:
    """What one muscle does to the vertices that follow it; `reach` is their displacement or place at contraction 1."""

    muscle: Muscle
    vertices: Ints
    weights: Floats
    reach: Floats

    @classmethod
    def of(cls, muscle: Muscle, points: Floats) -> _Pull:
        ids = np.flatnonzero(muscle.weights)
        near = points[ids]
        if muscle.seam is None:
            reach = pull(muscle, near)
        else:
            reach = (beside if muscle.pivot is None else across)(muscle.seam, near)
        return cls(muscle, ids, muscle.weights[ids], reach)

    def displacement(self, points: Floats, contraction: float) -> Floats:
        share = contraction * self.weights
        if self.muscle.seam is None:
            return np.asarray(share[:, None] * self.reach)
        return drawn(points[self.vertices], self.reach, share, self.muscle.pivot)


@dataclass(frozen=True, eq=False)
class Puppet:
    """A rig made ready to be posed many times: what the muscles reach for, worked out once.

    Attributes:
        rig: who is posed.
        names: `C` names of its controls.
        joint_scale: the length here of one metre of the face the templates were authored on, by joint.
    """

    rig: Rig
    names: tuple[str, ...]
    joint_scale: Mapping[str, float]
    _pulls: tuple[_Pull, ...]

    @classmethod
    def of(cls, rig: Rig, joint_scale: Mapping[str, float] | None = None) -> Puppet:
        """Make a rig ready; joints take their scale from the muscles around them unless told."""
        muscles = rig.anatomy.muscles if rig.anatomy is not None else ()
        pulls = tuple(_Pull.of(muscle, rig.neutral.vertices) for muscle in muscles)
        return cls(rig, controls_of(rig), joint_scales(rig) | dict(joint_scale or {}), pulls)

    def posed(self, controls: Controls) -> Floats:
        """Return the `(N, 3)` vertices [m] under these controls.

        Raises:
            InputError: an unknown control, or a value that is not finite.
        """
        played = self._checked(controls)
        points = self.rig.neutral.vertices
        moved = points.copy()
        for part in self._pulls:
            if contraction := played.get(part.muscle.name, 0.0):
                moved[part.vertices] += part.displacement(points, contraction)
        for influence in _influences(self.rig):
            if motion := _motion(played, influence.name):
                moved += _carried(influence, motion, points)
        return self._skinned(moved, played)

    def joint_matrices(self, controls: Controls) -> Floats:
        """Return the `(J, 4, 4)` world matrices of the joints under these controls.

        Raises:
            InputError: an unknown control, or a value that is not finite.
        """
        moves, skeleton = self._joint_moves(self._checked(controls)), self.rig.skeleton
        return moves if skeleton is None else np.asarray(moves @ skeleton.rest)

    def _joint_moves(self, played: Controls) -> Floats:
        """Return the `(J, 4, 4)` motion of each joint from its rest, exactly the identity where nothing moves it."""
        skeleton = self.rig.skeleton
        if skeleton is None:
            return np.zeros((0, 4, 4))
        moves = np.tile(np.eye(4), (len(skeleton.names), 1, 1))
        for j in _parents_first(skeleton.parents):
            name, parent = skeleton.names[j], skeleton.parents[j]
            if motion := _motion(played, name):
                moves[j] = _in_frame(skeleton.rest[j], _transform(motion, self.joint_scale.get(name, 1.0)))
            if parent >= 0:
                moves[j] = moves[parent] @ moves[j]
        return moves

    def _skinned(self, points: Floats, played: Controls) -> Floats:
        rig = self.rig
        if rig.skin is None or rig.skeleton is None:
            return points
        moves = self._joint_moves(played)
        change = np.einsum("niab,ni->nab", (moves - np.eye(4))[rig.skin.joints], rig.skin.weights)
        for flexor in rig.anatomy.flexors if rig.anatomy is not None else ():
            if strength := played.get(flexor.name, 0.0):
                change += _loosened(rig, flexor, strength, moves)
        return np.asarray(points + np.einsum("nab,nb->na", change[:, :3, :3], points) + change[:, :3, 3])

    def _checked(self, controls: Controls) -> Controls:
        known = set(self.names)
        for name, value in controls.items():
            if name not in known:
                raise InputError(unknown(f"control of {self.rig.name!r}", name, self.names))
            if not np.isfinite(value):
                raise InputError(f"control {name!r} of {self.rig.name!r} is {value}; a finite number is needed.")
        return controls


def posed(rig: Rig, controls: Controls, joint_scale: Mapping[str, float] | None = None) -> Floats:
    """Return a rig's `(N, 3)` vertices [m] under some controls; for many poses, make one `Puppet`.

    Args:
        rig: with an anatomy, a skeleton, or both; its blendshapes stay at 0.
        controls: values by name, contractions as shares, translations in metres of the
            face they were authored on, rotations in radians.
        joint_scale: by joint, the length here of one such metre; see `joint_scales`.

    Raises:
        InputError: an unknown control, or a value that is not finite.
    """
    return Puppet.of(rig, joint_scale).posed(controls)


def joint_matrices(rig: Rig, controls: Controls, joint_scale: Mapping[str, float] | None = None) -> Floats:
    """Return the `(J, 4, 4)` world matrices [m] of a rig's joints under some controls.

    Raises:
        InputError: an unknown control, or a value that is not finite.
    """
    return Puppet.of(rig, joint_scale).joint_matrices(controls)


def joint_scales(rig: Rig) -> dict[str, float]:
    """Return the length here of one metre of the face the templates were authored on, by joint.

    Muscles and clusters know theirs.  A joint takes the mean of those that share skin
    with it, by how much they share; one that shares none takes the median of all.
    """
    parts = _influences(rig)
    if rig.skeleton is None or rig.skin is None or not parts:
        return {}
    shared = np.zeros((len(rig.skeleton.names), len(parts)))
    for column, part in enumerate(parts):
        np.add.at(shared[:, column], rig.skin.joints, rig.skin.weights * part.weights[:, None])
    scales = np.array([part.scale for part in parts])
    total = shared.sum(axis=1)
    mean = np.where(total > 0, shared @ scales / np.maximum(total, 1e-300), np.median(scales))
    return dict(zip(rig.skeleton.names, mean.tolist(), strict=True))


def _influences(rig: Rig) -> tuple[Muscle | Cluster, ...]:
    """Return everything within the skin that can be moved and turned."""
    anatomy = rig.anatomy or Anatomy()
    found: list[Muscle | Cluster] = [*anatomy.muscles, *anatomy.clusters]
    return tuple(found)


def _motion(played: Controls, name: str) -> dict[str, float]:
    """Return how an influence is moved, by axis; empty if it is not."""
    values = {axis: played.get(f"{name}.{axis}", 0.0) for axis in AXES}
    return values if any(values.values()) else {}


def _transform(motion: Mapping[str, float], scale: float) -> Floats:
    """Return the `(4, 4)` motion in an influence's own frame: about z, y, then x, and along."""
    matrix = np.eye(4)
    if motion:
        (cx, sx), (cy, sy), (cz, sz) = ((np.cos(motion[a]), np.sin(motion[a])) for a in AXES[3:])
        about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
        about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
        matrix[:3, :3] = about_x @ about_y @ about_z
        matrix[:3, 3] = scale * np.array([motion[a] for a in AXES[:3]])
    return matrix


def _in_frame(frame: Floats, motion: Floats) -> Floats:
    """Return a motion within a frame as a motion of the world."""
    return np.asarray(frame @ motion @ np.linalg.inv(frame))


def _parents_first(parents: Ints) -> list[int]:
    """Return the joints in an order in which each comes after its parent."""
    order: list[int] = []
    waiting = list(range(len(parents)))
    while waiting:
        ready = [j for j in waiting if parents[j] < 0 or parents[j] in order]
        if not ready:
            raise InputError(f"joints {waiting} are each other's parents; a skeleton must be a tree.")
        order += ready
        waiting = [j for j in waiting if j not in ready]
    return order


def _carried(part: Muscle | Cluster, motion: Mapping[str, float], points: Floats) -> Floats:
    """Return the displacement of the skin by a muscle or cluster that is moved and turned as a whole."""
    whole = _in_frame(part.frame, _transform(motion, part.scale))
    return np.asarray(part.weights[:, None] * (points @ (whole[:3, :3] - np.eye(3)).T + whole[:3, 3]))


def _loosened(rig: Rig, flexor: Flexor, strength: float, moves: Floats) -> Floats:
    """Return the change of each vertex's `(4, 4)` motion when it lets go of a joint for the joint's parent."""
    assert rig.skin is not None
    assert rig.skeleton is not None
    if flexor.joint not in rig.skeleton.names:
        raise InputError(unknown(f"joint of flexor {flexor.name!r}", flexor.joint, rig.skeleton.names))
    joint = rig.skeleton.names.index(flexor.joint)
    parent = rig.skeleton.parents[joint]
    above = moves[parent] if parent >= 0 else np.eye(4)
    held = (rig.skin.weights * (rig.skin.joints == joint)).sum(axis=1)
    return np.asarray((strength * held * flexor.weights)[:, None, None] * (above - moves[joint]))
