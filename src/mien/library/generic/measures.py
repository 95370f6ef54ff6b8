"""The measures that make one head, in centimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Floats
from mien.library.modelling.solids import Point, Solids, first_hit

LID_RINGS = (0.0, 0.07, 0.18, 0.36, 0.62)
"""Distance of the rings around an eye from the lid's edge, over the opening's half width."""


@dataclass(frozen=True)
class Eye:
    """The left eye [cm].

    Attributes:
        centre, radius: of the eyeball.
        half_width, upper, lower, tilt: the opening between the lids, and how much higher its outer corner stands.
        clearance: how far the lids' inner edge stands off the eyeball; they need it half way to closing.
        iris: radius of the iris.
        meet: where the lids meet: 0 at the centre's height, -0.5 at the lower lid.
        points: number of vertices around the opening, a multiple of six.
        crease: depth of the fold above the upper lid.
    """

    centre: Point
    radius: float
    half_width: float
    upper: float
    lower: float
    tilt: float
    clearance: float
    iris: float
    meet: float = -0.25
    points: int = 24
    crease: float = 0.0

    def edge(self, angles: Floats) -> Floats:
        """Return `(n, 2)` front-view positions of the lid's edge at these angles."""
        sine = np.sin(angles)
        height = np.where(sine > 0, self.upper, self.lower) * sine * np.abs(sine) ** 0.25
        x = self.centre[0] + self.half_width * np.cos(angles)
        return np.stack([x, self.centre[1] + self.tilt * np.cos(angles) + height], axis=1)

    def rim(self, angles: Floats) -> Floats:
        """Return `(n, 3)` positions of the lid's edge, standing clear of the eyeball."""
        edge = self.edge(angles)
        off = ((edge - np.array(self.centre[:2])) ** 2).sum(axis=1)
        return np.column_stack([edge, self.centre[2] + np.sqrt((self.radius + self.clearance) ** 2 - off)])

    def closing(self, angles: Floats) -> Floats:
        """Return by how much each point of the edge must turn down about the eye's x-axis to close it [rad]."""
        height = self.edge(angles)[:, 1] - self.centre[1]
        bow = np.where(self.meet < 0, self.lower, self.upper) * self.meet * 2
        closed = self.tilt * np.cos(angles) + bow * np.sin(angles) ** 2
        reach = np.sqrt((self.radius + self.clearance) ** 2 - (self.half_width * np.cos(angles)) ** 2)
        ajar = 0.008 * np.sign(np.round(np.sin(angles), 9)) / reach
        return np.asarray(np.arcsin(height / reach) - np.arcsin(closed / reach) - ajar)


@dataclass(frozen=True)
class Mouth:
    """The mouth [cm].

    Attributes:
        height: where the slit crosses the midline.
        half_width, lift: where its corners are, sideways and above the midline.
        upper, lower: height of the lips' red at the midline.
        fullness: how far they stand out.
        points: number of vertices around half the slit, odd.
        bow: how far the upper lip's border dips at the midline, over the height of its red (Cupid's bow).
        philtrum: depth of the groove between the upper lip and the nose.
    """

    height: float
    half_width: float
    lift: float
    upper: float
    lower: float
    fullness: float
    points: int = 25
    bow: float = 0.0
    philtrum: float = 0.0


@dataclass(frozen=True)
class Ear:
    """The left ear [cm].

    Attributes:
        centre: its middle in the side view, and how far out its front edge is attached.
        height, width: of the auricle.
        lean: how far its top leans back [rad].
        flare: by how much its plane turns out from the side of the head [rad].
        points: number of vertices around it.
    """

    centre: Point
    height: float
    width: float
    lean: float
    flare: float
    points: int = 18


@dataclass(frozen=True)
class Nostril:
    """The left nostril [cm].

    Attributes:
        centre: its middle on the underside of the nose, about.
        axis: the direction in which it faces.
        long, wide: its half-axes.
        yaw: how far its long axis turns outwards from straight back [rad].
        depth: how deep it goes.
        points: number of vertices around it.
    """

    centre: Point
    axis: Point
    long: float
    wide: float
    yaw: float
    depth: float
    points: int = 8


@dataclass(frozen=True)
class Measures:
    """Everything that makes one head.

    Attributes:
        solids: the lumps the skin is blended from.
        eye, mouth: the left eye, and the mouth.
        brow: inner end, peak and outer end of the left eyebrow in the front view, and its half height and thickness.
        teeth: half width, height, front and depth of the dental arch.
        centre: the point from which the skin is seen as star-shaped.
        hinge: height and depth of the jaw's axis.
        neck: height at which the neck is cut.
        places: positions of further landmarks on the left or the midline, to within a centimetre.
        spacing: distance between grid points in front and at the back [degrees].
        fine: places that need a finer grid: where, how far around [cm], and the spacing's share there.
        ear, nostril: modelled as rings of their own where given.
        tongue: centre and half-axes, where there is one.
    """

    solids: Solids
    eye: Eye
    mouth: Mouth
    brow: tuple[tuple[float, float], tuple[float, float], tuple[float, float], tuple[float, float]]
    teeth: tuple[float, float, float, float]
    centre: Point
    hinge: tuple[float, float]
    neck: float
    places: dict[str, Point]
    spacing: tuple[float, float]
    fine: tuple[tuple[Point, float, float], ...] = ()
    ear: Ear | None = None
    nostril: Nostril | None = None
    tongue: tuple[Point, Point] | None = None


def front(measures: Measures, xy: Floats) -> Floats:
    """Return the skin's points that are seen from the front at these `(n, 2)` positions."""
    origins = np.column_stack([xy, np.full(len(xy), 15.0)])
    return first_hit(measures.solids, origins, np.broadcast_to([0.0, 0.0, -1.0], origins.shape))
