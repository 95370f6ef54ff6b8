"""Faces to move the generic rig onto: itself, itself moved and scaled, itself without parts, and strangers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Mesh, Rig, SurfacePoints
from mien.core.arrays import Flags, Floats
from mien.core.rig import no_blendshapes
from mien.core.units import face_radius
from mien.library.generic import generic_rig

TURN = np.array([[0.96, 0.0, 0.28], [0.0, 1.0, 0.0], [-0.28, 0.0, 0.96]])
SCALE = 37.0
SHIFT = np.array([1.0, -20.0, 3.0])


def bare(rig: Rig, mesh: Mesh | None = None) -> Rig:
    """The rig as a mesh with landmarks and nothing else."""
    own = rig.neutral if mesh is None else mesh
    return Rig(own, no_blendshapes(len(own.vertices)), landmarks=rig.landmarks, name="face")


def similar(points: Floats) -> Floats:
    return SCALE * points @ TURN.T + SHIFT


def similar_face() -> Rig:
    rig = generic_rig()
    return bare(rig, replace(rig.neutral, vertices=similar(rig.neutral.vertices)))


def without(rig: Rig, gone: Flags) -> Rig:
    """A bare face that lacks some vertices and all triangles on them."""
    number = np.cumsum(~gone) - 1
    triangles = rig.neutral.triangles[~gone[rig.neutral.triangles].any(axis=1)]
    groups = {name: number[ids[~gone[ids]]] for name, ids in rig.neutral.groups.items() if not gone[ids].all()}
    mesh = Mesh(rig.neutral.vertices[~gone], number[triangles], groups=groups)
    marks = {name: SurfacePoints(number[point.corners], point.weights) for name, point in rig.landmarks.items()}
    return Rig(mesh, no_blendshapes(len(mesh.vertices)), landmarks=marks, name="face")


def skin_only() -> Rig:
    """The generic face without eyes, brows, teeth and tongue."""
    rig = generic_rig()
    gone = np.ones(len(rig.neutral.vertices), np.bool_)
    gone[rig.neutral.groups["face"]] = False
    return without(rig, gone)


def radius(rig: Rig) -> float:
    return face_radius(np.concatenate([point.of(rig.neutral.vertices) for point in rig.landmarks.values()]))
