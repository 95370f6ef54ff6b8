"""mien puts an actor's facial performance onto any character.

The nouns are imported here; the verbs are loaded when first used, so that `import mien`
is quick.

    character = mien.read_rig("hero.glb")
    markers = mien.read_markers("take.c3d")
    pairs = mien.read_pairs("take_hero.pairs.json", character.neutral, markers.names)
    retargeter = mien.make_method("range-of-motion").fit(character, markers, pairs)
    clip, report = retargeter.retarget(markers)
    mien.write_clip("out.glb", clip, character)
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from mien.core import (
    Blendshapes,
    Clip,
    Correspondence,
    Examples,
    FileError,
    InputError,
    Markers,
    Mesh,
    MienError,
    MissingPackage,
    Note,
    Report,
    Rig,
    Skeleton,
    Skin,
    SurfacePoints,
)

__version__ = "0.1.0"

_VERBS = {
    "read_rig": "mien.io.formats",
    "read_clip": "mien.io.formats",
    "read_markers": "mien.io.formats",
    "write_clip": "mien.io.formats",
    "read_pairs": "mien.io.documents",
    "write_pairs": "mien.io.documents",
    "read_landmarks": "mien.io.documents",
    "read_examples": "mien.io.examples",
    "fill_gaps": "mien.capture",
    "find_neutral": "mien.capture",
    "trace": "mien.capture",
    "METHODS": "mien.retargeting",
    "make_method": "mien.retargeting",
    "parameters": "mien.retargeting",
    "match": "mien.vocabularies",
}

__all__ = [
    "Blendshapes",
    "Clip",
    "Correspondence",
    "Examples",
    "FileError",
    "InputError",
    "Markers",
    "Mesh",
    "MienError",
    "MissingPackage",
    "Note",
    "Report",
    "Rig",
    "Skeleton",
    "Skin",
    "SurfacePoints",
    "__version__",
    *sorted(_VERBS),
]


def __getattr__(name: str) -> Any:
    """Load a verb when it is first asked for."""
    if name in _VERBS:
        return getattr(import_module(_VERBS[name]), name)
    raise AttributeError(f"module 'mien' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List the public names, those not yet loaded included."""
    return sorted(__all__)
