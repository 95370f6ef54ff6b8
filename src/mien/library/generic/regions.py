"""Which region of the face each vertex belongs to."""

from __future__ import annotations

import numpy as np

from mien.core import Labels
from mien.core.arrays import Flags, Floats
from mien.library.generic.measures import Measures
from mien.library.modelling.half import Head

WHOLE = ("forehead", "nose", "upper_lip", "lower_lip", "chin", "jaw", "neck", "cranium", "mouth_interior")
SIDED = ("brow", "upper_lid", "lower_lid", "cheek", "ear", "eye")
PARTS = ("teeth_upper", "teeth_lower", "tongue")

REGIONS = (*WHOLE, *(f"{name}_{side}" for name in SIDED for side in ("left", "right")), *PARTS)
"""The labels, in a fixed order."""


def generic_regions(head: Head, measures: Measures) -> Labels:
    """Return one region per vertex; the borders follow the features that the measures place."""
    x, y, z = head.vertices.T
    name = np.full(len(x), "cranium", dtype="<U16")
    for region, where in _skin(measures, np.abs(x), y, z).items():
        name[where] = region
    name[head.groups["mouth"]] = "mouth_interior"
    for side in ("left", "right"):
        for group in ("ear", "eye", "brow"):
            name[head.groups.get(f"{group}_{side}", np.empty(0, np.int64))] = group
    for part in PARTS:
        name[head.groups.get(part, np.empty(0, np.int64))] = part
    sides = np.where(x >= 0, "_left", "_right")
    name = np.where(np.isin(name, SIDED), np.char.add(name, sides), name)
    return Labels(REGIONS, np.array([REGIONS.index(n) for n in name]))


def _skin(m: Measures, x: Floats, y: Floats, z: Floats) -> dict[str, Flags]:
    """Return where each region of the skin is, later ones over earlier ones."""
    eye, mouth, places = m.eye, m.mouth, m.places
    chin, gonion, base, wing = (places[n] for n in ("chin_tip", "gonion_left", "subnasale", "wing"))
    ear = m.hinge[1] - 1.5
    front = z > ear + 0.16 * np.maximum(y - eye.centre[1], 0) * (y > eye.centre[1])
    brow_line = np.interp(x, [b[0] for b in m.brow[:3]], [b[1] for b in m.brow[:3]])
    floor = np.interp(z, [ear - 3, gonion[2], chin[2]], [gonion[1] + 3, gonion[1] - 0.6, chin[1] - 1.2])
    level = mouth.height + mouth.lift
    corner = mouth.half_width + 0.35
    off_eye = np.hypot((x - eye.centre[0]) / (1.3 * eye.half_width), (y - eye.centre[1]) / (0.95 * eye.half_width))
    slit = mouth.height + mouth.lift * np.minimum(x / mouth.half_width, 1) ** 4
    chin_top = mouth.height - 1.35 * mouth.lower - 0.25
    bridge = np.interp(y, [base[1], wing[1] + 1, places["nasion"][1]], [wing[0] + 0.2, wing[0] + 0.1, 0.9])
    return {
        "forehead": front & (y > eye.centre[1] + 0.3) & (z > 0.35 * places["forehead_centre"][2]),
        "cheek": front & (y <= eye.centre[1] + 0.3) & (y > level - 0.2),
        "jaw": front & (y <= level - 0.2),
        "neck": (y < floor) | ((y < gonion[1] + 3) & (z <= ear)),
        "chin": (y <= chin_top) & (x < 0.9 * mouth.half_width) & (y >= floor - 0.3) & (z > 0.6 * chin[2]),
        "brow": front & (np.abs(y - brow_line) < 0.75) & (x > m.brow[0][0] - 0.5) & (x < m.brow[2][0] + 0.6),
        "upper_lid": (off_eye < 1) & (y >= eye.centre[1]) & (z > eye.centre[2]),
        "lower_lid": (off_eye < 1) & (y < eye.centre[1]) & (z > eye.centre[2]),
        "nose": (x < bridge) & (y <= places["nasion"][1] + 0.4) & (y > base[1] - 0.1) & (z > 0.7 * base[2]),
        "upper_lip": (x < corner) & (y >= slit) & (y <= base[1] - 0.1) & (z > 0.5 * base[2]),
        "lower_lip": (x < corner) & (y < slit) & (y > chin_top) & (z > 0.5 * base[2]),
    }
