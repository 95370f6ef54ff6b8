"""What a modelled head can do: the ARKit shapes as smooth fields over the skin.

Most shapes are a few pushes: a place on the face, a displacement, and a radius over
which it fades, on the upper lip's side, the lower lip's, or both.  The jaw turns about
its hinge, lids turn about the eye's own axis, and eyeballs turn about their centres.
Lengths are centimetres of the actor's face and grow with the feature they move.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from mien.core.arrays import Floats
from mien.library.generic.measures import Measures, front
from mien.library.modelling.half import Head

JAW_TURN = np.radians(19)
GAZE = {"Up": np.radians(24), "Down": np.radians(28), "In": np.radians(32), "Out": np.radians(32)}


class Push(NamedTuple):
    """Move the skin around `place` by `move`, fading over `radius`; `side` is one lip's side of the mouth or both."""

    place: str
    move: tuple[float, float, float]
    radius: float
    side: str = "both"


SIDED: dict[str, tuple[Push, ...]] = {
    "mouthSmile": (Push("corner", (0.65, 0.85, -0.45), 1.5), Push("cheek", (0.15, 0.4, 0.35), 1.8)),
    "mouthFrown": (Push("corner", (0.1, -0.8, -0.15), 1.5),),
    "mouthDimple": (Push("corner", (0.4, 0.05, -0.55), 1.2),),
    "mouthStretch": (Push("corner", (0.75, -0.3, -0.4), 1.7), Push("lower", (0.1, -0.2, 0), 1.5, "lower")),
    "mouthUpperUp": (Push("upper", (0.05, 0.7, 0.1), 1.4, "upper"), Push("wing", (0.05, 0.12, 0), 1.0)),
    "mouthLowerDown": (Push("lower", (0.1, -0.75, 0.05), 1.4, "lower"),),
    "mouthPress": (Push("lips", (0.1, 0, -0.28), 1.2), Push("corner", (0.1, 0.1, -0.1), 1.0)),
    "cheekSquint": (Push("cheekbone", (0.05, 0.45, 0.3), 1.6),),
    "noseSneer": (Push("wing", (0.1, 0.45, 0.1), 1.1), Push("upper", (0, 0.3, 0.05), 1.2, "upper")),
    "browDown": (Push("brow_inner", (-0.3, -0.6, 0.12), 1.3), Push("brow_peak", (-0.1, -0.35, 0.05), 1.4)),
    "browOuterUp": (Push("brow_outer", (0, 0.6, 0), 1.5), Push("brow_peak", (0, 0.35, 0), 1.3)),
}
"""Shapes of the left side; the right side is their mirror image."""

WHOLE: dict[str, tuple[Push, ...]] = {
    "mouthPucker": (Push("corner", (-1.05, 0, 0.35), 1.6), Push("lips", (0, 0, 0.45), 1.5)),
    "mouthFunnel": (
        Push("corner", (-0.75, 0, 0.35), 1.5),
        Push("upper", (-0.05, 0.22, 0.42), 1.4, "upper"),
        Push("lower", (-0.05, -0.32, 0.42), 1.4, "lower"),
    ),
    "mouthRollUpper": (Push("upper", (0, 0.0, -0.28), 1.3, "upper"),),
    "mouthRollLower": (Push("lower", (0, 0.0, -0.28), 1.3, "lower"),),
    "mouthShrugLower": (Push("lips", (0, 0.16, 0.1), 1.5), Push("chin", (0, 0.2, 0.1), 1.5)),
    "cheekPuff": (Push("cheek", (0.75, -0.1, 0.75), 1.9),),
    "browInnerUp": (Push("brow_inner", (0, 0.75, 0.08), 1.4),),
}
"""Shapes of both sides at once: each push acts on the left and, mirrored, on the right."""

LIDS = {"eyeBlink": (1.0, 1.0), "eyeWide": (-0.32, -0.12), "eyeSquint": (0.22, 0.6)}
"""How far the upper and the lower lid go towards closing."""

LIDS_FOLLOW = {"Up": (-0.25, 0.1), "Down": (0.45, -0.3), "In": (0.0, 0.0), "Out": (0.0, 0.0)}
"""The same while the eye looks up or down."""


