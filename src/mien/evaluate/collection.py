"""Cases from real rigs and recordings, in a folder that holds them.

The folder has `rigs/` (ICT-FaceKit's face and identities, a caricature on its vertices
with the meaning of its shapes, MakeHuman's adult and child, landmarks beside them) and
`clips/livelink/` (a range-of-motion take and two of speech and acting).
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from mien.core import Blendshapes, Clip, Correspondence, FileError, InputError, Mesh, Rig
from mien.core.errors import unknown
from mien.evaluate.cases import Case, across, make_case, same_vertices, without
from mien.evaluate.conditions import Conditions
from mien.evaluate.truth import semantics, split_sides
from mien.io.documents import landmarks_on_mesh, read_landmarks
from mien.io.files import read_bytes, read_text
from mien.io.formats import read_clip, read_rig

TRAINING = "alex_rom_3"
RIGS = {"ict": "ict_face", "toon": "toon", "adult": "makehuman_adult", "child": "makehuman_child"}
ON_ICT = ("ict", "toon")
"""Characters on the vertices of ICT's face, where correspondence is exact."""


@dataclass(frozen=True)
class Recipe:
    """How a case is made.

    Attributes:
        actor: `adult`, `child`, `ict`, or a number that seeds a person of ICT's identities.
        character: a key of `RIGS`.
        test: `S07-001`, `apfel`, or `rom` for the half of the range-of-motion take that training leaves.
        spread: the range of each of the actor's shapes differs by up to this share, either way.
        conditions: of the capture.
        neutral_known: whether the neutral is given.
        visemes: whether MakeHuman's visemes, which nothing drives, stay on the character to distract.
    """

    actor: str
    character: str
    test: str = "S07-001"
    spread: float = 0.0
    conditions: Conditions = field(default_factory=Conditions)
    neutral_known: bool = True
    visemes: bool = False

    @property
    def special(self) -> str:
        """What is unusual about it, in words for a table."""
        words = [
            f"±{self.spread:.0%}" if self.spread else "",
            *self.conditions.special,
            "" if self.neutral_known else "neutral?",
            "visemes" if self.visemes else "",
        ]
        return " ".join(filter(None, words))

    @property
    def name(self) -> str:
        """What the case is called in tables."""
        return f"{self.actor}>{self.character} {self.test} {self.special}".rstrip()


QUICK = (
    Recipe("p1", "ict"),
    Recipe("p1", "toon", spread=0.3),
    Recipe("p2", "toon", "rom", 0.3, Conditions(41, 0.3, head=True)),
    Recipe("p2", "ict", "apfel", 0.3, Conditions(noise_mm=0.5)),
    Recipe("adult", "ict"),
    Recipe("adult", "toon", "apfel"),
    Recipe("p1", "adult"),
    Recipe("adult", "child"),
)
"""A little of everything, in less than a minute."""


def _full() -> tuple[Recipe, ...]:
    takes = ("S07-001", "apfel", "rom")
    people = [
        Recipe(person, character, take, spread)
        for person in ("p1", "p2", "p3")
        for character in RIGS
        for spread in (0.0, 0.3)
        for take in takes
    ]
    crossing = [("adult", "ict"), ("adult", "toon"), ("adult", "child"), ("child", "adult"), ("ict", "child")]
    topologies = [Recipe(a, c, take) for a, c in crossing for take in takes]
    conditions = [
        replace(Recipe(a, c, spread=s), conditions=condition)
        for a, c, s in (("p1", "toon", 0.3), ("adult", "ict", 0.0))
        for condition in (
            Conditions(noise_mm=0.0),
            Conditions(noise_mm=0.5),
            Conditions(41),
            Conditions(41, 0.5),
            Conditions(gaps=0.03),
            Conditions(head=True),
            Conditions(41, 0.5, 0.03, True),
        )
    ]
    others = [Recipe("p1", "toon", spread=0.3, neutral_known=False), Recipe("p1", "adult", visemes=True)]
    return (*people, *topologies, *conditions, *others)


FULL = _full()
"""Every actor, character, take and condition that the accuracy page reports."""


def quick_cases(folder: Path | str, stride: int = 4) -> list[Case]:
    """Return the few cases that show most, with the vertex error at every fourth frame of the test."""
    return [made(Path(folder), recipe, stride) for recipe in QUICK]


def all_cases(folder: Path | str, stride: int = 1) -> Iterable[Case]:
    """Make every case, one after another (they are large)."""
    return (made(Path(folder), recipe, stride) for recipe in FULL)


