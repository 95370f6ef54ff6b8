"""Whom the figures show: the generic rig moved onto the cast and onto real heads, by few or many landmarks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from mien.core import Rig
from mien.geometry.templates import template_shapes
from mien.io.documents import landmarks_on_mesh, read_landmarks
from mien.io.formats import read_rig
from mien.library.generic import generic_rig
from mien.library.heads import HEADS
from mien.rigging.baking import baked
from mien.rigging.transfer import Transfer, transfer_rig
from mien.vocabularies.anthropometry import same_landmarks

EYE_CORNERS = ("endocanthion_left", "endocanthion_right", "exocanthion_left", "exocanthion_right")
MOUTH_CORNERS = ("cheilion_left", "cheilion_right")
TEN = (*EYE_CORNERS, "pronasale", *MOUTH_CORNERS, "pogonion", "zygion_left", "zygion_right")
"""As many as the paper's human has: what a person can point at without thinking, and the width of the face."""
TWELVE = (*TEN, "labiale_superius", "labiale_inferius")
"""As many as its goat has."""
SETS: dict[str, tuple[str, ...] | None] = {"10": TEN, "12": TWELVE, "all": None}

REAL = {
    "ICT": "ict_head",
    "MakeHuman adult": "makehuman_adult",
    "MakeHuman child": "makehuman_child",
    "toon": "toon",
    "Aura": "aura",
}
"""Real heads, and what their files are called."""


@dataclass(frozen=True)
class Settings:
    """What every figure is asked for.

    Attributes:
        out: the folder that pictures go to.
        data: the folder of real heads; None if there is none.
        quick: fewer faces and smaller pictures.
        results: the folder that tables go to.
    """

    out: Path
    data: Path | None
    quick: bool
    results: Path

    @property
    def tile(self) -> int:
        """The size of one picture of a sheet [pixels]."""
        return 150 if self.quick else 240

    @property
    def cast(self) -> tuple[str, ...]:
        """The faces made by code."""
        return ("actor", "cartoon", "goat") if self.quick else tuple(HEADS)

    @property
    def faces(self) -> tuple[str, ...]:
        """All faces there are: the cast and, where there is data, the real heads."""
        if self.data is None:
            return self.cast
        return (*self.cast, *(("MakeHuman adult",) if self.quick else REAL))

    def bare(self, name: str) -> Rig:
        """Return a face without any rig, with its landmarks."""
        if name in HEADS:
            return HEADS[name]()
        assert self.data is not None
        return _real(self.data / "rigs", REAL[name], name)

    def transfer(self, name: str, landmarks: str = "all") -> Transfer:
        """Move the generic rig onto a face by some of its landmarks, a key of `SETS`."""
        return _transferred(self, name, landmarks)


@cache
def _transferred(settings: Settings, name: str, landmarks: str) -> Transfer:
    return transfer_rig(generic_rig(), with_landmarks(settings.bare(name), SETS[landmarks]))


@cache
def _real(folder: Path, file: str, name: str) -> Rig:
    rig = read_rig(folder / f"{file}.glb")
    path = folder / f"{file}.landmarks.json"
    shapes = replace(rig.blendshapes, names=(), deltas=np.zeros((0, len(rig.neutral.vertices), 3)))
    places = landmarks_on_mesh(read_landmarks(path), rig.neutral, path)
    return replace(rig, blendshapes=shapes, skeleton=None, skin=None, landmarks=places, name=name)


def with_landmarks(face: Rig, wanted: tuple[str, ...] | None) -> Rig:
    """Return a face with those landmarks alone that the generic rig calls so; with all if None."""
    if wanted is None:
        return face
    kept = {theirs for ours, theirs in same_landmarks(generic_rig().landmarks, face.landmarks) if ours in wanted}
    return replace(face, landmarks={name: point for name, point in face.landmarks.items() if name in kept})


def acting(transfer: Transfer, names: tuple[str, ...]) -> Rig:
    """Return a rigged face with these templates as blendshapes, as files receive them."""
    return replace(transfer.rig, blendshapes=baked(transfer, generic_rig(), names)[0])


def generic_acting(names: tuple[str, ...]) -> Rig:
    """Return the generic rig with these templates as blendshapes."""
    return replace(generic_rig(), blendshapes=template_shapes(generic_rig(), names))
