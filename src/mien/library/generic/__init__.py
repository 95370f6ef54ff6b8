"""The embedded generic rig: a human head with bones, muscles, deformers and expression templates, made by code."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from mien.core import Rig
from mien.library.generic.anatomy import generic_anatomy
from mien.library.generic.head import build
from mien.library.generic.proportions import GENERIC
from mien.library.generic.regions import generic_regions
from mien.library.generic.skin import generic_skin


@cache
def generic_rig() -> Rig:
    """Make the generic rig (Orvalho, Zacur, Susin, §3): its templates say what it can do, so it has no blendshapes."""
    head = build(GENERIC)
    anatomy = replace(generic_anatomy(GENERIC, head), labels={"region": generic_regions(head, GENERIC)})
    return replace(generic_skin(head, GENERIC), anatomy=anatomy, name="generic")
