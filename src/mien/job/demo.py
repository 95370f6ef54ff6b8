"""The demonstration: the faces that come with mien, as files, through the main job."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from mien.io import gltf, trc
from mien.io.documents import write_landmarks
from mien.io.formats import read_clip, read_rig
from mien.job.request import Request
from mien.job.rig import BUILTIN, RigRequest
from mien.library import actor, character, performance
from mien.library.cast import EXTREMES, cast_member
from mien.library.characters import globe, radio
from mien.library.generic import generic_rig
from mien.library.heads import HEADS
from mien.look.portrait import Portrait
from mien.look.sheet import Labelled, Row, save_png, sheet, telling_frames
from mien.retargeting.layers import Layers
from mien.rigging.baking import scripted


def prepare(folder: Path) -> Request:
    """Write the built-in capture and character as files, and return the request that retargets them.

    The landmarks of the character go beside it; the markers carry the names of the
    landmarks they sit on, so nothing else has to be said.  The cartoon's eyes are three
    times as high as the actor's, so what a solve leaves of a blink shows: contact is on.

    Raises:
        FileError: the folder cannot be written to.
    """
    take, hero = folder / "capture.trc", folder / "character.glb"
    rig = character()
    trc.write_markers(take, performance(actor())[1])
    gltf.write_rig(hero, rig)
    write_landmarks(hero.with_suffix(".landmarks.json"), rig.landmarks, rig.neutral)
    return Request(take, hero, training=take, settings={"contact": 1.0})


def prepare_goat(folder: Path) -> RigRequest:
    """Write a bare goat's head, whose landmarks are in the file, and return the request that rigs it.

    Raises:
        FileError: the folder cannot be written to.
    """
    bare = folder / "goat.glb"
    gltf.write_rig(bare, HEADS["goat"]())
    return RigRequest(BUILTIN, bare)


def prepare_sentence(folder: Path) -> tuple[Request, ...]:
    """Write the actor speaking a sentence and the characters that are to speak it, and return the requests.

    Raises:
        FileError: the folder cannot be written to.
    """
    speaker = folder / "speaker.glb"
    rig = replace(cast_member("actor", EXTREMES), skeleton=None, skin=None, anatomy=None)
    anatomy = generic_rig().anatomy
    assert anatomy is not None
    gltf.write_rig(speaker, rig, scripted(anatomy.scripts["sentence"], rig.blendshapes))
    requests = []
    for face in (globe(), radio()):
        gltf.write_rig(folder / f"{face.name}.glb", face)
        requests.append(Request(speaker, folder / f"{face.name}.glb", method=Layers.name))
    return tuple(requests)


def picture_together(files: Sequence[Path], output: Path, count: int = 10, size: int = 200) -> None:
    """Picture animated faces that do the same thing at the same time, one row each.

    Raises:
        FileError: a file cannot be read or written.
    """
    clips = [read_clip(path) for path in files]
    frames = telling_frames(clips[0].values, count)
    rows = []
    for path, clip in zip(files, clips, strict=True):
        rig = read_rig(path)
        values = clip.channels(rig.blendshapes.names)
        sitter = Portrait.of(rig, size=(size, size))
        cells = tuple(Labelled(sitter.picture(values[f]), f"{f / clip.fps:.1f} s") for f in frames)
        rows.append(Row(path.stem, cells))
    save_png(output, sheet(rows))
