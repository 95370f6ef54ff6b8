"""A rigged face's expressions as blendshapes, and its scripts as their weights.

The templates are played on the face and what they add to it is kept.  Skin that they
would turn over is relaxed; where lids and lips meet on the generic rig they are made to
meet on the face too, and an eye that is shut is shut all the way to its corners.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mien.core import Blendshapes, Clip, Note, Rig
from mien.core.arrays import Floats, matching
from mien.geometry.templates import template_shapes
from mien.rigging.blendshapes import closed
from mien.rigging.membrane import Membrane
from mien.rigging.sealing import Eye, sealed
from mien.rigging.transfer import Transfer

SHUT = tuple((f"orbicularis_oculi_upper_{side}", f"orbicularis_oculi_lower_{side}") for side in ("left", "right"))
"""Both muscles of these contract fully where an eye is shut."""
LIDS = frozenset(name for pair in SHUT for name in pair)
LID = 0.1
"""Skin that follows one of these at least so fully is lid."""


def baked(transfer: Transfer, generic: Rig, names: Iterable[str] | None = None) -> tuple[Blendshapes, tuple[Note, ...]]:
    """Make blendshapes of a rigged face's templates.

    Args:
        transfer: the rigged face.
        generic: the rig it came from.
        names: which templates; all if None.

    Returns:
        The shapes, and notes on the skin that was relaxed and the gaps that were closed.
    """
    chosen = tuple(transfer.rig.anatomy.templates if names is None and transfer.rig.anatomy else names or ())
    shapes = template_shapes(transfer.rig, chosen)
    if not chosen:
        return shapes, ()
    own = len(transfer.fit.target.vertices)
    lying, relaxed = _relaxed(transfer, chosen, shapes.deltas[:, :own])
    met, notes = closed(template_shapes(generic, chosen), lying, transfer.fit)
    deltas = np.concatenate([met, shapes.deltas[:, own:]], axis=1)
    remarks = [note for row, name in enumerate(chosen) for note in _shut(transfer, name, deltas[row])]
    return Blendshapes(chosen, deltas), (*relaxed, *notes, *remarks)


def _relaxed(transfer: Transfer, names: tuple[str, ...], deltas: Floats) -> tuple[Floats, list[Note]]:
    """Relax the displacements `(K, N, 3)` of templates where they turn the skin over, but for the lids.

    A template that is meant on top of another is relaxed with it, and adds to what that one was relaxed to.
    """
    anatomy = transfer.rig.anatomy
    assert anatomy is not None
    lids = np.zeros(deltas.shape[1], np.bool_)
    for muscle in anatomy.muscles:
        if muscle.name in LIDS:
            lids |= muscle.weights[: len(lids)] > LID
    bases = {row: names.index(base) for row, name in enumerate(names) if (base := anatomy.bases.get(name)) in names}
    membrane, poses, notes = Membrane.of(transfer.fit, lids), np.array(deltas), []
    for row, name in enumerate(names):
        if name in anatomy.bases and row not in bases:  # no pose by itself
            continue
        whole = deltas[row] + deltas[bases[row]] if row in bases else deltas[row]
        poses[row], before, after = membrane.relaxed(whole)
        if before:
            notes.append(Note("skin-relaxed", f"{before} triangles were turned over, now {after}.", name))
    added = poses.copy()
    for row, under in bases.items():
        added[row] -= poses[under]
    return added, notes


def _shut(transfer: Transfer, name: str, deltas: Floats) -> list[Note]:
    """Seal, in place, the eyes that a template's displacements `(N, 3)` shut; return notes on what stays open."""
    rig, fit = transfer.rig, transfer.fit
    assert rig.anatomy is not None
    controls, muscles = rig.anatomy.templates[name], {muscle.name: muscle for muscle in rig.anatomy.muscles}
    rest, triangles, notes = rig.neutral.vertices, rig.neutral.triangles, []
    skin = np.pad(fit.target_skin, (0, len(rest) - len(fit.target_skin)))[triangles]
    for lids in SHUT:
        if not all(lid in muscles and muscles[lid].pivot is not None and controls.get(lid, 0) >= 1 for lid in lids):
            continue
        eye = Eye.under(muscles[lids[0]], rest, triangles[skin.all(axis=1)], triangles[~skin.any(axis=1)])
        posed, before, after = sealed(rest + deltas, eye, fit)
        deltas += posed - (rest + deltas)
        if before > 0:
            text = f"lids left up to {1e3 * before:.2f} mm of an eye open, now {1e3 * after:.2f} mm."
            notes.append(Note("lids-sealed", text, name))
    return notes


def scripted(script: Clip, shapes: Blendshapes) -> Clip:
    """Return a script, whose channels are templates, as weights of the blendshapes made of them."""
    place = matching(script.names, shapes.names)
    values = np.where(place >= 0, script.values[:, place], 0.0)
    return Clip(shapes.names, values, script.fps)