def arkit_shapes(measures: Measures, head: Head) -> dict[str, Floats]:
    """Return the `(N, 3)` displacement [cm] of each ARKit shape on this head."""
    field = _Fields(measures, head)
    shapes = field.jaw()
    for name, pushes in WHOLE.items():
        left = field.pushed(pushes)
        shapes[name] = left + _mirrored(head, left)
    left = field.skin[:, None] * field.weight("lips", 2.2)[:, None] * np.array([0.85, 0.1, 0]) * field.mouth_size
    shapes["mouthLeft"], shapes["mouthRight"] = left, _mirrored(head, left)
    sided = {name: field.pushed(pushes) for name, pushes in SIDED.items()}
    sided |= {name: field.lids(*amounts) for name, amounts in LIDS.items()}
    sided |= {f"eyeLook{way}": field.gaze(way) + field.lids(*LIDS_FOLLOW[way]) for way in GAZE}
    sided["cheekSquint"] = sided["cheekSquint"] + field.lids(0.0, 0.2)
    for name, delta in sided.items():
        shapes[name + "Left"], shapes[name + "Right"] = delta, _mirrored(head, delta)
    return shapes


def _mirrored(head: Head, delta: Floats) -> Floats:
    return np.asarray(delta[head.mirror] * [-1, 1, 1])


class _Fields:
    """The weights from which the shapes of one head are made."""

    def __init__(self, m: Measures, head: Head) -> None:
        self.measures, self.head, self.points = m, head, head.vertices
        self.skin = np.ones(len(head.vertices))
        for part in ("eye_left", "eye_right", "teeth"):
            self.skin[head.groups[part]] = 0
        self.mouth_size = m.mouth.half_width / 2.5
        self.brow_size = m.eye.half_width / 1.42
        self.above = _side_of_slit(m, head.vertices)
        self.places = _places(m)

    def weight(self, place: str, radius: float, side: str = "both") -> Floats:
        """Return how strongly each point belongs to a place: 1 there, fading to 0."""
        upper_face = place.startswith("brow")
        size = self.brow_size if upper_face else self.mouth_size
        offset = (self.points - self.places[place]) * [1, 1, 0.6] / (radius * size)
        near = np.exp(-(offset**2).sum(axis=1))
        lip = {"both": 1.0, "upper": _smooth(self.above), "lower": _smooth(-self.above)}[side]
        return np.asarray(near * lip)

    def pushed(self, pushes: Iterable[Push]) -> Floats:
        """Return the displacement of the skin under pushes on the left, kept clear of the eyeballs."""
        delta = np.zeros_like(self.points)
        for push in pushes:
            size = self.brow_size if push.place.startswith("brow") else self.mouth_size
            weight = self.skin * self.weight(push.place, push.radius, push.side)
            delta += size * weight[:, None] * np.array(push.move)
        for side in (1, -1):
            delta = self._clear_of_eye(delta, np.multiply(self.measures.eye.centre, [side, 1, 1]))
        return delta

    def _clear_of_eye(self, delta: Floats, centre: Floats) -> Floats:
        """Slide skin that would enter the eyeball along it instead."""
        out = self.points - centre
        rest = np.linalg.norm(out, axis=1, keepdims=True)
        moved = out + delta
        length = np.linalg.norm(moved, axis=1, keepdims=True)
        shell = np.minimum(rest, self.measures.eye.radius + self.measures.eye.clearance + 0.3)
        outside = moved * np.maximum(shell / np.maximum(length, 1e-9), 1) - out
        return np.where(self.skin[:, None] * (rest < 2 * self.measures.eye.radius) > 0, outside, delta)

    def jaw(self) -> dict[str, Floats]:
        """Return the shapes that move the jaw; the lower teeth go with it rigidly."""
        m, p = self.measures, self.points
        weight = _smooth((1 - self.above) / 2) * _smooth((p[:, 2] - m.hinge[1] + 2) / 5)
        chin = self.places["chin"][1]
        weight *= self.skin * _smooth((p[:, 1] - m.neck) / (chin - m.neck) * 1.05)
        weight[self.head.groups["teeth_lower"]] = 1
        opened = _turned(p - [0, *m.hinge], 0, JAW_TURN) * weight[:, None]
        near_lips = np.exp(-((_off_slit(m, p) / (1.3 * self.mouth_size)) ** 4)) * self.skin
        return {
            "jawOpen": opened,
            "jawForward": weight[:, None] * np.array([0, -0.05, 0.6]),
            "jawLeft": weight[:, None] * np.array([0.7, 0, 0]),
            "jawRight": weight[:, None] * np.array([-0.7, 0, 0]),
            "mouthClose": -opened * near_lips[:, None],
        }

    def lids(self, upper: float, lower: float) -> Floats:
        """Return the displacement of the left lids that goes this far towards closing."""
        turn = self.head.lid * np.where(self.head.lid > 0, upper, lower) * (self.points[:, 0] > 0)
        return _turned(self.points - self.measures.eye.centre, 0, turn)

    def gaze(self, way: str) -> Floats:
        """Return the displacement of the left eyeball that looks this way."""
        ball = np.zeros(len(self.points))
        ball[self.head.groups["eye_left"]] = GAZE[way]
        axis, sign = {"Up": (0, -1), "Down": (0, 1), "In": (1, -1), "Out": (1, 1)}[way]
        return _turned(self.points - self.measures.eye.centre, axis, sign * ball)


