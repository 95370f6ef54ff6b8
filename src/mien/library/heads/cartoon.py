"""The cartoon: large eyes, a small chin and a wide mouth on a round head."""

from __future__ import annotations

from collections.abc import Mapping

from mien.core import Rig
from mien.library.heads.clay import Turned
from mien.library.heads.cover import Cover
from mien.library.heads.eyes import Eye
from mien.library.heads.mouth import Around, Mouth, Within
from mien.library.heads.parts import brow, midline_sweep, sweep, teeth
from mien.library.heads.pits import Pit
from mien.library.heads.plan import Neck, Plan, modelled
from mien.library.heads.unfold import Core
from mien.library.modelling.solids import Ball, Bar

CARTOON = Plan(
    name="cartoon",
    solids=(
        Ball((0, 4.2, -1.0), (9.4, 9.0, 9.2), 1),
        Ball((0, -3.2, 2.0), (6.6, 5.4, 6.0), 3.5),
        Bar((0.0, -6, -1.2), (0.0, -16, -2.8), (2.7, 3.2), 2.0),
        Ball((0, -7.0, 5.6), (1.9, 1.5, 1.9), 2.2),
        Ball((0, -4.4, 5.6), (3.9, 2.4, 2.7), 2.4),
        Ball((4.6, -2.8, 4.6), (2.3, 2.2, 2.4), 2.4),
        Ball((3.6, 1.6, 10.0), (3.0, 3.0, 2.0), 1.5, carve=True),
        Bar((0, 1.0, 7.6), (0, -1.2, 8.9), (0.5, 0.7), 1.4),
        Turned((0, -1.35, 9.25), (1.0, 0.8, 1.15), 0.9, pitch=-18),
        Ball((3.5, 1.5, 5.5), (3.06, 3.06, 3.06), 0.7),
    ),
    eye=Eye(
        centre=(3.5, 1.5, 5.5), radius=2.75, half_width=2.3, upper=1.75, lower=1.5, tilt=0.25, iris=1.55,
        pupil=(0.5, 0.5), clearance=0.12, points=36, yaw=6, widths=(0.0, 0.05, 0.13, 0.26, 0.42),
    ),
    mouth=Mouth(
        line=((0, -4.9, 9), (1.6, -4.8, 8.7), (2.7, -4.45, 8), (3.3, -3.95, 7.2)),
        facing=(0, 8, 18, 24),
        lips=(Around(0.05, 0.1, 0.12, 0.14), Around(0.12, 0.3, 0.36, 0.26), Around(0.2, 0.5, 0.64, 0.1)),
        around=(Around(0.45, 0.85, 1.0), Around(0.9, 1.3, 1.5)),
        pocket=(
            Within(0.9, 0.2, 0.9, 0.9),
            Within(0.7, 1.2, 1.6, 1.5),
            Within(0.35, 1.0, 1.6, 1.5),
            Within(0.1, 0.3, 1.1, 1.0),
            Within(0.04, 0.1, 0.3, 0.3),
            Within(0.015, 0.02, 0.05, 0.05),
        ),
        throat=(0, -4.8, 1.5),
        points=29,
        taper=1.2,
    ),
    pits=(Pit((0.4, -2.0, 9.3), 0.16, 0.2, 0.25, pitch=60, roll=-15, rim=0.12),),
    cover=Cover(Core((2.5, 2.5), (-7.0, -1.4)), edge=(0.95, 1.7)),
    neck=Neck((0, -11.5, -2.6), -8),
    places={
        "forehead_centre": (0, 9.0, 6.8),
        "glabella": (0, 5.0, 8.2),
        "ibug_27": (0, 2.0, 8.2),
        "ibug_28": (0, 1.0, 8.5),
        "ibug_29": (0, 0.0, 9.0),
        "ibug_30": (0, -1.2, 10.4),
        "ibug_33": (0, -2.6, 8.9),
        "ibug_34": (0.75, -2.5, 8.8),
        "ibug_35": (1.15, -1.7, 9.1),
        "ibug_22": (1.9, 5.7, 8.0),
        "ibug_23": (3.1, 6.3, 7.4),
        "ibug_24": (4.2, 6.4, 6.8),
        "ibug_25": (5.4, 6.1, 6.0),
        "ibug_26": (6.6, 5.3, 5.0),
        "zygion_left": (7.4, -1.4, 3.6),
        "cheek_left": (5.0, -2.4, 6.6),
        "gonion_left": (5.6, -6.0, 1.6),
        "chin_tip": (0, -7.3, 7.8),
        "ibug_8": (0, -8.6, 6.0),
    },
    parts=(
        sweep(
            "ear_left",
            (((8.6, 3.2, -1.0), 0.6, 0.4), ((9.6, 3.5, -1.4), 1.3, 0.45), ((10.2, 1.6, -1.5), 1.7, 0.45),
             ((9.4, -0.6, -1.0), 1.2, 0.4), ((8.2, -1.8, -0.4), 0.3, 0.3)),
            up=(0.8, 0.1, 0.6), rings=12, around=14, cup=0.32,
        ),
        brow((1.9, 5.7), (4.2, 6.6), (6.6, 5.3), 0.42, 0.3),
        midline_sweep(
            "hair_front",
            (((0, 12.0, 2.0), 3.2, 0.8), ((0, 13.6, 3.6), 2.2, 0.9), ((0, 14.6, 5.8), 1.1, 0.6), ((0, 14.2, 7.6), 0.15, 0.1)),
        ),
        sweep(
            "hair_left",
            (((2.4, 12.0, 1.2), 2.4, 0.9), ((3.6, 13.2, 2.4), 1.8, 0.8), ((4.8, 13.2, 3.8), 0.9, 0.5), ((5.6, 12.4, 4.8), 0.12, 0.1)),
        ),
        teeth(3.0, 0.9, 7.5, 2.2, -4.8),
    ),
)  # fmt: skip

COLOURS: Mapping[str, tuple[float, float, float]] = {
    "face": (0.75, 0.48, 0.34),
    "ear": (0.75, 0.46, 0.33),
    "lips": (0.62, 0.26, 0.22),
    "mouth": (0.3, 0.06, 0.06),
    "nostril": (0.3, 0.12, 0.09),
    "teeth": (0.85, 0.82, 0.75),
    "hair": (0.1, 0.05, 0.03),
    "brow": (0.1, 0.05, 0.03),
    "sclera": (0.85, 0.85, 0.83),
    "iris": (0.08, 0.3, 0.22),
    "pupil": (0.01, 0.01, 0.01),
}
"""Linear red, green and blue of the parts; where they overlap, the later one shows."""


def cartoon_head() -> Rig:
    """Make the cartoon's head: a bare mesh with landmarks."""
    return modelled(CARTOON, COLOURS)
