"""People who exist only as numbers: one face, smoothly warped into another, so that any number of identities runs anywhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import Blendshapes, Mesh, Rig
from mien.core.arrays import Floats
from mien.evaluate.metrics import millimetre

BUMPS = 8
"""How many places a face is pulled at …"""
REACH_MM = 45.0
"""… how wide …"""
PULL_MM = 4.0
"""… and how far: the standard deviation of each coordinate, on a 23 cm head."""


def person(face: Rig, number: int, spread: float = 0.0) -> Rig:
    """Return one of many people with a face's shapes; always the same for a number.

    The space around the face is warped, so that what touches stays in touch: lids still
    close, lips still meet.

    Args:
        face: whom they descend from, with landmarks.
        number: of the person.
        spread: the range of each shape differs by up to this share, either way.
    """
    unit = millimetre(face)
    rng = np.random.default_rng(3000 + number)
    vertices = face.neutral.vertices
    centres = vertices[rng.integers(len(vertices), size=BUMPS)]
    pulls = rng.normal(0, PULL_MM * unit, (BUMPS, 3))
    factors = 1 + spread * rng.uniform(-1, 1, len(face.blendshapes))

    def warped(points: Floats) -> Floats:
        apart = ((points[..., None, :] - centres) ** 2).sum(axis=-1)
        return np.asarray(points + np.exp(-apart / (2 * (REACH_MM * unit) ** 2)) @ pulls)

    neutral = warped(vertices)
    deltas = warped(vertices + face.blendshapes.deltas) - neutral
    deltas[~face.blendshapes.deltas.any(axis=2)] = 0.0
    shapes = Blendshapes(face.blendshapes.names, deltas * factors[:, None, None])
    mesh = Mesh(neutral, face.neutral.triangles, groups=face.neutral.groups)
    return replace(face, neutral=mesh, blendshapes=shapes, name=f"person {number}")
