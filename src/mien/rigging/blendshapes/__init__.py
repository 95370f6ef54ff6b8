"""A rig's blendshapes on another face, by one of three methods, with what is attached to the face.

One row of `METHODS` says where a method is and what it is for.  Whatever moves the skin,
parts such as eyes and teeth follow as `parts` says, and lids and lips that meet on the
source are made to meet by `contact`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from mien.core import Blendshapes, InputError, Note, Rig, SurfacePoints
from mien.core.arrays import Floats
from mien.core.errors import unknown
from mien.core.rig import no_blendshapes
from mien.rigging.blendshapes import deformation_transfer, rbf
from mien.rigging.blendshapes.dense import transfer as through_correspondence
from mien.rigging.contact import Closing, close
from mien.rigging.dense import DenseFit
from mien.rigging.parts import Attachment, attachments, move_parts
from mien.vocabularies import shape_key


@dataclass(frozen=True)
class Method:
    """A way to move the skin's shapes.

    Attributes:
        about: one line for tables.
        transfer: from the source's deltas `(K, Ns, 3)`, the correspondence and the points on the source of the
            target's skin vertices, to the displacements `(K, M, 3)` of those vertices.
        adds_up: whether it carries the sum of two shapes to the sum of what it carries them to.
    """

    about: str
    transfer: Callable[[Floats, DenseFit, SurfacePoints], Floats]
    adds_up: bool = True


METHODS: dict[str, Method] = {
    "dense": Method("every vertex moves as its point on the source, turned and scaled", through_correspondence),
    "rbf": Method("the landmark warp of the moved face less that of the face at rest", rbf.transfer, adds_up=False),
    "deformation-transfer": Method(
        "every triangle deforms as its counterpart (Sumner & Popović 2004)", deformation_transfer.transfer
    ),
}


def carried(
    rig: Rig,
    fit: DenseFit,
    method: str = "dense",
    *,
    contact: bool = True,
    attached: tuple[Attachment, ...] | None = None,
) -> tuple[Blendshapes, tuple[Note, ...]]:
    """Carry a rig's blendshapes to the face it was laid on.

    Args:
        rig: the source, on whose neutral `fit` was made.
        fit: the correspondence.
        method: a key of `METHODS`.
        contact: whether lids and lips that meet on the source are made to meet.
        attached: what the target's parts follow; found if None.

    Returns:
        The shapes of the target under the same names; and notes on empty shapes, parts, and gaps that were closed.

    Raises:
        InputError: an unknown method, or a fit of another mesh.
    """
    if method not in METHODS:
        raise InputError(unknown("method to carry blendshapes by", method, METHODS))
    if len(fit.source.vertices) != len(rig.neutral.vertices):
        raise InputError(
            f"the correspondence is of a face with {len(fit.source.vertices)} vertices, but the rig {rig.name!r} has "
            f"{len(rig.neutral.vertices)}; lay this rig's neutral on the target first."
        )
    if not len(rig.blendshapes):
        return no_blendshapes(len(fit.target.vertices)), ()
    deltas = rig.blendshapes.deltas
    skin = np.flatnonzero(fit.target_skin)
    moved = np.zeros((len(deltas), len(fit.target.vertices), 3))
    together = {} if METHODS[method].adds_up else poses(rig.blendshapes.names)
    moved[:, skin] = _atop(METHODS[method].transfer, together.values(), deltas, fit, fit.back.take(skin))
    notes = [Note("empty-blendshape", "the shape moves nothing on the source", name) for name in rig.blendshapes.empty]
    if contact:
        moved, remarks = closed(rig.blendshapes, moved, fit)
        notes += remarks
    moved, riding = move_parts(deltas, moved, fit, attachments(fit) if attached is None else attached)
    return Blendshapes(rig.blendshapes.names, moved), (*notes, *riding)


def _atop(
    transfer: Callable[[Floats, DenseFit, SurfacePoints], Floats],
    together: Iterable[tuple[int, ...]],
    deltas: Floats,
    fit: DenseFit,
    back: SurfacePoints,
) -> Floats:
    """Move shapes, and those that mean something on top of others only, the last of some rows, on top of them.

    A warp bends the closing of a mouth where the lips are when the jaw is open, not where they rest.
    """
    upon = [(rows[-1], list(rows[:-1])) for rows in together if len(rows) > 1]
    posed = np.array(deltas) if upon else deltas
    for row, base in upon:
        posed[row] += deltas[base].sum(axis=0)
    moved = transfer(posed, fit, back)
    for row, base in upon:
        stirred = np.any(back.of(deltas[row]), axis=1, keepdims=True)
        moved[row] = np.where(stirred, moved[row] - moved[base].sum(axis=0), 0.0)
    return moved


def closed(source: Blendshapes, moved: Floats, fit: DenseFit) -> tuple[Floats, tuple[Note, ...]]:
    """Make lids and lips meet in a target's displacements `(K, Nt, 3)` where they do in the source's shapes."""
    met, closings = close(source.deltas, moved, poses(source.names), fit)
    return met, _closed(closings)


def poses(names: tuple[str, ...]) -> dict[str, tuple[int, ...]]:
    """Return the poses in which contacts are looked for: the rows of the shapes of each, by its name.

    Every shape is one, but closing the mouth means something only with the jaw open
    (ARKit), so where there is a jaw they are one pose and the closing is what is corrected.
    """
    stems = {shape_key(name).stem: row for row, name in enumerate(names)}
    jaw, mouth = stems.get("jawopen"), stems.get("mouthclose")
    result: dict[str, tuple[int, ...]] = {name: (row,) for row, name in enumerate(names) if jaw is None or row != mouth}
    if jaw is not None and mouth is not None:
        result[f"{names[jaw]} + {names[mouth]}"] = (jaw, mouth)
    return result


def _closed(closings: Sequence[Closing]) -> tuple[Note, ...]:
    if not closings:
        return ()
    before, after = (max(closings, key=lambda closing: getattr(closing, which)) for which in ("before", "after"))
    text = (
        f"lids and lips that touch on the source were off by up to {1e3 * before.before:.2f} mm ({before.name}) in "
        f"{len(closings)} poses, now by up to {1e3 * after.after:.2f} mm ({after.name})."
    )
    return (Note("contact-kept", text, after.name),)
