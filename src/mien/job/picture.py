"""A face file as a sheet of pictures, a film, or a page that plays it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from mien.core import Clip, FileError, InputError, Rig
from mien.core.errors import unknown
from mien.io.files import written_whole
from mien.io.formats import format_of, read_clip, read_rig
from mien.look.camera import TURNS, View
from mien.look.movie import render_clip
from mien.look.player import player_page
from mien.look.portrait import Portrait, frame_clip
from mien.look.sheet import Labelled, Row, contact_sheet, save_png, sheet

PICTURES = (".png", ".mp4", ".html")


def picture(
    file: Path,
    output: Path,
    *,
    clip: Path | None = None,
    view: str = "front",
    size: int = 480,
    frames: Sequence[int] | None = None,
    count: int = 12,
    fps: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Picture a face: a sheet of frames (`.png`), a film (`.mp4`) or a page that plays it (`.html`).

    A face without animation is shown at rest and in each of its strongest shapes; on a page they are set by hand.

    Raises:
        FileError: a file cannot be read or written, or a film is asked of a still face.
        InputError: an unknown view or frame.
    """
    if view not in TURNS:
        raise InputError(unknown("view", view, TURNS))
    suffix = output.suffix.lower()
    if suffix not in PICTURES:
        raise FileError(f"cannot write {output}: pictures are .png, films .mp4, pages .html.")
    rig = read_rig(file)
    seen: View = view
    motion = _motion(file, clip)
    if suffix == ".mp4":
        if motion is None:
            raise FileError(
                f"{file} has no animation to film; give one with --clip, or make a .png sheet or an .html page."
            )
        even = size + size % 2
        render_clip(output, rig, motion, view=seen, size=(even, even), fps=fps, progress=progress)
    elif suffix == ".html":
        page = player_page(rig, motion, view=seen)
        with written_whole(output) as temporary:
            temporary.write_text(page, encoding="utf-8")
    elif motion is None:
        save_png(output, shape_sheet(rig, seen, size, count))
    else:
        save_png(output, contact_sheet(rig, motion, frames, count, view=seen, size=size))


def shape_sheet(rig: Rig, view: View, size: int, count: int) -> np.ndarray:
    """Picture a still face at rest and in its strongest shapes."""
    reach = np.linalg.norm(rig.blendshapes.deltas, axis=2).max(axis=1) if len(rig.blendshapes) else np.zeros(0)
    strongest = np.argsort(-reach, kind="stable")[: max(0, count - 1)]
    poses = np.eye(len(reach))[strongest]
    camera = frame_clip(rig, Clip(rig.blendshapes.names, poses, 1.0), view)
    sitter = Portrait.of(rig, view, size=(size, size), camera=camera)
    cells = [Labelled(sitter.picture(), "neutral")]
    for k, pose in zip(strongest, poses, strict=True):
        cells.append(Labelled(sitter.picture(pose), rig.blendshapes.names[k]))
    return sheet([Row("", tuple(cells[i : i + 4])) for i in range(0, len(cells), 4)], rig.name)


def _motion(file: Path, clip: Path | None) -> Clip | None:
    if clip is not None:
        return read_clip(clip)
    if format_of(file).read_clip is None:
        return None
    try:
        return read_clip(file)
    except FileError:
        return None
