"""Pictures side by side with words beside them, and the frames worth seeing."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core import Clip, FileError, InputError, MissingPackage, Rig
from mien.core.arrays import Floats, Ints
from mien.io.files import written_whole
from mien.look.camera import View
from mien.look.portrait import Portrait, frame_clip, weights_for
from mien.look.raster import Picture

PAPER, INK, FAINT = (255, 255, 255), (32, 36, 42), (107, 114, 128)
GAP = 12

SAME = 1e-9
"""Frames whose weights differ by no more than this repeat each other."""


@dataclass(frozen=True, eq=False)
class Labelled:
    """A picture and the words under it."""

    picture: Picture
    label: str = ""


@dataclass(frozen=True, eq=False)
class Row:
    """Pictures side by side, and the words at their left."""

    title: str
    cells: tuple[Labelled, ...]


def sheet(rows: Sequence[Row], title: str = "") -> Picture:
    """Lay rows of pictures out on white paper, with labels.

    Args:
        rows: at least one with at least one picture; the pictures may differ in size.
        title: words above all.

    Raises:
        InputError: there is no picture.
        MissingPackage: Pillow is not installed.
    """
    cells = [cell for row in rows for cell in row.cells]
    if not cells:
        raise InputError("a sheet needs at least one picture.")
    try:
        from PIL import Image, ImageDraw, ImageFont
    except ImportError:
        raise MissingPackage("a sheet of pictures", "pillow", "look") from None
    wide = max(cell.picture.shape[1] for cell in cells)
    size = int(np.clip(wide // 18, 12, 22))
    head, words = ImageFont.load_default(size + 6), ImageFont.load_default(size)
    line = 2 * size
    tall = [max((cell.picture.shape[0] for cell in row.cells), default=0) for row in rows]
    top = GAP + (line + 8 if title else 0)
    left = GAP + max((int(words.getlength(row.title)) + GAP for row in rows if row.title), default=0)
    columns = max(len(row.cells) for row in rows)
    paper = Image.new("RGB", (left + columns * (wide + GAP), top + sum(height + line for height in tall) + GAP), PAPER)
    draw = ImageDraw.Draw(paper)
    if title:
        draw.text((GAP, GAP), title, INK, head)
    for row, height in zip(rows, tall, strict=True):
        draw.text((GAP, top + height / 2), row.title, INK, words, anchor="lm")
        for column, cell in enumerate(row.cells):
            x = left + column * (wide + GAP)
            paper.paste(Image.fromarray(cell.picture), (x + (wide - cell.picture.shape[1]) // 2, top))
            draw.text((x + wide / 2, top + height + line / 2), cell.label, FAINT, words, anchor="mm")
        top += height + line
    return np.asarray(paper)


def contact_sheet(
    rig: Rig,
    clip: Clip,
    frames: Sequence[int] | None = None,
    count: int = 12,
    *,
    view: View = "front",
    size: int = 256,
    columns: int = 4,
    title: str = "",
) -> Picture:
    """Picture the telling frames of a clip, each with its number and time; the head is held still.

    Args:
        rig: who plays it.
        clip: the animation, in the rig's shapes.
        frames: which frames; the most different ones if None.
        count: how many to pick.
        view: from where.
        size: width and height of each picture [pixels].
        columns: pictures in a row.
        title: words above all; the rig's name if empty.

    Raises:
        InputError: a frame does not exist or was not tracked, or the clip has no frame to show.
        MissingPackage: Pillow is not installed.
    """
    weights = weights_for(rig, clip)
    chosen = telling_frames(weights, count) if frames is None else _checked_frames(weights, frames)
    still = replace(clip, head=None)
    sitter = Portrait.of(rig, view, size=(size, size), camera=frame_clip(rig, still, view, frames=chosen))
    joints = [None if clip.joints is None else clip.joints[f] for f in chosen]
    cells = [
        Labelled(sitter.picture(weights[f], joints=j), f"frame {f} · {f / clip.fps:.2f} s")
        for f, j in zip(chosen, joints, strict=True)
    ]
    rows = [Row("", tuple(cells[i : i + columns])) for i in range(0, len(cells), columns)]
    return sheet(rows, title or rig.name)


def telling_frames(values: Floats, count: int = 12) -> Ints:
    """Return frames that show the most of a clip, in order of time.

    The calmest and the strongest come first; then, again and again, the frame farthest
    from all those chosen (farthest-point sampling).  Fewer are returned when the
    remaining frames repeat the chosen ones.

    Args:
        values: `(F, K)` weights; rows with NaN are passed over.
        count: how many at most.

    Raises:
        InputError: no frame was tracked.
    """
    tracked = np.flatnonzero(np.isfinite(values).all(axis=1))
    if not len(tracked) or count < 1:
        raise InputError(
            f"there is no tracked frame to show among {len(values)}, or none was asked for (count {count})."
        )
    shown = values[tracked]
    strength = np.linalg.norm(shown, axis=1)
    chosen = [int(strength.argmin())]
    distance = np.linalg.norm(shown - shown[chosen[0]], axis=1)
    following = int(strength.argmax())
    if distance[following] <= SAME:
        following = int(distance.argmax())
    while len(chosen) < count and distance[following] > SAME:
        chosen.append(following)
        distance = np.minimum(distance, np.linalg.norm(shown - shown[following], axis=1))
        following = int(distance.argmax())
    return np.sort(tracked[chosen])


def png(picture: NDArray[np.uint8]) -> bytes:
    """Return a picture as the content of a PNG file.

    Raises:
        MissingPackage: Pillow is not installed.
    """
    try:
        from PIL import Image
    except ImportError:
        raise MissingPackage("a PNG picture", "pillow", "look") from None
    content = io.BytesIO()
    Image.fromarray(picture).save(content, "PNG", optimize=False)
    return content.getvalue()


def save_png(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write a picture as a PNG file.

    Raises:
        FileError: it cannot be written, or the name does not end in .png.
        MissingPackage: Pillow is not installed.
    """
    if path.suffix.lower() != ".png":
        raise FileError(f"cannot write {path}: pictures are written as .png; change the name.")
    content = png(picture)
    with written_whole(path) as temporary:
        temporary.write_bytes(content)


def _checked_frames(weights: Floats, frames: Sequence[int]) -> Ints:
    chosen = np.asarray(frames, dtype=np.int64)
    for frame in chosen:
        if not 0 <= frame < len(weights):
            raise InputError(f"frame {frame} does not exist; the clip has frames 0 … {len(weights) - 1}.")
        if not np.isfinite(weights[frame]).all():
            raise InputError(f"frame {frame} was not tracked, so there is nothing to show; choose another.")
    return chosen
