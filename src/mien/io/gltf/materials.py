"""The colour a material says a surface has, as far as it says so."""

from __future__ import annotations

from mien.core.rig import Colour
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields

SKIN: Colour = (0.8, 0.62, 0.54)
"""What a written surface looks like that nobody chose a colour for."""

UNCHOSEN: tuple[Colour, ...] = ((1.0, 1.0, 1.0), SKIN)
"""Colours that say nothing: glTF's own default, and ours."""

SAME = 1e-4
SEEN_THROUGH = 0.5
"""A blended material less opaque than this shows what is behind it rather than a colour."""


def material_name(document: Document, primitive: Fields) -> str:
    """Return the name of a primitive's material."""
    if "material" not in primitive:
        return "no material"
    index = primitive.integer("material")
    return document.at("materials", index, primitive).text("name") or f"material_{index:02d}"


def material_colour(document: Document, primitive: Fields) -> Colour | None:
    """Return the linear base colour of a primitive, None where it is in a texture, see-through, or was never chosen.

    Raises:
        FileError: the material does not exist or is damaged.
    """
    if "material" not in primitive:
        return None
    material = document.at("materials", primitive.integer("material"), primitive)
    look = material.inner("pbrMetallicRoughness")
    factor = look.numbers("baseColorFactor", 4)
    if factor is None or "baseColorTexture" in look:
        return None
    red, green, blue, opacity = factor
    if material.text("alphaMode", "OPAQUE") != "OPAQUE" and opacity < SEEN_THROUGH:
        return None
    if not all(0 <= value <= 1 for value in (red, green, blue)):
        return None
    chosen = all(max(abs(red - r), abs(green - g), abs(blue - b)) > SAME for r, g, b in UNCHOSEN)
    return (red, green, blue) if chosen else None
