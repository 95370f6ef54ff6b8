"""Where well-known optical marker sets sit, in the names of the facial landmarks.

A capture whose markers carry these names needs no landmark file of its own.  Only
markers that lie on a landmark are listed; the others follow from the warp.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

MARKER_SETS: dict[str, dict[str, str]] = {
    "animface-41": {
        "ibug_27": "NoseTop",
        "ibug_30": "NoseHead",
        "ibug_36": "Reye_Outside",
        "ibug_39": "Reye_Inside",
        "ibug_42": "Leye_Inside",
        "ibug_45": "Leye_Outside",
        "ibug_48": "Mouth_Rend",
        "ibug_51": "Mouth_Up",
        "ibug_54": "Mouth_Lend",
        "ibug_57": "Mouth_Down",
        "chin_tip": "Chin",
        "glabella": "Eyebrow_Center",
    },
}
"""Landmark → marker name, per set."""


def known_landmarks(markers: Sequence[str], landmarks: Sequence[str]) -> Mapping[str, str]:
    """Return landmark → marker for a capture whose markers are named in a known way.

    Markers named like landmarks stand for them.  Otherwise the marker set with the most
    markers present is taken; fewer than 6 is taken for chance, and nothing is returned.
    """
    same = {name: name for name in landmarks if name in markers}
    found = [{lm: m for lm, m in table.items() if m in markers and lm in landmarks} for table in MARKER_SETS.values()]
    best = max([same, *found], key=len)
    return best if len(best) >= 6 else {}
