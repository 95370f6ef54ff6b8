"""The demonstration: the faces that come with mien, as files, through the main job."""

from __future__ import annotations

import json
from pathlib import Path

from mien.core import Rig
from mien.io import gltf, trc
from mien.io.files import written_whole
from mien.job.retarget import Request
from mien.library import actor, character, performance


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
    gltf.write_rig(hero, rig)
    write_landmarks(hero.with_suffix(".landmarks.json"), rig)
    return Request(take, hero, training=take)


def write_landmarks(path: Path, rig: Rig) -> None:
    """Write a rig's landmarks, which are vertices, as a `mien-landmarks` file."""
    spots = {name: {"vertex": int(point.corners[0, 0])} for name, point in rig.landmarks.items()}
    document = {"format": "mien-landmarks", "version": 1, "landmarks": spots}
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1), encoding="utf-8")
