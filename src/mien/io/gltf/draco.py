"""Decompression of primitives: KHR_draco_mesh_compression, through the package DracoPy.

The decoder keeps the order of the points, so morph targets, which are stored
uncompressed beside the stream, still belong to the right vertices.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mien.core import MissingPackage
from mien.core.arrays import Ints
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields


def decoded(document: Document, packed: Fields) -> dict[str, Any]:
    """Return the attributes of a compressed primitive by glTF name, and its `(T, 3)` triangles under `""`.

    Raises:
        FileError: the stream is damaged or lacks an attribute.
        MissingPackage: DracoPy is not installed.
    """
    try:
        import DracoPy
    except ImportError:
        raise MissingPackage(f"reading the Draco-compressed file {document.path}", "DracoPy", "draco") from None
    stream = bytes(document.view(packed.integer("bufferView"), packed))
    try:
        mesh = DracoPy.decode(stream)
        triangles: Ints = np.asarray(mesh.faces, dtype=np.int64).reshape(-1, 3)
    except Exception as error:  # the decoder has no common error of its own
        raise packed.error(f"holds a Draco stream that cannot be decoded ({error})") from None
    found: dict[str, Any] = {"": triangles}
    ids = packed.inner("attributes")
    for name in ids.values:
        attribute = mesh.get_attribute_by_unique_id(ids.integer(name))
        if attribute is None or np.ndim(attribute["data"]) != 2:
            raise packed.error(f"lacks the attribute {name}")
        found[name] = attribute["data"]
    return found
