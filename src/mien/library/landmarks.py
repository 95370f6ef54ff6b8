"""Where the landmarks of a modelled head are: iBUG's 17 to 67, and nine on the bones and soft parts."""

from __future__ import annotations

import numpy as np

from mien.core import SurfacePoints
from mien.core.arrays import Floats
from mien.library.generic.measures import Measures, front
from mien.library.modelling.half import Head

EYE = (42, 43, 44, 45, 46, 47)
"""Inner corner, two on the upper lid, outer corner, two on the lower lid."""

MIRRORED = (
    {22 + i: 21 - i for i in range(5)}
    | {34: 32, 35: 31, 42: 39, 43: 38, 44: 37, 45: 36, 46: 41, 47: 40}
    | {52: 50, 53: 49, 54: 48, 55: 59, 56: 58, 63: 61, 64: 60, 65: 67}
)
"""The number on the subject's right of each number on the left."""


def landmarks(measures: Measures, head: Head) -> dict[str, SurfacePoints]:
    """Return the landmarks as surface points at the vertices nearest to where they belong."""
    left = _nose_and_brow(measures, head) | _eye(measures, head) | _mouth(measures, head)
    chosen = {f"ibug_{n}": vertex for n, vertex in left.items()}
    chosen |= {f"ibug_{MIRRORED[n]}": int(head.mirror[v]) for n, v in left.items() if n in MIRRORED}
    for name in ("chin_tip", "glabella", "gonion_left", "zygion_left", "cheek_left", "forehead_centre"):
        vertex = _nearest(head, np.array(measures.places[name]))
        chosen[name] = vertex
        if name.endswith("_left"):
            chosen[name[:-4] + "right"] = int(head.mirror[vertex])
    return {name: SurfacePoints.at_vertices(np.array([vertex])) for name, vertex in sorted(chosen.items())}


def _nose_and_brow(m: Measures, head: Head) -> dict[int, int]:
    nasion, tip, base, wing = (np.array(m.places[name]) for name in ("nasion", "nose_tip", "subnasale", "wing"))
    bridge = front(m, nasion[:2] + np.linspace(0, 1, 4)[:, None] * (tip - nasion)[:2])
    found = {27 + i: _nearest(head, point, midline=True) for i, point in enumerate(bridge)}
    found |= {33: _nearest(head, base, midline=True), 34: _nearest(head, 0.5 * (base + wing)), 35: _nearest(head, wing)}
    x = np.interp(np.arange(5), [0, 2, 4], [end[0] for end in m.brow[:3]])
    y = np.interp(np.arange(5), [0, 2, 4], [end[1] for end in m.brow[:3]])
    skin = front(m, np.column_stack([x, y]))
    return found | {22 + i: _nearest(head, point) for i, point in enumerate(skin)}


def _eye(m: Measures, head: Head) -> dict[int, int]:
    edge = front(m, m.eye.edge(np.pi - np.arange(6) * np.pi / 3))
    return {number: _nearest(head, point) for number, point in zip(EYE, edge, strict=True)}


def _mouth(m: Measures, head: Head) -> dict[int, int]:
    outer, inner = m.mouth.half_width + 0.2, m.mouth.half_width
    up, low = m.mouth.upper, -m.mouth.lower
    # number: half width and height of the ring it lies on, and its angle there in degrees
    rows: dict[str, dict[int, tuple[float, float, float]]] = {
        "upper_lip": {
            51: (outer, up, 90),
            52: (outer, up, 60),
            53: (outer, up, 32),
            62: (inner, 0, 90),
            63: (inner, 0, 52),
        },
        "lower_lip": {
            57: (outer, low, 90),
            56: (outer, low, 60),
            55: (outer, low, 32),
            66: (inner, 0, 90),
            65: (inner, 0, 52),
        },
        "lip_corner_left": {54: (outer, 0, 0), 64: (inner, 0, 0)},
    }
    rings = np.array([ring for row in rows.values() for ring in row.values()])
    sine, cosine = np.sin(np.radians(rings[:, 2])), np.cos(np.radians(rings[:, 2]))
    height = m.mouth.height + m.mouth.lift * cosine**4 + rings[:, 1] * sine**1.25
    points = iter(front(m, np.stack([np.abs(rings[:, 0] * cosine), height], axis=1)))
    return {
        number: _nearest(head, next(points), group, midline=ring[2] == 90)
        for group, row in rows.items()
        for number, ring in row.items()
    }


def _nearest(head: Head, point: Floats, group: str = "face", *, midline: bool = False) -> int:
    """Return the vertex of a group nearest to a point on the left or, if asked, on the midline."""
    ids = head.groups[group]
    if group == "face":
        ids = np.setdiff1d(ids, head.groups["mouth"])
    x = head.vertices[ids, 0]
    ids = ids[x == 0] if midline else ids[x >= 0]
    return int(ids[np.argmin(np.linalg.norm(head.vertices[ids] - point, axis=1))])
