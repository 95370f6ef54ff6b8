"""The one table from action units to controls of the generic rig.

Rows tell the subject's left, or the whole face; the right is the mirror image.  Values
are for the strongest contraction; lengths are metres of the generic face.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from mien.core.anatomy import Controls
from mien.vocabularies.facs import parsed_code

ACTIONS: Final[dict[str, Controls]] = {
    "1": {"frontalis_medial_left": 1.0},
    "2": {"frontalis_lateral_left": 1.0},
    "4": {
        "corrugator_left": 1.0,
        "brow_inner_left.ty": -0.001,
        "brow_inner_left.tz": 0.001,
        "brow_middle_left.ty": -0.004,
    },
    "5": {"levator_palpebrae_left": 1.0, "orbicularis_oculi_lower_left": -0.12},
    "6": {
        "orbicularis_oculi_orbital_left": 0.4,
        "orbicularis_oculi_lower_left": 0.4,
        "malar_left.ty": 0.005,
        "infraorbital_left.ty": 0.002,
        "cheek_left.ty": 0.002,
    },
    "7": {
        "orbicularis_oculi_lower_left": 0.9,
        "infraorbital_left.tx": -0.001,
        "infraorbital_left.ty": 0.0025,
        "malar_left.ty": 0.0015,
    },
    "8": {"lips_together": 1.0},
    "9": {
        "levator_nasi_left": 0.55,
        "levator_labii_left": 0.5,
        "cheek_left.ty": 0.002,
        "cheekbone_left.ty": 0.002,
        "cheekbone_left.tx": -0.0015,
        "orbicularis_oculi_orbital_left": 0.35,
        "brow_inner_left.tx": -0.001,
        "brow_inner_left.ty": -0.003,
        "brow_middle_left.ty": -0.002,
    },
    "10": {
        "levator_labii_left": 1.0,
        "lip_upper_left.ty": 0.002,
        "nose_wing_left.ty": 0.002,
        "cheek_left.ty": 0.001,
        "cheek_left.tz": 0.001,
    },
    "12": {
        "zygomaticus_major_left": 1.0,
        "risorius_left": 0.25,
        "lip_corner_left.tx": 0.002,
        "lip_corner_left.ty": 0.003,
        "lip_corner_left.tz": -0.001,
        "mouth.ty": 0.0016,
        "malar_left.ty": 0.002,
        "cheek_left.tz": 0.0035,
    },
    "14": {
        "lip_corner_left.tz": -0.004,
        "risorius_left": 0.45,
        "zygomaticus_major_left": 0.2,
    },
    "15": {"triangularis_left": 1.0, "lip_corner_left.tz": 0.002},
    "16": {"depressor_labii_left": 1.0},
    "17": {"mentalis_left": 1.0, "lip_lower_left.ty": 0.0025, "lip_lower_left.tz": 0.0035},
    "18": {
        "orbicularis_oris_left": 1.0,
        "lip_upper_left.tz": 0.0045,
        "lip_lower_left.tz": 0.0045,
        "lip_corner_left.tz": 0.002,
    },
    "19": {"tongue.tz": 0.032, "tongue.ty": 0.014},
    "20": {"risorius_left": 1.0, "triangularis_left": 0.25},
    "22": {
        "orbicularis_oris_left": 0.6,
        "lip_upper_left.ty": 0.0035,
        "lip_upper_left.tz": 0.005,
        "lip_upper_left.rx": -0.35,
        "lip_lower_left.ty": -0.0035,
        "lip_lower_left.tz": 0.005,
        "lip_lower_left.rx": 0.35,
    },
    "23": {"orbicularis_oris_marginal_left": 0.7, "orbicularis_oris_left": 0.12},
    "24": {"orbicularis_oris_marginal_left": 0.8, "lip_upper_left.tz": -0.001, "lip_lower_left.tz": -0.001},
    "25": {"depressor_labii_left": 0.45, "levator_labii_left": 0.2},
    "26": {"jaw.rx": 0.17},
    "27": {"jaw.rx": 0.36, "orbicularis_oris_left": 0.15},
    "T28": {"lip_upper_left.rx": 0.8, "lip_upper_left.ty": -0.002, "lip_upper_left.tz": -0.005},
    "B28": {"lip_lower_left.rx": -0.7, "lip_lower_left.ty": 0.001, "lip_lower_left.tz": -0.003},
    "29": {"jaw.tz": 0.009},
    "30": {"jaw.tx": 0.007},
    "32": {"lip_lower_left.ty": 0.003, "lip_lower_left.tz": -0.005, "lip_lower_left.rx": -0.3},
    "34": {
        "buccal_left.tx": -0.003,
        "buccal_left.tz": 0.011,
        "lip_corner_left.tx": -0.0025,
        "lip_upper_left.tz": 0.003,
        "lip_lower_left.tz": 0.004,
    },
    "38": {"nose_wing_left.tx": 0.002},
    "43": {"orbicularis_oculi_upper_left": 1.0, "orbicularis_oculi_lower_left": 1.0},
    "45": {"orbicularis_oculi_upper_left": 1.0, "orbicularis_oculi_lower_left": 1.0},
    "61": {"eye_left.ry": 0.56},
    "62": {"eye_left.ry": -0.56},
    "63": {"eye_left.rx": -0.42, "levator_palpebrae_left": 0.7, "orbicularis_oculi_lower_left": 0.1},
    "64": {"eye_left.rx": 0.42, "orbicularis_oculi_upper_left": 0.5, "orbicularis_oculi_lower_left": -0.4},
    "101": {"mouth.tx": 0.011, "mouth.ty": 0.001},
    "103": {"tongue.ty": 0.012, "tongue.rx": -0.1},
    "102": {"lip_upper_left.ty": 0.003, "lip_upper_left.tz": 0.0025, "nose_wing_left.ty": 0.0005},
}
"""Controls at full strength, by action unit."""

TURNED: Final[dict[str, str]] = {"61": "62", "62": "61"}
"""Both eyes turn the same way: what is outwards for one is inwards for the other."""

FLIPPED: Final = (".tx", ".ry", ".rz")
"""Motions that change sign in a mirror."""


def controls_for(units: Mapping[str, float], *, tongue: bool = True) -> dict[str, float]:
    """Return the controls of action units at these intensities, 0 to 1.

    Args:
        units: intensity by code: `12` for both sides, `L12` for the subject's left.
        tongue: whether the rig has a tongue to control.

    Raises:
        InputError: no such action unit.
    """
    total: dict[str, float] = {}
    for code, intensity in units.items():
        for control, value in _row(code).items():
            if tongue or not control.startswith("tongue"):
                total[control] = total.get(control, 0.0) + intensity * value
    return total


def mirrored_control(control: str, value: float) -> tuple[str, float]:
    """Return the control that does on the other side what this one does here."""
    name, dot, axis = control.partition(".")
    stem, _, side = name.rpartition("_")
    name = f"{stem}_{ {'left': 'right', 'right': 'left'}[side] }" if side in ("left", "right") else name
    return name + dot + axis, -value if (dot + axis) in FLIPPED else value


def _row(code: str) -> Controls:
    side, unit = parsed_code(code)
    left = ACTIONS[unit]
    right = dict(mirrored_control(*item) for item in ACTIONS[TURNED.get(unit, unit)].items())
    return {"L": left, "R": right, "": {**right, **left}}[side]
