"""Rig transfer with files: a generic rig and a bare face in, the face rigged out."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Blendshapes, Clip, FileError, InputError, Note, Rig
from mien.core.errors import unknown
from mien.io import gltf
from mien.io.files import written_whole
from mien.io.formats import read_rig
from mien.job.pairs import OWN, rig_landmarks
from mien.rigging.baking import baked, scripted
from mien.rigging.transfer import Transfer, transfer_rig
from mien.vocabularies.arkit import ARKIT_NAMES
from mien.vocabularies.expressions import BLINKS, EMOTIONS, VISEMES

BUILTIN = "builtin"
SETS: Mapping[str, tuple[str, ...]] = {
    "arkit": tuple(ARKIT_NAMES),
    "emotions": EMOTIONS,
    "visemes": tuple(VISEMES),
    "blinks": BLINKS,
}
"""Templates that are made into blendshapes, by the name of their set."""
SUFFIXES = (".glb", ".gltf")


@dataclass(frozen=True)
class RigRequest:
    """What is asked for, in file names.

    Attributes:
        generic: the rig to move, or `builtin`.
        face: the mesh that receives it.
        landmarks: a file for each side; `-` for a side's own.
        method: a rig transfer method.
        influences: the most joints a vertex follows, 4 or 8.
        parts: whether eyes, teeth and tongue that the face lacks are brought (`auto`, `none`).
        shapes: sets of templates to make blendshapes of; empty for none, where the rig has templates.
    """

    generic: str
    face: Path
    landmarks: tuple[Path, Path] | None = None
    method: str = "warp-and-stick"
    influences: int = 4
    parts: str = "auto"
    shapes: tuple[str, ...] = tuple(SETS)


@dataclass(frozen=True, eq=False)
class Rigged:
    """What came out.

    Attributes:
        rig: the rigged face with its blendshapes.
        clips: the animation scripts, as weights of the blendshapes.
        transfer: the account.
        notes: everything repaired or left out.
    """

    rig: Rig
    clips: Mapping[str, Clip]
    transfer: Transfer
    notes: tuple[Note, ...] = field(default_factory=tuple)

    def as_json(self) -> dict[str, Any]:
        """Return the report for scripts."""
        rig = self.rig
        return {
            "format": "mien-rig-report",
            "version": 1,
            "vertices": len(rig.neutral.vertices),
            "added_vertices": len(self.transfer.brought.vertices),
            "joints": list(rig.skeleton.names) if rig.skeleton is not None else [],
            "blendshapes": list(rig.blendshapes.names),
            "animations": list(self.clips),
            **self.transfer.figures,
            "warnings": [vars(note) for note in self.notes],
        }


def run(request: RigRequest, progress: Callable[[str], None] = lambda stage: None) -> Rigged:
    """Move a rig onto a face.

    Args:
        request: what is asked for.
        progress: called with the name of each stage as it begins.

    Raises:
        MienError: anything about the files or the values in them.
    """
    chosen = _templates(request.shapes)
    progress("read")
    mine, theirs = (None if path == OWN else path for path in request.landmarks or (OWN, OWN))
    generic, face = _generic(request.generic, mine), read_rig(request.face)
    face = replace(face, landmarks=_landmarks(face, theirs, request.face))
    progress("transfer")
    moved = transfer_rig(generic, face, method=request.method, influences=request.influences, parts=request.parts)
    progress("shapes")
    rig, notes, clips = moved.rig, (*generic.notes, *face.notes, *moved.notes), {}
    anatomy = rig.anatomy
    if anatomy is not None and anatomy.templates:
        names = [name for name in anatomy.templates if name in chosen] if chosen else []
        shapes, remarks = baked(moved, generic, names)
        rig = replace(rig, blendshapes=_joined(rig.blendshapes, shapes))
        clips = {name: scripted(script, shapes) for name, script in anatomy.scripts.items() if len(shapes)}
        notes = (*notes, *remarks)
    return Rigged(rig, clips, moved, notes)


def write(rigged: Rigged, output: Path, influences: int = 4, report: Path | None = None) -> Rigged:
    """Write the rigged face, into the user's own file where it was glTF, and the report.

    Returns:
        The same, with what could not be written among its notes.

    Raises:
        FileError: a file cannot be written.
    """
    left_out = gltf.write_rigged(output, rigged.rig, rigged.clips, influences=influences)
    complete = replace(rigged, notes=(*rigged.notes, *left_out))
    if report is not None:
        with written_whole(report) as temporary:
            temporary.write_text(json.dumps(complete.as_json(), indent=1), encoding="utf-8")
    return complete


def _generic(name: str, landmarks: Path | None) -> Rig:
    if name == BUILTIN:
        from mien.library.generic import generic_rig  # modelled on first use

        rig = generic_rig()
    else:
        rig = read_rig(Path(name))
    return replace(rig, landmarks=_landmarks(rig, landmarks, Path(name)))


def _landmarks(rig: Rig, given: Path | None, path: Path) -> Mapping[str, Any]:
    found = rig_landmarks(rig, given)
    if not found:
        raise FileError(
            f"{path} has no landmarks: give --landmarks GENERIC.json FACE.json (`-` for a side that has its own), or put "
            f"{path.with_suffix('.landmarks.json').name} beside it."
        )
    return found


def _templates(sets: tuple[str, ...]) -> frozenset[str]:
    for name in sets:
        if name not in SETS:
            raise InputError(unknown("set of blendshapes", name, SETS))
    return frozenset(template for name in sets for template in SETS[name])


def _joined(own: Blendshapes, made: Blendshapes) -> Blendshapes:
    """Return both sets of shapes, made ones in place of own ones of the same name."""
    if not len(own):
        return made
    kept = [k for k, name in enumerate(own.names) if name not in made.names]
    return Blendshapes((*(own.names[k] for k in kept), *made.names), np.concatenate([own.deltas[kept], made.deltas]))
