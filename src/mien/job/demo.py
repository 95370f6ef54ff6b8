"""The demonstration: the faces that come with mien, as files, through the main job."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from mien.core import Rig
from mien.io import gltf, trc
from mien.io.files import written_whole
from mien.job.retarget import Request
from mien.library import actor, character, performance
from mien.look.parts import named_parts, part_colour


def prepare(folder: Path) -> Request:
    """Write the built-in capture and character as files, and return the request that retargets them.

    The landmarks of the character go beside it; the markers carry the names of the
    landmarks they sit on, so nothing else has to be said.

    Raises:
        FileError: the folder cannot be written to.
    """
    take, hero = folder / "capture.trc", folder / "character.glb"
    rig = character()
    trc.write_markers(take, performance(actor())[1])
    write_character(hero, rig)
    write_landmarks(hero.with_suffix(".landmarks.json"), rig)
    return Request(take, hero, training=take)


def write_character(path: Path, rig: Rig) -> None:
    """Write a rig as glTF with eyes, teeth and lips in their colours."""
    parts = {part: ids for part, ids in named_parts(rig.neutral).items() if part != "skin"}
    painted = replace(rig, neutral=replace(rig.neutral, groups=parts))
    gltf.write_rig(path, painted, colours={part: part_colour(part) for part in parts})


def write_landmarks(path: Path, rig: Rig) -> None:
    """Write a rig's landmarks, which are vertices, as a `mien-landmarks` file."""
    spots = {name: {"vertex": int(point.corners[0, 0])} for name, point in rig.landmarks.items()}
    document = {"format": "mien-landmarks", "version": 1, "landmarks": spots}
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1), encoding="utf-8")
