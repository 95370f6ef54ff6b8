"""Where the 44 anthropometric landmarks of a modelled head are."""

from __future__ import annotations

import numpy as np

from mien.core import InputError, SurfacePoints
from mien.core.arrays import Flags, Floats, Ints
from mien.library.generic.measures import Measures, front
from mien.library.modelling.half import Head
from mien.vocabularies.anthropometry import LANDMARKS

EYE_THIRDS = (
    "exocanthion",
    "palpebrale_superius_lateral",
    "palpebrale_superius_medial",
    "endocanthion",
    "palpebrale_inferius_medial",
    "palpebrale_inferius_lateral",
)
"""The points of the lids' edge, every sixth of the way around from the outer corner upwards."""


def generic_landmarks(head: Head, measures: Measures) -> dict[str, SurfacePoints]:
    """Return the 44 landmarks as surface points at vertices, the right ones mirror images of the left.

    Raises:
        InputError: the head is too coarse to give each landmark a vertex of its own.
    """
    chosen = _Chosen(head)
    _lips(chosen)
    _eye_and_brow(chosen, measures)
    _nose_and_bones(chosen, measures)
    found = chosen.vertices
    found |= {f"{name[:-5]}_right": int(head.mirror[v]) for name, v in found.items() if name.endswith("_left")}
    return {name: SurfacePoints.at_vertices(np.array([found[name]])) for name in LANDMARKS}


class _Chosen:
    """Vertices of the left half and the midline that landmarks have taken."""

    def __init__(self, head: Head) -> None:
        self.head, self.vertices = head, dict[str, int]()
        outside = np.setdiff1d(head.groups["face"], head.groups["mouth"])
        self.skin = outside[head.vertices[outside, 0] >= 0]

    def farthest(self, name: str, group: str, direction: tuple[float, float, float], *, midline: bool = False) -> None:
        """Take the vertex of a group that lies farthest in a direction."""
        ids = self._free(np.intersect1d(self.head.groups[group], self.skin), name, midline=midline)
        self.vertices[name] = int(ids[np.argmax(self.head.vertices[ids] @ np.array(direction))])

    def nearest(self, name: str, point: Floats) -> None:
        """Take the vertex of the skin nearest to a point."""
        ids = self._free(self.skin, name, midline=not name.endswith("_left"))
        self.vertices[name] = int(ids[np.argmin(np.linalg.norm(self.head.vertices[ids] - point, axis=1))])

    def _free(self, ids: Ints, name: str, *, midline: bool) -> Ints:
        on_midline: Flags = self.head.vertices[ids, 0] == 0
        free = np.setdiff1d(ids[on_midline == midline], list(self.vertices.values()))
        if not len(free):
            raise InputError(f"the head has no vertex left for landmark {name!r}; model it with a finer grid.")
        return free


def _lips(chosen: _Chosen) -> None:
    chosen.farthest("labiale_superius", "upper_lip", (0, 1, 0), midline=True)
    chosen.farthest("stomion_superius", "upper_lip", (0, -1, 0), midline=True)
    chosen.farthest("stomion_inferius", "lower_lip", (0, 1, 0), midline=True)
    chosen.farthest("labiale_inferius", "lower_lip", (0, -1, 0), midline=True)
    chosen.farthest("crista_philtri_left", "upper_lip", (0, 1, 0))
    chosen.farthest("cheilion_left", "lip_corner_left", (1, 0, 0))


def _eye_and_brow(chosen: _Chosen, m: Measures) -> None:
    for name, point in zip(EYE_THIRDS, m.eye.rim(np.arange(6) * np.pi / 3), strict=True):
        chosen.nearest(f"{name}_left", point)
    for name, point in zip(("_medial", "", "_lateral"), front(m, np.array(m.brow[:3])), strict=True):
        chosen.nearest(f"superciliare{name}_left", point)


def _nose_and_bones(chosen: _Chosen, m: Measures) -> None:
    places = {name: np.array(place) for name, place in m.places.items()}
    root, tip, base, wing, chin = (places[n] for n in ("nasion", "nose_tip", "subnasale", "wing", "chin_tip"))
    targets = {
        "pronasale": tip,
        "subnasale": base,
        "nasion": root,
        "rhinion": front(m, (0.6 * root + 0.4 * tip)[None, :2])[0],
        "glabella": places["glabella"],
        "metopion": places["forehead_centre"],
        "pogonion": chin,
        "gnathion": chin + 0.12 * abs(chin[1] - m.mouth.height) * np.array([0.0, -2.0, -1.0]),
        "alare_left": wing,
        "subalare_left": base + 0.4 * (wing - base) * [1, 0.3, 0.3],
        "zygion_left": places["zygion_left"],
        "cheek_left": places["cheek_left"],
        "gonion_left": places["gonion_left"],
    }
    for name, point in targets.items():
        chosen.nearest(name, point)
