"""A whole rig onto a bare face (Orvalho, Zacur, Susin, §4.7).

The face's own mesh is not altered: it receives bones, skin weights, muscles, deformers,
attributes, templates and blendshapes, each carried by the dense correspondence.  Eyes
and teeth that it has follow as parts; those it lacks can be brought along.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mien.core import InputError, Note, Rig, Skeleton, Skin
from mien.core.errors import unknown
from mien.core.units import human_centimetre
from mien.geometry.templates import template_shapes
from mien.rigging.anatomy import carried_anatomy
from mien.rigging.attributes import Carrier
from mien.rigging.blendshapes import carried
from mien.rigging.brought import Brought, bring, colours_with, face_with
from mien.rigging.dense import DenseFit, lay
from mien.rigging.inside import settled
from mien.rigging.joints import carried_joints
from mien.rigging.landmarks import check_is_face, paired_landmarks
from mien.rigging.parts import attachments
from mien.rigging.structure import Structure

METHODS: Mapping[str, str] = {
    "warp-and-stick": "dense",
    "rbf": "rbf",
    "deformation-transfer": "deformation-transfer",
}
"""How blendshapes go along, by the method's name."""


@dataclass(frozen=True, eq=False)
class Transfer:
    """A rig on another face, and how well it sits.

    Attributes:
        rig: the face, rigged.
        fit: the correspondence it rests on.
        brought: the parts that were added behind the face's own vertices.
        figures: numbers of the report, lengths in millimetres on a human-sized face.
        notes: what was repaired or left out.
    """

    rig: Rig
    fit: DenseFit
    brought: Brought
    figures: Mapping[str, Any]
    notes: tuple[Note, ...]


def transfer_rig(
    generic: Rig, face: Rig, *, method: str = "warp-and-stick", influences: int = 4, parts: str = "auto"
) -> Transfer:
    """Move a rig onto a face.

    Args:
        generic: the rig, with landmarks.
        face: a mesh with some of the same landmarks, in either vocabulary.
        method: a key of `METHODS`.  The baselines move shapes only, so the templates of
            a generic rig are made into shapes first and play as these.
        influences: the most joints a vertex follows.
        parts: `auto` brings the eyes, teeth and tongue that the face lacks, `none` brings nothing.

    Raises:
        InputError: an unknown method, landmarks that do not fit, or a mesh that is no face.
    """
    if method not in METHODS:
        raise InputError(unknown("rig transfer method", method, METHODS))
    if parts not in ("auto", "none"):
        raise InputError(unknown("way to treat missing parts", parts, ("auto", "none")))
    began = time.perf_counter()
    pairs = paired_landmarks(generic, face)
    fit = lay(generic.neutral, pairs.source, face.neutral, pairs.target)
    check_is_face(fit, face.name)
    structure = Structure.of(fit)
    lying = attachments(fit)
    attached = settled(fit, generic.skin, lying)
    brought = bring(generic, fit, structure, attached) if parts == "auto" else Brought.nothing()
    carrier = Carrier.of(fit, attached, brought)
    skeleton, skin = None, None
    if generic.skeleton is not None and generic.skin is not None:
        rest = carried_joints(generic, fit, structure, attached, brought)
        skeleton = Skeleton(generic.skeleton.names, generic.skeleton.parents, rest)
        skin = Skin(*carrier.skin(generic.skin, influences), np.asarray(np.linalg.inv(rest), np.float64))
    anatomy = carried_anatomy(generic, structure, skeleton, carrier)
    shaped = generic
    if method != "warp-and-stick" and anatomy is not None and anatomy.templates:
        shaped = replace(generic, blendshapes=template_shapes(generic))
        anatomy = replace(anatomy, templates={}, bases={}, scripts={})
    shapes, shape_notes = carried(shaped, fit, METHODS[method], attached=lying)
    rigged = replace(
        face,
        neutral=face_with(face.neutral, generic.neutral, brought),
        blendshapes=brought.shapes(shapes, shaped.blendshapes.deltas),
        skeleton=skeleton,
        skin=skin,
        anatomy=anatomy,
        landmarks=_landmarks(generic, face, fit, {mine for mine, _ in pairs.names}),
        colours=colours_with(face, generic, brought),
    )
    figures = {**_figures(fit, pairs.names, structure), "seconds": round(time.perf_counter() - began, 3)}
    notes = (*pairs.notes, *fit.notes, *shape_notes, *brought.notes, *_fewer_influences(generic, influences))
    return Transfer(rigged, fit, brought, figures, notes)


def _fewer_influences(generic: Rig, influences: int) -> tuple[Note, ...]:
    """Say that vertices follow fewer joints than on the rig, if they do."""
    most = 0 if generic.skin is None else int((generic.skin.weights > 0).sum(axis=1).max(initial=0))
    if most <= influences:
        return ()
    text = f"vertices of {generic.name} follow up to {most} joints, here at most {influences}; more influences keep more of how they blend."
    return (Note("fewer-influences", text, generic.name),)


def _landmarks(generic: Rig, face: Rig, fit: DenseFit, shared: set[str]) -> dict[str, Any]:
    """Return the face's own landmarks, and every further one of the rig that has a place on the face."""
    found = dict(face.landmarks)
    for name, point in generic.landmarks.items():
        vertex = int(point.corners[0, np.argmax(point.weights[0])])
        if name not in shared and name not in found and fit.paired[vertex]:
            found[name] = fit.points.take(np.array([vertex]))
    return found


def _figures(fit: DenseFit, names: tuple[tuple[str, str], ...], structure: Structure) -> dict[str, Any]:
    millimetre = 0.1 * human_centimetre(fit.warp(fit.warp.centres))
    moved = np.linalg.norm(fit.stuck - fit.warped, axis=1)[fit.paired] / millimetre
    off = fit.back_distance[fit.target_skin] / millimetre
    return {
        "landmarks": len(names),
        "stuck_rms_mm": round(float(np.sqrt((moved**2).mean())), 4),
        "stuck_max_mm": round(float(moved.max()), 4),
        "uncovered_rms_mm": round(float(np.sqrt((off**2).mean())), 4),
        "folds_before": fit.folds_before,
        "folds_after": fit.folds_after,
        "structure_rms_mm": round(structure.left_over / millimetre, 4),
        "structure_centres": len(structure.warp.centres),
    }