def made(folder: Path, recipe: Recipe, stride: int = 1, training: Clip | None = None) -> Case:
    """Make a case.

    Args:
        folder: where the rigs and recordings are.
        recipe: what to make.
        stride: the vertex error is measured at every so many frames.
        training: to train on instead of the collection's range-of-motion take.

    Raises:
        FileError: a file of the collection is missing or damaged.
        InputError: the recipe names an unknown rig.
    """
    character = rig(folder, recipe.character)
    if not recipe.visemes:
        character = without(character, tuple(n for n in character.blendshapes.names if n.startswith("viseme_")))
    person = split_sides(actor(folder, recipe.actor, recipe.spread), character.blendshapes.names)
    on_ict = recipe.character in ON_ICT and recipe.actor not in ("adult", "child")
    table = meanings(folder) if recipe.character == "toon" and on_ict else None
    pairs = _pairs(folder, recipe.actor, recipe.character, recipe.conditions.markers)
    recorded = take(folder, TRAINING)
    half = len(recorded) // 2
    test = take(folder, recipe.test) if recipe.test != "rom" else _part(recorded, half, None)
    shown = recorded if recipe.test != "rom" else _part(recorded, 0, half)
    return make_case(
        recipe.name,
        person,
        character,
        semantics(person.blendshapes.names, character.blendshapes.names, table),
        pairs,
        shown if training is None else training,
        test,
        recipe.conditions,
        stride=stride,
        neutral_known=recipe.neutral_known,
    )


@lru_cache(maxsize=8)
def rig(folder: Path, name: str) -> Rig:
    """Read a character with its landmarks."""
    if name not in RIGS:
        raise InputError(unknown("rig of the collection", name, RIGS))
    path = folder / "rigs" / f"{RIGS[name]}.glb"
    face = read_rig(path)
    beside = path.with_suffix(".landmarks.json")
    return replace(face, landmarks=landmarks_on_mesh(read_landmarks(beside), face.neutral, beside), name=name)


@lru_cache(maxsize=8)
def actor(folder: Path, name: str, spread: float = 0.0) -> Rig:
    """Return an actor; `p1`, `p2`, … are people who exist only as a combination of ICT's identities."""
    if not name.startswith("p"):
        return _ranged(rig(folder, name), spread, 0)
    base, seed = rig(folder, "ict"), int(name[1:])
    rng = np.random.default_rng(1000 + seed)
    identities = _identities(folder / "rigs" / "ict_identities.npz")[:, : len(base.neutral.vertices)]
    vertices = base.neutral.vertices + np.tensordot(rng.normal(size=len(identities)), identities, axes=1)
    face = replace(base, neutral=Mesh(vertices, base.neutral.triangles, groups=base.neutral.groups), name=name)
    return _ranged(face, spread, seed)


@lru_cache(maxsize=8)
def take(folder: Path, name: str) -> Clip:
    """Read a recording."""
    return read_clip(folder / "clips" / "livelink" / f"{name}.csv")


def meanings(folder: Path) -> dict[str, dict[str, float]]:
    """Return what the caricature's shapes stand for in ICT's."""
    path = folder / "rigs" / "toon.semantics.json"
    try:
        return {name: dict.fromkeys(parts, 1.0) for name, parts in json.loads(read_text(path)).items()}
    except (ValueError, TypeError, AttributeError) as error:
        raise FileError(f"{path} is not a table of shapes and the shapes they stand for: {error}.") from None


@lru_cache(maxsize=16)
def _pairs(folder: Path, person: str, character: str, count: int) -> Correspondence:
    if character in ON_ICT and person not in ("adult", "child"):
        return same_vertices(rig(folder, "ict"), count)
    return across(actor(folder, person), rig(folder, character), count)


@lru_cache(maxsize=1)
def _identities(path: Path) -> np.ndarray:
    try:
        return np.asarray(np.load(io.BytesIO(read_bytes(path)), allow_pickle=False)["deltas"], dtype=np.float64)
    except (ValueError, KeyError, OSError) as error:
        raise FileError(f"{path} holds no array named 'deltas': {error}.") from None


def _ranged(face: Rig, spread: float, seed: int) -> Rig:
    if spread == 0:
        return face
    rng = np.random.default_rng(2000 + seed)
    shapes = face.blendshapes
    factors = 1 + spread * rng.uniform(-1, 1, len(shapes))
    return replace(face, blendshapes=Blendshapes(shapes.names, shapes.deltas * factors[:, None, None]))


def _part(clip: Clip, begin: int, end: int | None) -> Clip:
    return Clip(clip.names, clip.values[begin:end], clip.fps)
