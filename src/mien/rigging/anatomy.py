"""Muscles, deformers, attributes and labels on another face (Orvalho et al., §4.4 and §4.5).

What a muscle does is told in the terms of the face it lies in.  The skin that follows it
may have grown more or less than its fibre, and an expression is judged by the skin: a
smile is wide for its mouth.  So a muscle pulls as far as the skin that follows it grew,
or the skin around its moving end if that grew more.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Anatomy, Cluster, Muscle, Rig, Skeleton
from mien.core.arrays import Floats
from mien.geometry.muscles import fibre_length
from mien.rigging.attributes import Carrier
from mien.rigging.lids import Lids
from mien.rigging.structure import Structure

AT_JOINT = 1e-3
"""A ball turns with a joint if its centre is this close to it, as a share of a frame's surroundings."""
SHORTEST = 0.42
"""A muscle that grew less than its skin shortens by at most this share, or by the rig's own if that is more."""


def carried_anatomy(generic: Rig, structure: Structure, skeleton: Skeleton | None, carrier: Carrier) -> Anatomy | None:
    """Return a rig's anatomy on another face; None if it has none.

    Args:
        generic: the rig.
        structure: the warp of what lies under its skin.
        skeleton: the rig's, on the face.
        carrier: takes values of the rig's vertices to the face's.
    """
    own = generic.anatomy
    if own is None:
        return None
    return replace(
        own,
        muscles=tuple(_muscle(muscle, generic, structure, skeleton, carrier) for muscle in own.muscles),
        clusters=tuple(_cluster(cluster, structure, carrier) for cluster in own.clusters),
        flexors=tuple(replace(flexor, weights=carrier.shares(flexor.weights)) for flexor in own.flexors),
        fields={name: carrier.values(values) for name, values in own.fields.items()},
        labels={name: carrier.labels(labels) for name, labels in own.labels.items()},
    )


def _muscle(muscle: Muscle, generic: Rig, structure: Structure, skeleton: Skeleton | None, carrier: Carrier) -> Muscle:
    fibre, growth = structure.line(muscle.fibre), structure.growth(muscle.weights)
    pulled = max(growth, structure.around(muscle.fibre[-1])[1])
    wanted = muscle.shortening * pulled * fibre_length(muscle.fibre) / max(fibre_length(fibre), 1e-300)
    moved = replace(
        muscle,
        fibre=fibre,
        weights=carrier.pulls(muscle.weights),
        frame=structure.frame(muscle.frame),
        scale=muscle.scale * growth,
        shortening=min(wanted, max(SHORTEST, muscle.shortening)),
        seam=None if muscle.seam is None else structure.line(muscle.seam),
        pivot=None if muscle.pivot is None else _pivot(muscle.pivot, generic, structure, skeleton),
    )
    return moved if moved.pivot is None else _lid(moved, muscle, generic, structure, carrier)


def _lid(moved: Muscle, muscle: Muscle, generic: Rig, structure: Structure, carrier: Carrier) -> Muscle:
    """Let a muscle that closes a lid close the face's own."""
    assert generic.anatomy is not None
    assert moved.pivot is not None
    fit = carrier.fit
    lids = Lids.of(muscle, generic.anatomy.muscles, fit, structure, carrier.parts, moved.pivot)
    if lids is None:
        return moved
    skin, weights, other = np.flatnonzero(fit.target_skin), np.array(moved.weights), carrier.pulls(lids.partner.weights)
    weights[skin] = lids.weights(fit.target.vertices[skin], weights[skin], other[skin], carrier.unsure[skin])
    return replace(moved, seam=lids.seam, weights=weights)


def _cluster(cluster: Cluster, structure: Structure, carrier: Carrier) -> Cluster:
    return replace(
        cluster,
        weights=carrier.pulls(cluster.weights),
        frame=structure.frame(cluster.frame),
        scale=cluster.scale * structure.growth(cluster.weights),
    )


def _pivot(pivot: Floats, generic: Rig, structure: Structure, skeleton: Skeleton | None) -> Floats:
    """Carry the centre of a ball: with the joint that sits there, if one does."""
    if generic.skeleton is not None and skeleton is not None:
        apart = np.linalg.norm(generic.skeleton.rest[:, :3, 3] - pivot, axis=1)
        joint = int(np.argmin(apart))
        if apart[joint] <= AT_JOINT * structure.reach:
            return np.asarray(skeleton.rest[joint, :3, 3])
    return np.asarray(structure.warp(pivot[None])[0])
