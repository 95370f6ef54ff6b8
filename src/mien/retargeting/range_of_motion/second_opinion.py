"""A second opinion on where shapes move the face: the generic rig's shapes of the same names.

Two sculptors' `mouthFunnel` are two movements, and the actor's is a third.  What one head
does by habit the other does not, so between heads of unlike make a mixture of the two is
nearer to the actor than either; between heads of one make the character's own are better
(docs/accuracy.md).  Which it is the take says: in each region of the face the mixture is
kept that explains it best once refitted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mien.core import InputError, Note, Rig, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.geometry.templates import template_shapes
from mien.library.generic import generic_rig
from mien.retargeting.prepare import Prepared
from mien.retargeting.range_of_motion.refit import Refit, Take, begun, refitted, thinned, unexplained
from mien.rigging.blendshapes.dense import transfer
from mien.rigging.dense import lay
from mien.rigging.landmarks import check_is_face, paired_landmarks
from mien.vocabularies import ShapeKey, shape_key
from mien.vocabularies.regions import regions_of

SHARES = (0.0, 0.25, 0.5, 0.75)
"""Of the opinion in the mixtures that are tried."""
FRAMES, ROUNDS = 400, 2
"""Mixtures are compared on about this many frames, refitted so many times."""
WORTH = 0.04
"""Whole shapes of the opinion must take this share off what is left unexplained to be worth it; half of it, half that."""
OWN = "blink"
"""Shapes with this in their names are the character's own affair: only its lids say where an eye is shut."""
STILL = 1e-6
"""A shape that moves the points by no more than this [cm] has no direction."""


def second_opinion(character: Rig, prepared: Prepared) -> tuple[Floats | None, tuple[Note, ...]]:
    """Return what the generic rig makes of the character's shapes.

    Args:
        character: a rig with landmarks.
        prepared: the paired points, and the terms to bring them into.

    Returns:
        `(K, M, 3)` displacements of the points [cm], each of the size of the character's shape, and equal to it
        where the generic rig has no shape of that name.  None if it has none, or cannot be laid on the
        character, which a note tells.
    """
    generic = generic_rig()
    templates = tuple(generic.anatomy.templates) if generic.anatomy else ()
    same = same_shapes(character.blendshapes.names, templates)
    used = same.any(axis=0)
    if not used.any():
        return None, ()
    try:
        pairs = paired_landmarks(generic, character)
        fit = lay(generic.neutral, pairs.source, character.neutral, pairs.target, repair=False)
        check_is_face(fit, character.name)
    except InputError as error:
        text = f"the built-in generic rig is not asked for a second opinion on the shapes, for it cannot be laid on the character: {error}"
        return None, (Note("no-second-opinion", text, character.name),)
    shapes = template_shapes(generic, tuple(np.array(templates)[used])).deltas
    moved = transfer(shapes, fit, fit.back.take(_nearest_vertices(prepared.pairs.target)))
    terms = prepared.terms
    opinion = terms.placement.invert_vectors(np.tensordot(same[:, used], moved, axes=1)) / terms.centimetre
    return _of_size(opinion, terms.deltas), ()


def same_shapes(names: Sequence[str], templates: Sequence[str]) -> Floats:
    """Return `(K, T)`: the templates that add up to each shape, which are itself or its two halves.

    A half of which there is only the whole has none, nor has a blink.
    """
    place = {shape_key(template): column for column, template in enumerate(templates)}
    same = np.zeros((len(names), len(templates)))
    for row, name in enumerate(names):
        key = shape_key(name)
        if OWN in key.stem:
            continue
        halves = [] if key.side else [ShapeKey(key.stem, side) for side in "LR"]
        for made_of in ([key], halves):
            if made_of and all(part in place for part in made_of):
                same[row, [place[part] for part in made_of]] = 1
                break
    return same


def heard(
    own: Floats, opinion: Floats, take: Take, refit: Refit, *, full_range: bool
) -> tuple[Floats, dict[str, float]]:
    """Mix the character's shapes with the opinion, as far as the take bears it out.

    One share for the whole face is looked for first; then each region may depart from it by a step.

    Args:
        own: `(K, M, 3)` the character's shapes [cm].
        opinion: the same as the generic rig has them.
        take: what the actor did.
        refit: how far shapes will be refitted.
        full_range: whether they will be calibrated.

    Returns:
        `(K, M, 3)` shapes of the character's size [cm], and the opinion's share in each region.
    """
    few, regions = thinned(take, FRAMES), regions_of(take.names)

    def left(shares: Floats) -> float:
        shapes = begun(mixed(own, opinion, shares), few, refit, full_range=full_range)
        for _ in range(ROUNDS):
            shapes = refitted(shapes, few, refit)
        return unexplained(shapes, few) * (1 + WORTH * float(shares.mean()))

    whole = [np.full(len(own), share) for share in SHARES]
    errors = [left(shares) for shares in whole]
    at = int(np.argmin(errors))
    best, least = whole[at], errors[at]
    for region in np.unique(regions):
        for other in SHARES[max(0, at - 1) : at + 2]:
            shares = np.where(regions == region, other, best)
            if not np.array_equal(shares, best) and (error := left(shares)) < least:
                best, least = shares, error
    return mixed(own, opinion, best), {str(region): float(best[regions == region][0]) for region in np.unique(regions)}


def mixed(own: Floats, opinion: Floats, shares: Floats) -> Floats:
    """Return shapes `(K, M, 3)` of the size of `own`, in the directions between it and `opinion`."""
    share = shares[:, None, None]
    return _of_size((1 - share) * own + share * opinion, own)


def _of_size(shapes: Floats, like: Floats) -> Floats:
    """Scale each shape to the size of its namesake; one that has no direction becomes the namesake."""
    size, wanted = (np.linalg.norm(each, axis=(1, 2), keepdims=True) for each in (shapes, like))
    return np.asarray(np.where(size > STILL, shapes * (wanted / np.maximum(size, STILL)), like))


def _nearest_vertices(points: SurfacePoints) -> Ints:
    return np.asarray(points.corners[np.arange(len(points.corners)), points.weights.argmax(axis=1)])
