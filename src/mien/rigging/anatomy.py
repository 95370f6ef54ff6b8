"""Muscles, deformers, attributes and labels on another face (Orvalho et al., §4.4 and §4.5).

What a muscle does is told in the terms of the face it lies in.  The skin that follows it
may have grown more or less than its fibre, and an expression is judged by the skin: a
smile is wide for its mouth.  So a muscle pulls as far as the skin that follows it grew,
or the skin around its moving end if that grew more; but never farther than that skin
can bear without being turned over.
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
    weights = [muscle.weights for muscle in own.muscles] + [cluster.weights for cluster in own.clusters]
    pulls = carrier.pulls(np.array(weights).reshape(len(weights), -1))
    muscles = own.muscles and _muscles(generic, pulls[: len(own.muscles)], structure, skeleton, carrier)
    return replace(
        own,
        muscles=muscles,
        clusters=own.clusters and _clusters(own.clusters, pulls[len(own.muscles) :], structure),
        flexors=tuple(replace(flexor, weights=carrier.shares(flexor.weights)) for flexor in own.flexors),
        fields={name: carrier.values(values) for name, values in own.fields.items()},
        labels={name: carrier.labels(labels) for name, labels in own.labels.items()},
    )


def _muscles(
    generic: Rig, pulls: Floats, structure: Structure, skeleton: Skeleton | None, carrier: Carrier
) -> tuple[Muscle, ...]:
    """Carry the muscles, whose skin follows them by `pulls` `(M, N)` on the face."""
    assert generic.anatomy is not None
    muscles = generic.anatomy.muscles
    weights = np.stack([muscle.weights for muscle in muscles])
    growth = structure.growth(weights)
    pulled = np.maximum(growth, structure.around(np.stack([muscle.fibre[-1] for muscle in muscles]))[1])
    pulled = np.minimum(pulled, structure.bearable(weights))
    fibres, frames = structure.lines([m.fibre for m in muscles]), structure.frame(np.stack([m.frame for m in muscles]))
    seams = iter(structure.lines([muscle.seam for muscle in muscles if muscle.seam is not None]))
    result = []
    for row, muscle in enumerate(muscles):
        longer = fibre_length(muscle.fibre) / max(fibre_length(fibres[row]), 1e-300)
        moved = replace(
            muscle,
            fibre=fibres[row],
            weights=pulls[row],
            frame=frames[row],
            scale=muscle.scale * growth[row],
            shortening=min(muscle.shortening * pulled[row] * longer, max(SHORTEST, muscle.shortening)),
            seam=None if muscle.seam is None else next(seams),
            pivot=None if muscle.pivot is None else _pivot(muscle.pivot, generic, structure, skeleton),
        )
        result.append(moved if moved.pivot is None else _lid(moved, muscle, generic, pulls, structure, carrier))
    return tuple(result)


def _lid(moved: Muscle, muscle: Muscle, generic: Rig, pulls: Floats, structure: Structure, carrier: Carrier) -> Muscle:
    """Let a muscle that closes a lid close the face's own."""
    assert generic.anatomy is not None
    assert moved.pivot is not None
    fit, muscles = carrier.fit, generic.anatomy.muscles
    lids = Lids.of(muscle, muscles, fit, structure, carrier.parts, moved.pivot)
    if lids is None:
        return moved
    partner = next(row for row, one in enumerate(muscles) if one is lids.partner)
    skin, weights, other = np.flatnonzero(fit.target_skin), np.array(moved.weights), pulls[partner]
    weights[skin] = lids.weights(fit.target.vertices[skin], weights[skin], other[skin], carrier.unsure[skin])
    return replace(moved, seam=lids.seam, weights=weights)


def _clusters(clusters: tuple[Cluster, ...], pulls: Floats, structure: Structure) -> tuple[Cluster, ...]:
    """Carry the clusters, whose skin follows them by `pulls` `(C, N)` on the face."""
    frames = structure.frame(np.stack([cluster.frame for cluster in clusters]))
    weights = np.stack([cluster.weights for cluster in clusters])
    growth = np.minimum(structure.growth(weights), structure.bearable(weights))
    return tuple(
        replace(cluster, weights=pulls[row], frame=frames[row], scale=cluster.scale * growth[row])
        for row, cluster in enumerate(clusters)
    )


def _pivot(pivot: Floats, generic: Rig, structure: Structure, skeleton: Skeleton | None) -> Floats:
    """Carry the centre of a ball: with the joint that sits there, if one does."""
    if generic.skeleton is not None and skeleton is not None:
        apart = np.linalg.norm(generic.skeleton.rest[:, :3, 3] - pivot, axis=1)
        joint = int(np.argmin(apart))
        if apart[joint] <= AT_JOINT * structure.reach:
            return np.asarray(skeleton.rest[joint, :3, 3])
    return np.asarray(structure.warp(pivot[None])[0])