def _places(m: Measures) -> dict[str, Floats]:
    """Return the named places of the left side that pushes act on."""
    mouth, eye, wide = m.mouth, m.eye, m.mouth.half_width
    xy = {
        "corner": (wide, mouth.height + mouth.lift),
        "upper": (0.38 * wide, mouth.height + 0.5 * mouth.upper),
        "lower": (0.38 * wide, mouth.height - 0.5 * mouth.lower),
        "lips": (0.0, mouth.height),
        "cheek": (1.45 * wide, 0.64 * mouth.height + 0.36 * (eye.centre[1] - eye.lower)),
        "cheekbone": (eye.centre[0] + 0.3, eye.centre[1] - eye.lower - 1.6 * eye.half_width),
        "wing": m.places["wing"][:2],
        "chin": m.places["chin_tip"][:2],
        "brow_inner": m.brow[0],
        "brow_peak": m.brow[1],
        "brow_outer": m.brow[2],
    }
    return dict(zip(xy, front(m, np.array(list(xy.values()))), strict=True))


def _side_of_slit(m: Measures, points: Floats) -> Floats:
    """Return 1 above the mouth, -1 below it, and 0 at and beside its corners.

    This is the sine of the angular elliptic coordinate whose foci are the corners: it
    jumps across the slit and is smooth everywhere else, as the motion of lips is.
    """
    x, y = _about_slit(m, points)
    q = x * x + y * y - 1
    return np.asarray(np.sign(y) * np.sqrt(np.maximum((np.hypot(q, 2 * y) - q) / 2, 0)))


def _off_slit(m: Measures, points: Floats) -> Floats:
    """Return the distance from the slit in the front view [cm]."""
    x, y = _about_slit(m, points)
    return np.asarray(m.mouth.half_width * np.hypot(np.maximum(np.abs(x) - 1, 0), y))


def _about_slit(m: Measures, points: Floats) -> tuple[Floats, Floats]:
    x = points[:, 0] / m.mouth.half_width
    lift = m.mouth.lift * np.minimum(np.abs(x), 1) ** 4
    return x, (points[:, 1] - m.mouth.height - lift) / m.mouth.half_width


def _smooth(t: Floats) -> Floats:
    """Return 0 below 0, 1 above 1, and the cubic step between."""
    t = np.clip(t, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))


def _turned(points: Floats, axis: int, angle: Floats | float) -> Floats:
    """Return the displacement of points turned about the x- or y-axis through the origin."""
    a, b = ((1, 2), (2, 0))[axis]
    cosine, sine = np.cos(angle), np.sin(angle)
    delta = np.zeros_like(points)
    delta[:, a] = cosine * points[:, a] - sine * points[:, b] - points[:, a]
    delta[:, b] = sine * points[:, a] + cosine * points[:, b] - points[:, b]
    return delta
