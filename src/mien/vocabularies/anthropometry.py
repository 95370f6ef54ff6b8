"""The anthropometric landmarks of a generic rig, and what landmark files call the same points.

Farkas, *Anthropometry of the Head and Face* (1994), names points of the face by where
they lie on bone and soft tissue; landmark files number those that video trackers find
(iBUG 68, Sagonas et al. 2013).  Both kinds of file should serve for any face.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple


class Landmark(NamedTuple):
    """A named point of the face.

    Attributes:
        abbreviation: Farkas' short name, or that of the nearest usage.
        about: where it lies.
        other: what landmark files of the other vocabulary call it; None if they lack it.
    """

    abbreviation: str
    about: str
    other: str | None


MIDLINE: Mapping[str, Landmark] = {
    "metopion": Landmark("m", "middle of the forehead", "forehead_centre"),
    "glabella": Landmark("g", "most prominent point between the eyebrows", "glabella"),
    "nasion": Landmark("n", "root of the nose, between the eyes", "ibug_27"),
    "rhinion": Landmark("r", "where the nasal bone ends on the bridge of the nose", "ibug_28"),
    "pronasale": Landmark("prn", "tip of the nose", "ibug_30"),
    "subnasale": Landmark("sn", "where the septum of the nose meets the upper lip", "ibug_33"),
    "labiale_superius": Landmark("ls", "midpoint of the border of the upper lip's red", "ibug_51"),
    "stomion_superius": Landmark("stos", "midpoint of the upper lip's free edge", "ibug_62"),
    "stomion_inferius": Landmark("stoi", "midpoint of the lower lip's free edge", "ibug_66"),
    "labiale_inferius": Landmark("li", "midpoint of the border of the lower lip's red", "ibug_57"),
    "pogonion": Landmark("pg", "most prominent point of the chin", "chin_tip"),
    "gnathion": Landmark("gn", "lowest point of the chin in front", "ibug_8"),
}
"""Points in the plane of symmetry, from above to below."""

PAIRED: Mapping[str, tuple[Landmark, str | None]] = {
    "superciliare_medial": (Landmark("scm", "inner end of the eyebrow", "ibug_22"), "ibug_21"),
    "superciliare": (Landmark("sci", "highest point of the eyebrow", "ibug_24"), "ibug_19"),
    "superciliare_lateral": (Landmark("scl", "outer end of the eyebrow", "ibug_26"), "ibug_17"),
    "endocanthion": (Landmark("en", "inner corner of the eye", "ibug_42"), "ibug_39"),
    "palpebrale_superius_medial": (Landmark("psm", "upper lid's edge, inner third", "ibug_43"), "ibug_38"),
    "palpebrale_superius_lateral": (Landmark("psl", "upper lid's edge, outer third", "ibug_44"), "ibug_37"),
    "exocanthion": (Landmark("ex", "outer corner of the eye", "ibug_45"), "ibug_36"),
    "palpebrale_inferius_lateral": (Landmark("pil", "lower lid's edge, outer third", "ibug_46"), "ibug_41"),
    "palpebrale_inferius_medial": (Landmark("pim", "lower lid's edge, inner third", "ibug_47"), "ibug_40"),
    "alare": (Landmark("al", "outermost point of the wing of the nose", "ibug_35"), "ibug_31"),
    "subalare": (Landmark("sbal", "where the wing of the nose ends at the upper lip", "ibug_34"), "ibug_32"),
    "crista_philtri": (Landmark("cph", "peak of Cupid's bow, at the crest of the philtrum", "ibug_52"), "ibug_50"),
    "cheilion": (Landmark("ch", "corner of the mouth", "ibug_54"), "ibug_48"),
    "zygion": (Landmark("zy", "outermost point of the cheekbone's arch", "zygion_left"), "zygion_right"),
    "cheek": (Landmark("ck", "fullest point of the cheek", "cheek_left"), "cheek_right"),
    "gonion": (Landmark("go", "angle of the lower jaw", "gonion_left"), "gonion_right"),
}
"""Points with a left and a right; the second name is the other vocabulary's for the right."""

LANDMARKS: Mapping[str, Landmark] = {
    **MIDLINE,
    **{f"{name}_left": point for name, (point, _) in PAIRED.items()},
    **{f"{name}_right": point._replace(other=right) for name, (point, right) in PAIRED.items()},
}
"""All 44 landmarks of the generic rig; left and right are the subject's."""


def same_landmarks(source_names: Iterable[str], target_names: Iterable[str]) -> tuple[tuple[str, str], ...]:
    """Pair the landmarks of two faces that are the same point, whichever vocabulary each uses.

    A name that both have is paired with itself first; each name is paired at most once.

    Args:
        source_names, target_names: names of landmarks, in any order.

    Returns:
        `(source_name, target_name)` in the order of the source.
    """
    targets = list(dict.fromkeys(target_names))
    sources = list(dict.fromkeys(source_names))
    exact = set(sources) & set(targets)
    by_point = {_point(name): name for name in reversed(targets) if name not in exact}
    pairs = []
    for name in sources:
        match = name if name in exact else by_point.pop(_point(name), None)
        if match is not None:
            pairs.append((name, match))
    return tuple(pairs)


def _point(name: str) -> str:
    """Return one name for each point, whichever vocabulary it comes in."""
    known = LANDMARKS.get(name)
    return name if known is None or known.other is None else known.other
