"""The goat: a long muzzle, eyes to the sides with slots for pupils, horns, ears and a beard."""

from __future__ import annotations

from collections.abc import Mapping

from mien.core import Rig
from mien.library.heads.clay import Turned
from mien.library.heads.cover import Cover
from mien.library.heads.eyes import Eye
from mien.library.heads.mouth import Around, Mouth, Within
from mien.library.heads.parts import midline_sweep, sweep
from mien.library.heads.pits import Pit
from mien.library.heads.plan import Neck, Plan, modelled
from mien.library.heads.unfold import Core
from mien.library.modelling.solids import Ball, Bar

GOAT = Plan(
    name="goat",
    solids=(
        Ball((0, 3.2, -1.5), (4.9, 5.2, 6.0), 1),
        Turned((0, 3.0, 2.6), (4.2, 4.4, 4.6), 2.5, pitch=25),
        Turned((0, -1.2, 8.2), (2.7, 3.2, 7.4), 3.0, pitch=30),
        Ball((0, -4.5, 13.2), (2.45, 2.4, 2.7), 2.0),
        Ball((0, -6.6, 12.0), (2.1, 1.5, 2.6), 1.6),
        Bar((0, -6.6, 11.0), (1.6, -3.4, 1.0), (1.6, 2.2), 2.5),
        Turned((2.6, -1.6, 3.0), (2.0, 3.6, 3.6), 2.5, pitch=25),
        Bar((0, -1, -2.5), (0, -13, -7.5), (4.6, 5.6), 3.0),
        Ball((3.6, 2.4, 3.7), (1.93, 1.93, 1.93), 1.2),
        Turned((3.7, 4.1, 3.9), (1.6, 0.55, 1.9), 1.2, yaw=20, roll=-20),
    ),
    eye=Eye(
        centre=(3.6, 2.4, 3.7), radius=1.75, half_width=1.55, upper=0.85, lower=0.75, tilt=-0.15, iris=1.25,
        pupil=(0.78, 0.3), yaw=50, pitch=4, widths=(0.0, 0.1, 0.24, 0.45, 0.75),
    ),
    mouth=Mouth(
        line=((0, -5.9, 15), (1.4, -5.75, 14.6), (2.5, -5.2, 12.6), (2.9, -4.6, 10), (3.0, -4.2, 8.4)),
        facing=(0, 32, 66, 80, 84),
        lips=(Around(0.05, 0.12, 0.12, 0.05), Around(0.14, 0.34, 0.34, 0.1)),
        around=(Around(0.4, 0.75, 0.7), Around(0.9, 1.35, 1.2)),
        pocket=(
            Within(0.85, 0.0, 0.7, 0.7),
            Within(0.6, 0.0, 1.2, 1.0),
            Within(0.3, 0.0, 1.0, 0.8),
            Within(0.12, 0.0, 0.6, 0.5),
            Within(0.03, 0.05, 0.1, 0.1),
        ),
        throat=(0, -4.2, 5.5),
        points=41,
        taper=0.9,
    ),
    pits=(Pit((1.25, -3.3, 15.0), 0.62, 0.24, 0.6, yaw=38, pitch=5, roll=38, bend=0.3),),
    cover=Cover(Core((-4.4, 11.5), (-3.2, -4.2), radius=3.5), edge=(0.95, 1.4)),
    neck=Neck((0, -8.5, -5.6), -22),
    places={
        "forehead_centre": (0, 6.6, 5.2),
        "glabella": (0, 4.4, 7.1),
        "ibug_27": (0, 2.6, 8.5),
        "ibug_28": (0, 1.0, 10.7),
        "ibug_29": (0, -0.8, 13.1),
        "ibug_30": (0, -3.0, 15.6),
        "ibug_33": (0, -4.3, 16.0),
        "ibug_35": (2.3, -3.2, 13.6),
        "ibug_22": (1.4, 4.6, 6.4),
        "ibug_24": (3.4, 5.0, 4.4),
        "ibug_26": (5.2, 4.4, 1.6),
        "zygion_left": (4.7, -0.2, 2.6),
        "cheek_left": (3.4, -2.6, 6.2),
        "gonion_left": (3.9, -5.2, -0.6),
        "chin_tip": (0, -7.6, 14.3),
        "ibug_8": (0, -9.1, 11.6),
    },
    parts=(
        sweep(
            "horn_left",
            (((1.5, 6.6, 0.8), 1.6, 1.3), ((2.0, 10.0, -0.6), 1.4, 1.15), ((3.0, 13.2, -3.8), 1.1, 0.9),
             ((4.4, 14.4, -8.0), 0.7, 0.6), ((5.8, 13.2, -11.6), 0.1, 0.1)),
            up=(1, 0.2, 0.2), rings=40, around=12, ripple=(0.05, 11),
        ),
        sweep(
            "ear_left",
            (((3.6, 4.6, -2.2), 0.7, 0.5), ((5.6, 4.5, -2.4), 1.35, 0.35), ((8.4, 3.4, -2.4), 1.6, 0.25),
             ((10.8, 1.6, -2.0), 0.9, 0.18), ((11.9, 0.4, -1.8), 0.1, 0.08)),
            up=(0.15, 0.5, 1), rings=12, around=12, cup=0.35,
        ),
        midline_sweep(
            "beard_front",
            (((0, -7.4, 11.6), 1.0, 1.1), ((0, -10.0, 11.4), 0.95, 1.0), ((0, -12.4, 10.4), 0.6, 0.6),
             ((0, -14.2, 8.9), 0.06, 0.06)),
            up=(0, 0, 1),
        ),
        sweep(
            "beard_left",
            (((0.7, -7.4, 10.0), 0.9, 1.1), ((0.95, -9.6, 9.7), 0.85, 1.0), ((0.9, -11.6, 8.7), 0.5, 0.6),
             ((0.6, -13.0, 7.2), 0.06, 0.06)),
            up=(0, 0, 1), rings=8,
        ),
    ),
)  # fmt: skip


COLOURS: Mapping[str, tuple[float, float, float]] = {
    "face": (0.55, 0.43, 0.31),
    "lips": (0.35, 0.24, 0.2),
    "mouth": (0.3, 0.08, 0.08),
    "nostril": (0.08, 0.05, 0.05),
    "horn": (0.16, 0.13, 0.1),
    "ear": (0.5, 0.38, 0.28),
    "beard": (0.42, 0.31, 0.21),
    "sclera": (0.3, 0.18, 0.06),
    "iris": (0.55, 0.3, 0.05),
    "pupil": (0.01, 0.01, 0.01),
}
"""Linear red, green and blue of the parts; where they overlap, the later one shows."""


def goat_head() -> Rig:
    """Make the goat's head: a bare mesh with landmarks."""
    return modelled(GOAT, COLOURS)
