"""The actor: a grown human, finer and of another build than the generic face."""

from __future__ import annotations

from collections.abc import Mapping

from mien.core import Rig
from mien.library.heads.clay import Turned
from mien.library.heads.cover import Cover
from mien.library.heads.eyes import Eye
from mien.library.heads.mouth import Around, Mouth, Within
from mien.library.heads.parts import brow, sweep, teeth
from mien.library.heads.pits import Pit
from mien.library.heads.plan import Neck, Plan, modelled
from mien.library.heads.unfold import Core
from mien.library.modelling.solids import Ball, Bar

ACTOR = Plan(
    name="actor",
    solids=(
        Ball((0, 3.4, -1.2), (7.3, 8.2, 9.3), 1),
        Ball((0, 3.6, 3.4), (5.9, 5.4, 5.2), 3.0),
        Ball((0, -3.6, 2.2), (5.6, 6.4, 6.2), 3.0),
        Bar((0.0, -7, -1.2), (0.0, -17, -3.4), (4.6, 5.3), 2.0),
        Ball((0, -8.6, 2.6), (3.6, 2.2, 4.2), 2.0),
        Bar((1.2, -10.1, 6.2), (4.6, -7.2, 0.6), (1.3, 1.2), 2.2),
        Bar((4.6, -7.2, 0.6), (5.6, -1.5, -1.0), (1.2, 0.9), 2.5),
        Ball((0, -10.1, 7.0), (1.7, 1.45, 1.5), 1.8),
        Ball((0, -6.6, 6.7), (2.9, 2.5, 2.1), 1.8),
        Ball((3.2, -4.4, 4.8), (2.1, 2.6, 2.5), 2.2),
        Turned((4.7, -2.0, 4.6), (1.8, 0.8, 1.1), 1.8, yaw=40, roll=12),
        Bar((0.9, 1.7, 7.8), (4.5, 1.9, 5.9), (0.9, 0.55), 1.5),
        Turned((3.05, 0.0, 9.2), (2.0, 1.2, 1.95), 1.2, carve=True),
        Bar((0, 1.3, 8.0), (0, -2.9, 9.6), (0.5, 0.66), 1.4),
        Ball((0, -3.2, 9.9), (0.78, 0.68, 0.78), 0.8),
        Ball((0.88, -3.5, 9.0), (0.62, 0.62, 0.95), 0.9),
        Ball((3.2, 0, 6.0), (1.66, 1.66, 1.66), 0.5),
    ),
    eye=Eye(
        centre=(3.2, 0.0, 6.0), radius=1.5, half_width=1.42, upper=0.5, lower=0.4, tilt=0.09, iris=0.62, points=36
    ),
    mouth=Mouth(
        line=((0, -6.8, 9), (1.3, -6.78, 8.8), (2.5, -6.72, 8)),
        facing=(0, 4, 10),
        lips=(Around(0.04, 0.1, 0.14, 0.16), Around(0.1, 0.34, 0.46, 0.36), Around(0.18, 0.62, 0.86, 0.12)),
        around=(Around(0.36, 0.92, 1.2), Around(0.75, 1.4, 1.7)),
        pocket=(
            Within(0.9, 0.2, 0.9, 0.9),
            Within(0.75, 1.4, 1.9, 1.9),
            Within(0.4, 1.2, 1.9, 1.9),
            Within(0.1, 0.3, 1.3, 1.3),
            Within(0.04, 0.1, 0.3, 0.3),
            Within(0.015, 0.02, 0.05, 0.05),
        ),
        throat=(0, -6.8, 1.5),
        points=33,
        taper=1.2,
    ),
    pits=(Pit((0.5, -4.1, 9.3), 0.2, 0.34, 0.45, pitch=65, roll=-15, rim=0.12),),
    cover=Cover(Core((1.5, 5.2), (-8.5, -1.8)), edge=(0.5, 1.0)),
    neck=Neck((0, -14, -3), -12),
    places={
        "forehead_centre": (0, 6.0, 8.7),
        "glabella": (0, 2.3, 9.2),
        "ibug_27": (0, 0.9, 9.2),
        "ibug_28": (0, -0.5, 9.4),
        "ibug_29": (0, -1.8, 9.9),
        "ibug_30": (0, -3.1, 10.7),
        "ibug_33": (0, -4.45, 8.95),
        "ibug_34": (0.95, -4.5, 8.8),
        "ibug_35": (1.6, -3.7, 8.9),
        "ibug_22": (1.2, 1.75, 8.8),
        "ibug_23": (2.3, 2.1, 8.2),
        "ibug_24": (3.5, 2.25, 7.2),
        "ibug_25": (4.4, 2.1, 6.4),
        "ibug_26": (5.1, 1.6, 5.6),
        "zygion_left": (6.3, -1.8, 3.2),
        "cheek_left": (3.9, -4.0, 7.0),
        "gonion_left": (5.5, -7.6, 0.6),
        "chin_tip": (0, -10.3, 8.7),
        "ibug_8": (0, -11.7, 7.5),
    },
    parts=(
        sweep(
            "ear_left",
            (((7.0, 2.6, -1.2), 0.5, 0.3), ((7.7, 2.7, -1.9), 1.1, 0.34), ((8.0, 0.8, -2.0), 1.5, 0.36),
             ((7.6, -1.4, -1.5), 1.15, 0.34), ((7.1, -2.9, -0.9), 0.7, 0.3), ((6.8, -3.5, -0.6), 0.25, 0.2)),
            up=(0.85, 0.0, 0.5), rings=14, around=14, cup=0.3,
        ),
        brow((1.2, 1.75), (3.5, 2.35), (5.1, 1.6), 0.34, 0.16),
        teeth(2.5, 0.9, 7.7, 2.8, -6.8),
    ),
)  # fmt: skip

COLOURS: Mapping[str, tuple[float, float, float]] = {
    "face": (0.66, 0.42, 0.31),
    "ear": (0.66, 0.4, 0.3),
    "lips": (0.5, 0.22, 0.19),
    "mouth": (0.25, 0.06, 0.06),
    "nostril": (0.25, 0.11, 0.09),
    "teeth": (0.8, 0.76, 0.68),
    "brow": (0.09, 0.055, 0.035),
    "sclera": (0.82, 0.8, 0.77),
    "iris": (0.1, 0.06, 0.03),
    "pupil": (0.01, 0.01, 0.01),
}
"""Linear red, green and blue of the parts; where they overlap, the later one shows."""


def actor_head() -> Rig:
    """Make the actor's head: a bare mesh with landmarks."""
    return modelled(ACTOR, COLOURS)
