"""A globe with four mouths, five eyes, two noses and two ears, that floats and feels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial

import numpy as np

from mien.core import Rig
from mien.core.arrays import Floats
from mien.library.characters.eyes import Gaze, brow, eye
from mien.library.characters.globe_ground import ground
from mien.library.characters.globe_places import EYES, MOUTHS, NOSES, RADIUS, Eye, Mouth, seat, wrapped
from mien.library.characters.globe_poses import POSES, REST, GlobePose
from mien.library.characters.mouths import Lips, mouth
from mien.library.characters.parts import Frame, Part, blob, circle, moved, rings, tube
from mien.library.characters.rigs import posed_rig

PROUD = 0.22
"""How far the mouths stand out, so that the ground does not swallow them when only it swells [cm]."""

MASKS = ("body", "mouths", "eyes")

COLOURS: Mapping[str, tuple[float, float, float]] = {
    "sea": (0.06, 0.27, 0.50),
    "land": (0.20, 0.44, 0.13),
    "ice": (0.80, 0.87, 0.92),
    "ears": (0.20, 0.44, 0.13),
    "concha": (0.62, 0.35, 0.26),
    "noses": (0.70, 0.36, 0.16),
    "nostrils": (0.10, 0.03, 0.03),
    "mouths": (0.74, 0.55, 0.28),
    "lips": (0.58, 0.12, 0.13),
    "throat": (0.055, 0.008, 0.012),
    "teeth": (0.87, 0.83, 0.70),
    "tongue": (0.63, 0.16, 0.19),
    "brows": (0.045, 0.13, 0.03),
    "stalks": (0.10, 0.40, 0.42),
    "lids": (0.10, 0.40, 0.42),
    "lashes": (0.02, 0.05, 0.07),
    "sclera": (0.88, 0.88, 0.84),
    "iris": (0.62, 0.33, 0.04),
    "pupil": (0.006, 0.006, 0.008),
    "glint": (0.98, 0.98, 0.98),
}
"""Linear red, green and blue of vertex groups, later ones over earlier."""


@cache
def globe() -> Rig:
    """Make the globe: 23 cm tall, with the extremes of the three layers; its masks are `MASKS`, its look `COLOURS`."""
    return posed_rig("globe", parts, POSES, REST, MASKS, COLOURS)


def parts(pose: GlobePose) -> list[Part]:
    """Return every part of the globe in a pose [cm]."""
    bent = partial(deformed, pose)
    soft = [part.named("body") for part in [_body(pose), *_noses(pose), *_ears(pose)]]
    for number, place in enumerate(MOUTHS, start=1):
        soft += [part.named("mouths") for part in _mouth(pose, place, str(number))]
    made = moved(soft, bent)
    for number, spot in enumerate(EYES, start=1):
        made += [part.named("eyes") for part in _eye(pose, spot, str(number), bent)]
    return made


def deformed(pose: GlobePose, points: Floats) -> Floats:
    """Return where points go when the whole globe stretches, bulges, shivers and leans."""
    x, y, z = (points / RADIUS).T
    tall = 1 + pose.stretch
    side = (1 + pose.pear * np.clip(y, -1.2, 1.2)) / tall**0.3
    wave = 1 + pose.shiver / RADIUS * np.sin(9 * y + 2 * x)
    p = np.stack([x * side * wave, y * tall, z * side * wave], axis=1)
    lean, bow = np.radians([-pose.tilt, pose.nod])
    about_z = np.array([[np.cos(lean), np.sin(lean), 0], [-np.sin(lean), np.cos(lean), 0], [0, 0, 1]])
    about_x = np.array([[1, 0, 0], [0, np.cos(bow), np.sin(bow)], [0, -np.sin(bow), np.cos(bow)]])
    return np.asarray(RADIUS * p @ about_x @ about_z)


def _body(pose: GlobePose) -> Part:
    """Make the ground, with craters in which the mouths are set."""
    body, rise, spiky, deep = ground()
    height = RADIUS + (0.28 + pose.heave) * rise + pose.spikes * spiky - deep
    return replace(body, points=height[:, None] * body.points)


def _noses(pose: GlobePose) -> list[Part]:
    made = []
    for x, y, size in NOSES:
        at = seat(x, y + pose.sniff)
        scale = size * np.array([1 + pose.flare, 1, 1])
        lumps = [((0.0, 0.0, 0.35), (0.85, 0.8, 1.0)), ((0.0, 0.75, 0.0), (0.5, 1.0, 0.6))]
        lumps += [((s * 0.72, -0.28, 0.1), (0.5, 0.46, 0.6)) for s in (1, -1)]
        holes = [((s * 0.42, -0.52, 0.72), (0.24, 0.2, 0.3)) for s in (1, -1)]
        for group, several in (("noses", lumps), ("nostrils", holes)):
            for place, radii in several:
                lump = blob(radii, 6, 12).shifted(*place)
                made.append(replace(lump, points=at.place(lump.points * scale)).named(group))
    return made


def _ears(pose: GlobePose) -> list[Part]:
    made = []
    for side in (1, -1):
        perk = np.radians(pose.ears)
        right = np.array([side * np.cos(perk), np.sin(perk), 0.0])
        up = np.array([-side * np.sin(perk), np.cos(perk), 0.0])
        at = Frame(np.array([side * 0.985 * RADIUS, 1.6, -0.6]), np.stack([right, up, [0, 0, 1]]))
        made.append(_ear().moved(at.place))
    return made


@cache
def _ear() -> Part:
    """Make an ear that points along +x, its bowl open to the front."""
    around = circle(24)
    point = np.clip((around * [0.8, 0.6]).sum(axis=1), 0, 1) ** 3
    outline = around * [1.9, 2.1] * (1 + 0.45 * point)[:, None] + [1.25, 0.35]
    profile = [
        (0.12, -0.25),
        (0.35, -0.22),
        (0.55, -0.1),
        (0.64, 0.08),
        (0.70, 0.34),
        (0.8, 0.5),
        (0.9, 0.5),
        (0.98, 0.32),
    ]
    profile += [(1.0, 0.1), (0.95, -0.2), (0.8, -0.5), (0.5, -0.75), (0.2, -0.85)]
    middle = np.array([1.25, 0.35])
    stack = [np.column_stack([middle + r * (outline - middle), np.full(24, h)]) for r, h in profile]
    ear = rings(np.stack(stack), np.array([[*middle, -0.26], [*middle, -0.86]])).named("ears")
    return ear.named("concha", only=np.append(np.arange(5 * 24), len(ear.points) - 2))


def _mouth(pose: GlobePose, place: Mouth, name: str) -> list[Part]:
    gain, columns = place.opening, 44 if place.size > 0.6 else 28
    lips = Lips(
        half_width=3.4 * (1 + pose.wide),
        up=gain * pose.open_up,
        low=gain * pose.open_low,
        curve=pose.curve,
        skew=pose.skew * (1 if place.x >= 0 else -1),
        pucker=pose.pucker,
        thick=0.52 * (1 + pose.thick),
        tongue=pose.tongue,
    )
    at = seat(place.x, place.y, place.roll)
    return moved(
        mouth(lips, place.outline, place.teeth, name, columns), lambda p: wrapped(at, p * place.size + [0, 0, PROUD])
    )


def _eye(pose: GlobePose, spot: Eye, name: str, bent: Callable[[Floats], Floats]) -> list[Part]:
    """Make an eye, which goes with the globe as a rigid thing and keeps looking ahead."""
    lost = 1 - (pose.squint if spot.x > 1 else 0.35 * pose.squint if spot.x == 0 else 0)
    slant, bow = pose.slant * float(np.sign(spot.x)), 0.0 if spot.x else pose.slant
    gaze = Gaze(pose.upper * lost, pose.lower * lost, slant, pose.right, pose.up, pose.dilate, bow, pose.brow)
    at = _socket(pose, spot).carried(bent)
    r = spot.radius
    made = eye(gaze, name, 24 if r > 2 else 18) + ([] if spot.stalk else [brow(gaze)])
    made = moved(made, lambda p: at.place(r * p))
    if spot.stalk:
        foot = bent(np.array([[0.8 * spot.x, 0.88 * RADIUS, 1.0]]))[0]
        t = np.linspace(0, 1, 8).reshape(-1, 1)
        arc = np.array([0.35 * np.sign(spot.x), 0, 0]) * (4 * t * (1 - t))
        path = foot + t * (at.origin - 0.3 * r * at.axes[2] - foot) + arc
        made.append(tube(path, np.linspace(0.62, 0.42, 8) * r, 14).named("stalks"))
    return made


def _socket(pose: GlobePose, spot: Eye) -> Frame:
    """Return where an eye's centre is before the globe bends, looking a little outwards."""
    if spot.stalk:
        origin = np.array([spot.x, spot.y - 0.35 + pose.stalks, 2.0 + 0.3 * pose.pop])
        return Frame(origin, np.eye(3))
    at = seat(spot.x, spot.y)
    return Frame.facing(at.origin + (0.12 * spot.radius + pose.pop) * at.axes[2], at.axes[2] * [0.45, 0.25, 1.0])
