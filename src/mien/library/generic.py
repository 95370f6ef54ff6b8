"""The embedded generic rig: a human head with bones, muscles, deformers and expression templates, made by code."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from mien.core import Rig
from mien.library.generic_anatomy import generic_anatomy
from mien.library.generic_measures import GENERIC
from mien.library.generic_regions import generic_regions
from mien.library.generic_skin import generic_skin
from mien.library.head import build


@cache
def generic_rig() -> Rig:
    """Make the generic rig (Orvalho, Zacur, Susin, §3): its templates say what it can do, so it has no blendshapes."""
    head = build(GENERIC)
    anatomy = replace(generic_anatomy(GENERIC, head), labels={"region": generic_regions(head, GENERIC)})
    return replace(generic_skin(head, GENERIC), anatomy=anatomy, name="generic")
