"""Bones as shapes: what every method needs to drive a face that has joints and no blendshapes.

A character's parameters are then named poses of its bones or, where nobody made such
poses, the turns and moves of the single bones.  Each is one blendshape: the skin in that
pose.  Methods find weights of these as of any others; what the weights do to the joints is
`geometry.bones`, and `bone_solver` solves for that instead of the straight lines between.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Blendshapes, Correspondence, InputError, Rig, Skeleton, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.core.rig import no_blendshapes
from mien.core.units import human_centimetre
from mien.geometry.bones import Bones, parents_first

WHOLE = 0.9
"""A joint that carries this share of the paired points is the head or what holds it, and no part of the face."""
LEAST = 0.1
"""A joint that holds no paired point by more than this has nothing to tell it what to do."""
FARTHEST_TURN, FARTHEST_CM = 0.7, 4.0
"""A free bone at 1 is turned so far [rad], or so that it carries a paired point so far, whichever is less."""
SHORT_CM = 2.0
"""A bone whose points are this near to where it turns moves them by moving itself."""
FARTHEST_MOVE_CM = 2.0


def free_bones(rig: Rig, pairs: Correspondence) -> Bones:
    """Return parameters that are the turns, and of short bones the moves, of each bone that carries paired points.

    A bone turns about the axes of its own frame.  At 1 it goes as far as a face may ask of
    it, at -1 as far the other way.

    Args:
        rig: the character.
        pairs: its paired points, spread over the face.

    Raises:
        InputError: the rig has no bones, or only one carries the whole face.
    """
    skeleton = _skeleton(rig)
    held = held_by(rig, pairs.target)
    joints = np.flatnonzero((held.max(axis=1, initial=0) > LEAST) & (held.mean(axis=1) < WHOLE))
    if not len(joints):
        raise InputError(
            f"no joint of {rig.name} moves a part of the face on its own: all paired points follow the same joints. "
            "Give a character with facial bones or with blendshapes."
        )
    points = pairs.target.of(rig.neutral.vertices)
    centimetre = human_centimetre(points)
    found = [row for j in joints.tolist() for row in _degrees_of_freedom(skeleton, j, points, held[j], centimetre)]
    turns, moves = np.zeros((2, len(found), len(skeleton.names), 3))
    for k, (_, joint, turn, move) in enumerate(found):
        turns[k, joint], moves[k, joint] = turn, move
    return Bones(tuple(name for name, *_ in found), skeleton, turns, moves, two_sided=True)


def _degrees_of_freedom(
    skeleton: Skeleton, joint: int, points: Floats, held: Floats, centimetre: float
) -> list[tuple[str, int, Floats, Floats]]:
    """Return names, joint, turn and move of a free bone's parameters, given how it holds `(M,)` points `(M, 3)`."""
    rest, name = skeleton.rest[joint], skeleton.names[joint]
    axes = (rest[:3, :3] / np.maximum(np.linalg.norm(rest[:3, :3], axis=0), 1e-12)).T
    arms = np.linalg.norm(points - rest[:3, 3], axis=1)
    reach = min(FARTHEST_TURN, FARTHEST_CM * centimetre / max(float((arms * held).max()), 1e-12))
    found = [(f"{name}.turn_{a}", joint, reach * axis, np.zeros(3)) for a, axis in zip("xyz", axes, strict=True)]
    if np.average(arms, weights=held) < SHORT_CM * centimetre:
        far = FARTHEST_MOVE_CM * centimetre
        found += [(f"{name}.move_{a}", joint, np.zeros(3), far * axis) for a, axis in zip("xyz", axes, strict=True)]
    return found


def with_bone_shapes(rig: Rig, bones: Bones) -> Rig:
    """Return the rig with one blendshape per parameter in place of those it has.

    A shape is where the parameter at 1 carries the skin; of two-sided ones half the way from -1.
    """
    bare = replace(rig, blendshapes=no_blendshapes(len(rig.neutral.vertices)), correctives=None)
    deltas = np.zeros((len(bones.names), len(rig.neutral.vertices), 3))
    for k, pose in enumerate(np.eye(len(bones.names))):
        here = _displaced(bare, bones, pose)
        deltas[k] = (here - _displaced(bare, bones, -pose)) / 2 if bones.two_sided else here
    return replace(bare, blendshapes=Blendshapes(bones.names, deltas))


def held_by(rig: Rig, points: SurfacePoints) -> Floats:
    """Return `(J, M)` how much of each point hangs on each joint and those below it, 0 to 1."""
    skeleton, skin = _skeleton(rig), rig.skin
    assert skin is not None
    per_point = np.zeros((len(skeleton.names), len(points)))
    rows = np.arange(len(points))[:, None, None]
    shares = skin.weights[points.corners] * points.weights[..., None]
    np.add.at(per_point, (skin.joints[points.corners], np.broadcast_to(rows, shares.shape)), shares)
    for j in reversed(parents_first(skeleton.parents)):
        if skeleton.parents[j] >= 0:
            per_point[skeleton.parents[j]] += per_point[j]
    return per_point


def _displaced(bare: Rig, bones: Bones, pose: Floats) -> Floats:
    """Return how far parameters `(K,)` carry each vertex, `(N, 3)` [m]."""
    assert bare.skin is not None
    found, _ = bones.motions(pose)
    carrying = np.zeros(len(bones.skeleton.names), dtype=bool)
    carrying[bones.moved] = (np.abs(found - np.eye(3, 4)) > 1e-12).any(axis=(1, 2))
    ids: Ints = np.flatnonzero((carrying[bare.skin.joints] & (bare.skin.weights > 0)).any(axis=1))
    displaced = np.zeros_like(bare.neutral.vertices)
    displaced[ids] = bare.only(ids).pose(np.zeros(0), bones.world(pose)) - bare.neutral.vertices[ids]
    return displaced


def _skeleton(rig: Rig) -> Skeleton:
    if rig.skeleton is None:
        raise InputError(f"{rig.name} has no bones (no skin with joints); export it with its skin.")
    return rig.skeleton
