"""The tortoise: a blunt head with a beak, large dark eyes at the sides, and a neck in folds."""

from __future__ import annotations

from collections.abc import Mapping

from mien.core import Rig
from mien.library.heads.clay import Turned
from mien.library.heads.cover import Cover
from mien.library.heads.eyes import Eye
from mien.library.heads.mouth import Around, Mouth, Within
from mien.library.heads.parts import midline_sweep
from mien.library.heads.pits import Pit
from mien.library.heads.plan import Neck, Plan, modelled
from mien.library.heads.unfold import Core
from mien.library.modelling.solids import Ball, Bar

FOLDS = tuple(
    Turned((0, -3.2 - 1.15 * k, -4.4 - 2.2 * k), (4.6 + 0.2 * k, 4.6 + 0.2 * k, 1.05), 1.1, pitch=-28) for k in range(5)
)
"""The neck's folds, each a disc across it."""

TORTOISE = Plan(
    name="tortoise",
    solids=(
        Ball((0, 0.6, -1.0), (5.0, 4.3, 5.6), 1),
        Ball((0, -0.6, 4.4), (4.0, 3.3, 3.8), 3.0),
        Ball((0, -0.9, 6.6), (2.6, 2.7, 2.2), 1.6),
        Ball((0, -3.0, 3.8), (3.3, 1.8, 3.9), 2.0),
        Turned((3.1, 2.75, 3.2), (1.5, 0.5, 2.1), 1.0, yaw=25, roll=-22),
        Ball((3.2, 1.0, 3.6), (1.5, 1.5, 1.5), 1.0),
        Ball((3.9, -1.6, -0.6), (1.6, 1.9, 2.6), 1.6),
        Bar((0, -1.5, -2.5), (0, -8.5, -15.5), (3.9, 4.6), 2.0),
        *FOLDS,
    ),
    eye=Eye(
        centre=(3.2, 1.0, 3.6), radius=1.35, half_width=1.18, upper=0.62, lower=0.72, tilt=-0.1, iris=0.95,
        pupil=(0.6, 0.6), yaw=56, pitch=2, widths=(0.0, 0.1, 0.24, 0.46),
    ),
    mouth=Mouth(
        line=((0, -2.45, 10), (1.0, -2.15, 9.4), (2.3, -1.8, 7.4), (3.5, -1.7, 4.6), (4.2, -1.0, 1.8)),
        facing=(0, 30, 52, 72, 80),
        lips=(Around(0.05, 0.12, 0.12, 0.06), Around(0.16, 0.4, 0.34, 0.12)),
        around=(Around(0.5, 0.8, 0.75),),
        pocket=(
            Within(0.85, 0.0, 0.7, 0.7),
            Within(0.6, 0.0, 1.2, 1.0),
            Within(0.3, 0.0, 1.1, 0.9),
            Within(0.12, 0.0, 0.6, 0.6),
            Within(0.03, 0.05, 0.1, 0.1),
        ),
        throat=(0, -1.4, -0.5),
        points=41,
        taper=0.8,
    ),
    pits=(Pit((0.7, 0.3, 9.6), 0.2, 0.16, 0.3, yaw=18, pitch=-10, rim=0.14),),
    cover=Cover(Core((-0.8, 4.5), (-6.0, -10.5), radius=3.5), edge=(0.8, 0.9), depths=(-8, 3)),
    neck=Neck((0, -7.6, -13.6), -62),
    places={
        "forehead_centre": (0, 4.2, 2.4),
        "glabella": (0, 2.8, 5.4),
        "ibug_27": (0, 1.9, 7.6),
        "ibug_28": (0, 1.3, 8.2),
        "ibug_30": (0, -0.5, 9.0),
        "ibug_33": (0, -1.4, 9.0),
        "ibug_22": (1.2, 2.8, 5.4),
        "ibug_24": (2.8, 2.9, 4.0),
        "ibug_26": (4.3, 2.4, 2.0),
        "zygion_left": (5.0, -0.2, -0.4),
        "cheek_left": (4.9, -0.1, 1.3),
        "gonion_left": (4.7, -3.0, -1.6),
        "chin_tip": (0, -4.0, 7.8),
        "ibug_8": (0, -4.7, 6.0),
    },
    parts=(
        midline_sweep(
            "tongue",
            (((0, -2.6, 1.0), 1.6, 0.5), ((0, -2.5, 4.0), 1.5, 0.45), ((0, -2.4, 6.4), 1.0, 0.35), ((0, -2.35, 7.4), 0.2, 0.1)),
        ),
    ),
)  # fmt: skip

COLOURS: Mapping[str, tuple[float, float, float]] = {
    "face": (0.3, 0.32, 0.16),
    "lips": (0.42, 0.36, 0.16),
    "mouth": (0.45, 0.14, 0.14),
    "nostril": (0.04, 0.04, 0.03),
    "tongue": (0.6, 0.25, 0.24),
    "sclera": (0.12, 0.1, 0.05),
    "iris": (0.1, 0.05, 0.02),
    "pupil": (0.005, 0.005, 0.005),
}
"""Linear red, green and blue of the parts; where they overlap, the later one shows."""


def tortoise_head() -> Rig:
    """Make the tortoise's head: a bare mesh with landmarks."""
    return modelled(TORTOISE, COLOURS)
