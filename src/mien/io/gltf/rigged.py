"""Writing the result of a rig transfer: the face's own file, whole, with the rig inside it.

Vertices, order, materials and everything mien does not understand stay as they were.
Compressed attributes stay compressed: skin and shapes are stored beside them, in the
order of the decoded vertices, as morph targets always are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from mien.core import Clip, InputError, Note, Rig
from mien.io.gltf.anatomy import describe
from mien.io.gltf.appended import add_appended, appended
from mien.io.gltf.bones import limited
from mien.io.gltf.container import open_document
from mien.io.gltf.fresh import Colours, document_of
from mien.io.gltf.morphs import weight_curves
from mien.io.gltf.packing import Packing
from mien.io.gltf.rebinding import Bound, bind_meshes, keeps_its_skin
from mien.io.gltf.rig import Character, character
from mien.io.gltf.shaping import add_shapes, own_meshes
from mien.io.gltf.write import animate, moved_joints

NO_CLIPS: Mapping[str, Clip] = MappingProxyType({})
SAME = 1e-5
"""How far, relative to the face, a vertex may be from where the file has it."""


def write_rigged(
    path: Path,
    rig: Rig,
    clips: Mapping[str, Clip] = NO_CLIPS,
    *,
    influences: int = 4,
    colours: Colours | None = None,
) -> tuple[Note, ...]:
    """Write a rigged face as .glb, or as .gltf with a .bin beside it.

    A face that came from glTF keeps its whole file.  Added are joint nodes, a skin for
    every mesh the scene shows (in place of one it has), morph targets behind those it has
    (in place of those of the same name), parts that the rig has beyond the file's
    vertices, the animations, and anatomy and landmarks in `extras.mien`.  If something
    moved the face before (a joint, an animated node), the new joints hang under it.  A rig
    whose skeleton and skin are the file's own leaves them alone.

    Args:
        path: the file to write.
        rig: the face; its first vertices are those of the file `rig.source`, as `read_rig` numbers them.
        clips: animations by name.
        influences: the most joints per vertex, 4 or 8; 4 is what every program shows.
        colours: linear red, green and blue of vertex groups that the file does not colour itself; the rig's own
            if None.

    Returns:
        What had to be left out.

    Raises:
        FileError: the face's file is gone or damaged, or `path` cannot be written.
        InputError: the rig is not about that file, or glTF cannot hold it.
    """
    if influences not in {4, 8}:
        raise InputError(f"a vertex follows at most 4 or 8 joints in glTF, but influences is {influences}.")
    if not len(rig.neutral.triangles):
        raise InputError(f"{rig.name!r} has no triangles; a glTF file needs a surface.")
    notes: list[Note] = []
    held = rig
    if rig.skin is not None:
        skin, notes = limited(rig.skin, influences)
        held = replace(rig, skin=skin)
    if rig.source is None or rig.source.suffix.lower() not in {".glb", ".gltf"}:
        packing = document_of(path, held, colours)
        joints: Sequence[int] = range(0 if held.skeleton is None else len(held.skeleton.names))
    else:
        found = character(open_document(rig.source))
        _check_vertices(rig, found)
        own = keeps_its_skin(rig, found)
        packing, joints, more = _completed(
            rig if own else held, found, rig.colours if colours is None else colours, own
        )
        notes = more if own else notes + more
    for name, clip in reversed(list(clips.items())):
        animate(packing, clip, () if moved_joints(clip, rig) is None else joints, name)
    packing.write(path)
    return tuple(notes)


def _completed(
    rig: Rig, found: Character, colours: Colours, own_skin: bool
) -> tuple[Packing, Sequence[int], list[Note]]:
    """Return the face's document with everything added but the animations, its joint nodes, and notes."""
    document, count = found.document, len(found.rig.neutral.vertices)
    curves = weight_curves(document)  # before packing moves what they refer to
    rest, origin = appended(rig, count)
    notes: list[Note] = []
    packing = Packing(document)
    own_meshes(document, found.instances)
    add_shapes(packing, found, rig.blendshapes, curves)
    bound = None
    if rig.skin is not None and own_skin:
        bound = Bound(found.joint_nodes, None, rig.skin.inverse_bind)
    elif rig.skin is not None and rig.skeleton is not None:
        bound, notes = bind_meshes(packing, found, rig.skeleton, rig.skin)
    if rest is not None:
        add_appended(packing, rest, bound, colours)
    describe(packing, rig, np.concatenate([np.arange(count), count + origin]))
    return packing, () if bound is None else bound.joints, notes


def _check_vertices(rig: Rig, found: Character) -> None:
    """Check that the rig's first vertices are the file's.

    Raises:
        InputError: they are others.
    """
    stored = found.rig.neutral.vertices
    size = float(np.ptp(stored, axis=0).max())
    if len(rig.neutral.vertices) >= len(stored):
        off = np.abs(rig.neutral.vertices[: len(stored)] - stored).max(axis=1)
        if off.max() <= SAME * size:
            return
        said = f"vertex {int(off.argmax())} of {rig.name!r} is {off.max():g} m from where the file has it"
    else:
        said = f"{rig.name!r} has {len(rig.neutral.vertices)} vertices, the file {len(stored)}"
    raise InputError(
        f"{rig.source} is not the file that this rig was made for: {said}. "
        "Was it changed since? Make the rig again, or set its source to None to write a new file."
    )
