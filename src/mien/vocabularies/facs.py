"""The action units that expressions here are written in (Ekman and Friesen 1978; Ekman, Friesen and Hager 2002).

A code stands for both sides; `L` or `R` before it for one side of the face, `T` or `B`
for the upper or the lower lip, as coders write them.  Codes from 101 are ours, for
movements that the system does not number.
"""

from __future__ import annotations

import re
from typing import Final, NamedTuple

from mien.core.errors import InputError, unknown


class ActionUnit(NamedTuple):
    """What one code means: its name, and the muscles that do it, in the words of anatomy."""

    name: str
    muscles: str


ACTION_UNITS: Final[dict[str, ActionUnit]] = {
    "1": ActionUnit("inner brow raiser", "frontalis, medial part"),
    "2": ActionUnit("outer brow raiser", "frontalis, lateral part"),
    "4": ActionUnit("brow lowerer", "corrugator, depressor supercilii"),
    "5": ActionUnit("upper lid raiser", "levator palpebrae superioris"),
    "6": ActionUnit("cheek raiser", "orbicularis oculi, orbital part"),
    "7": ActionUnit("lid tightener", "orbicularis oculi, palpebral part"),
    "8": ActionUnit("lips toward each other", "orbicularis oris"),
    "9": ActionUnit("nose wrinkler", "levator labii superioris alaeque nasi"),
    "10": ActionUnit("upper lip raiser", "levator labii superioris"),
    "12": ActionUnit("lip corner puller", "zygomaticus major"),
    "14": ActionUnit("dimpler", "buccinator, risorius"),
    "15": ActionUnit("lip corner depressor", "depressor anguli oris (triangularis)"),
    "16": ActionUnit("lower lip depressor", "depressor labii inferioris"),
    "17": ActionUnit("chin raiser", "mentalis"),
    "18": ActionUnit("lip pucker", "orbicularis oris, incisivi labii"),
    "19": ActionUnit("tongue show", "genioglossus"),
    "20": ActionUnit("lip stretcher", "risorius, platysma"),
    "22": ActionUnit("lip funneler", "orbicularis oris"),
    "23": ActionUnit("lip tightener", "orbicularis oris, marginal part"),
    "24": ActionUnit("lip pressor", "orbicularis oris, marginal part"),
    "25": ActionUnit("lips part", "depressor labii inferioris, or relaxation of mentalis and orbicularis oris"),
    "26": ActionUnit("jaw drop", "masseter relaxed"),
    "27": ActionUnit("mouth stretch", "pterygoids, digastric"),
    "28": ActionUnit("lip suck", "orbicularis oris"),
    "29": ActionUnit("jaw thrust", "pterygoids"),
    "30": ActionUnit("jaw sideways", "pterygoids"),
    "32": ActionUnit("lip bite", "mentalis, orbicularis oris"),
    "34": ActionUnit("cheek puff", "buccinator relaxed, orbicularis oris"),
    "38": ActionUnit("nostril dilator", "nasalis, alar part"),
    "43": ActionUnit("eye closure", "levator palpebrae relaxed, orbicularis oculi"),
    "45": ActionUnit("blink", "levator palpebrae relaxed, orbicularis oculi"),
    "61": ActionUnit("eyes turn left", "lateral and medial rectus"),
    "62": ActionUnit("eyes turn right", "lateral and medial rectus"),
    "63": ActionUnit("eyes up", "superior rectus"),
    "64": ActionUnit("eyes down", "inferior rectus"),
    "101": ActionUnit("mouth sideways", "zygomaticus and risorius of one side"),
    "102": ActionUnit("upper lip shrug", "mentalis, through the lower lip"),
    "103": ActionUnit("tongue tip raised", "superior longitudinal muscle of the tongue"),
}
"""By code, as the manual numbers them."""

FAIGIN: Final[dict[str, tuple[str, ...]]] = {
    "frontalis": ("1", "2"),
    "corrugator": ("4",),
    "orbicularis oculi": ("6", "7", "43", "45"),
    "levator palpebrae": ("5",),
    "levator labii superioris": ("9", "10"),
    "zygomaticus major": ("12",),
    "risorius": ("14", "20"),
    "triangularis": ("15",),
    "depressor labii inferioris": ("16", "25"),
    "mentalis": ("17",),
    "orbicularis oris": ("8", "18", "22", "23", "24", "28"),
}
"""The eleven muscles chiefly responsible for expression (Faigin 1990) and the action units they do."""


def parsed_code(code: str) -> tuple[str, str]:
    """Split an action unit's code into its side (`L`, `R`, or empty) and the rest.

    Raises:
        InputError: no such action unit.
    """
    match = re.fullmatch(r"([LR]?)([TB]?)(\d+)", code)
    if match is None or match[3] not in ACTION_UNITS:
        raise InputError(unknown("action unit", code, ACTION_UNITS))
    return match[1], match[2] + match[3]
