"""The plan of one head of the cast, and how it is carried out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from mien.core import Mesh, Rig, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.core.rig import Colour, no_blendshapes
from mien.library.heads.clay import cast, rotation
from mien.library.heads.cover import Cover, cover
from mien.library.heads.eyes import Eye, eye_rings, eyeball
from mien.library.heads.mouth import Mouth, mouth_rings
from mien.library.heads.pits import Pit, pit_rings
from mien.library.modelling.colours import of_groups
from mien.library.modelling.half import Half, mirrored
from mien.library.modelling.solids import Point, Solids

CENTIMETRE = 0.01

Part = Callable[[Half, Solids], None]
"""Adds something to the left half that is not skin: horns, ears, teeth."""


@dataclass(frozen=True)
class Neck:
    """Where the neck is cut: a point within, the cut's tilt (positive: higher in front) [degrees], and its vertices."""

    centre: Point
    tilt: float = 0.0
    points: int = 17


@dataclass(frozen=True)
class Plan:
    """Everything that makes one head [cm].

    Attributes:
        name: how reports call it.
        solids: the lumps the skin is blended from.
        eye, mouth, pits: the openings.
        cover: how the rest of the skin is covered.
        neck: where it ends.
        places: landmarks on the left or the midline, near the skin.
        parts: what is not skin.
    """

    name: str
    solids: Solids
    eye: Eye
    mouth: Mouth
    cover: Cover
    neck: Neck
    places: Mapping[str, Point]
    pits: tuple[Pit, ...] = ()
    parts: tuple[Part, ...] = field(default=())


def modelled(plan: Plan, colours: Mapping[str, Colour]) -> Rig:
    """Model the head of a plan: skin, eyeballs and parts, with its landmarks and no rig.

    Args:
        plan: the head.
        colours: linear red, green and blue of parts: of groups of that name, on the left, on the right and elsewhere.
    """
    half, marks = Half(), dict[str, int]()
    borders = [eye_rings(half, plan.eye, plan.solids, marks), mouth_rings(half, plan.mouth, plan.solids, marks)]
    borders += [pit_rings(half, pit, plan.solids) for pit in plan.pits]
    neck, plane = _neck(half, plan)
    pins = np.array(list(plan.places.values()), dtype=float).reshape(-1, 3)
    pinned = cover(half, plan.solids, plan.cover, [*borders, neck], pins, plane)
    marks |= {name: int(vertex) for name, vertex in zip(plan.places, pinned, strict=True)}
    eyeball(half, plan.eye)
    for part in plan.parts:
        part(half, plan.solids)
    head = mirrored(half)
    marks |= {other: int(head.mirror[vertex]) for name, vertex in marks.items() if (other := _opposite(name)) != name}
    mesh = Mesh(head.vertices * CENTIMETRE, head.triangles, groups=head.groups)
    landmarks = {name: SurfacePoints.at_vertices(np.array([vertex])) for name, vertex in sorted(marks.items())}
    return Rig(
        mesh, no_blendshapes(len(mesh.vertices)), landmarks=landmarks, name=plan.name, colours=of_groups(mesh, colours)
    )


def _neck(half: Half, plan: Plan) -> tuple[Ints, Floats]:
    """Return the ring at the neck, from the front round the left to the back, and the plane of the cut."""
    turn = np.linspace(0, np.pi, plan.neck.points)
    ring = np.stack([np.sin(turn), np.zeros_like(turn), np.cos(turn)], axis=1) @ rotation(-plan.neck.tilt, 0).T
    ring[[0, -1], 0] = 0
    points = cast(plan.solids, plan.neck.centre + 15 * ring, -ring)
    up = rotation(-plan.neck.tilt, 0) @ [0.0, 1.0, 0.0]
    return half.add(points, "face", "neck"), np.array([*up, -up @ np.array(plan.neck.centre)])


OPPOSITE = (
    {22 + i: 21 - i for i in range(5)}
    | {34: 32, 35: 31, 42: 39, 43: 38, 44: 37, 45: 36, 46: 41, 47: 40}
    | {52: 50, 53: 49, 54: 48, 55: 59, 56: 58, 63: 61, 64: 60, 65: 67}
)
"""The iBUG number on the subject's right of each number on the left."""


def _opposite(name: str) -> str:
    """Return a left landmark's name on the right; the name itself if it is on the midline."""
    if name.endswith("_left"):
        return name[:-4] + "right"
    if name.startswith("ibug_"):
        number = int(name[5:])
        return f"ibug_{OPPOSITE.get(number, number)}"
    return name
