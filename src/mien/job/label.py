"""Frames to label, as pictures and a table to fill in: labelling as work with a beginning and an end.

Label, fit, suggest, label: a folder that has a table already keeps every row of it, and gets new ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mien.core import Examples, FileError, InputError, Markers, Note, Rig
from mien.core.arrays import Floats, Ints
from mien.io.examples import read_examples, write_examples
from mien.job.labelled import Source, Target, read_target, source_of
from mien.job.likeness import actor_pictures, reading_of
from mien.job.model import SUFFIX
from mien.job.pairs import DEFAULT_COUNT
from mien.job.performance import Performance, load_performance
from mien.job.request import Fitted
from mien.job.retarget import frames_of
from mien.job.suggest import Asked, ask, chosen
from mien.look.portrait import Portrait
from mien.look.raster import Picture
from mien.look.sheet import Labelled, Row, save_png, sheet
from mien.retargeting.rows import MarkerRows, Reading, read_points, read_weights
from mien.retargeting.shape_retargeter import ShapeRetargeter

TABLE, OVERVIEW = "labels.csv", "frames.png"
SIZE, WIDTH = 360, 2880
"""Height of a picture and width of the sheet of all, at most [pixels]."""
DIGITS = 3
"""Of predictions in the table."""


@dataclass(frozen=True, eq=False)
class Choice:
    """What is to be labelled.

    Attributes:
        frames: the new ones, the most telling first.
        table: all rows of the table, those that were there and the new ones.
        pictures: of the new frames, with the predicted poses beside the actor's; none if only weights are known.
        filled: whether the new rows hold a prediction to correct.
        notes: what could not be done.
        captions: what each new frame shows, if that is known.
    """

    frames: Ints
    table: Examples
    pictures: tuple[Picture, ...]
    filled: bool
    notes: tuple[Note, ...] = ()
    captions: tuple[str, ...] = ()


def choose(performance: Path, side: Path, folder: Path, *, count: int = 10, actor: Path | None = None) -> Choice:
    """Choose frames of a performance to label.

    Args:
        performance: what the actor did.
        side: a model fitted to it, whose predictions are put in the table; or a character.
        folder: where the table is or will be.
        count: how many frames.
        actor: the rig that weights play on.

    Raises:
        FileError: a file is missing or damaged.
        InputError: fewer frames than asked for.
    """
    before = read_examples(folder / TABLE) if (folder / TABLE).exists() else None
    if side.suffix.lower() == SUFFIX:
        return _by_model(ask(performance, side, actor), before, count)
    return _from_scratch(load_performance(performance, actor), read_target(side), before, count)


def write(choice: Choice, folder: Path) -> list[Path]:
    """Write the table, a picture of each new frame, and a sheet of all new ones; return what was written.

    Raises:
        FileError: the folder cannot be made, or a file not be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"cannot make the folder {folder}: {error.strerror}.") from None
    written = []
    for frame, picture in zip(choice.frames, choice.pictures, strict=False):
        save_png(folder / f"frame_{frame:05d}.png", picture)
        written.append(folder / f"frame_{frame:05d}.png")
    if choice.pictures:
        said = [f": {caption}" for caption in choice.captions] or [""] * len(choice.frames)
        cells = [
            Labelled(p, f"frame {f}{words}") for f, p, words in zip(choice.frames, choice.pictures, said, strict=True)
        ]
        across = max(1, WIDTH // choice.pictures[0].shape[1])
        rows = [Row("", tuple(cells[i : i + across])) for i in range(0, len(cells), across)]
        save_png(folder / OVERVIEW, sheet(rows))
        written.append(folder / OVERVIEW)
    write_examples(folder / TABLE, choice.table)
    return [folder / TABLE, *written]


def _by_model(asked: Asked, before: Examples | None, count: int) -> Choice:
    """Choose by what the model was shown, and put its predictions in the table."""
    model = asked.fitted.retargeter
    known = np.zeros(0, dtype=np.int64) if before is None else before.frames
    check_frames(known, len(asked.rows))
    shown = np.concatenate([asked.shown, asked.rows[known]])
    frames = chosen(shown, asked.rows, count, asked.frames.fps).frames
    clip = model.retarget(asked.frames)[0]
    new = Examples(frames, clip.names, np.round(clip.values[frames], DIGITS) + 0.0)
    old = before
    if before is None and _is_training(asked):
        old = asked.labels
    choice = _choice(asked.performance, asked.fitted, reading_of(model), new, old, filled=True)
    rig = asked.fitted.character
    if rig is None or asked.fitted.bones is not None or new.names != rig.blendshapes.names:
        return choice
    return replace(choice, pictures=beside(choice.pictures, rig, new.values))


def beside(pictures: Sequence[Picture], rig: Rig, poses: Floats) -> tuple[Picture, ...]:
    """Put a character in poses `(E, K)` of all its shapes beside pictures of the actor."""
    sitter = Portrait.of(rig, size=(SIZE, SIZE))
    pairs = zip(pictures, poses, strict=True)
    return tuple(np.concatenate([actor, sitter.picture(pose)], axis=1) for actor, pose in pairs)


def _from_scratch(performance: Performance, target: Target, before: Examples | None, count: int) -> Choice:
    """Choose by the rest pose alone, as if it were labelled, and the rest pose itself."""
    names = parameters(target)
    source = source_of(performance, target.rig, count=DEFAULT_COUNT)
    read = _read(source, target.rig, head_moves=performance.head_moves)
    known = np.zeros(0, dtype=np.int64) if before is None else before.frames
    check_frames(known, len(read.take))
    calm = np.zeros(0, dtype=np.int64)
    if not len(known):
        distance = np.linalg.norm(np.where(np.isnan(read.take), np.inf, read.take), axis=1)
        calm = np.array([int(np.argmin(distance))])
    more = count - len(calm)
    frames = calm
    if more:
        frames = np.concatenate(
            [calm, chosen(read.take[np.concatenate([known, calm])], read.take, more, read.fps).frames]
        )
    values = np.full((len(frames), len(names)), np.nan)
    if len(calm) and target.rig is not None:
        values[0] = 0.0
    reading = read.how if isinstance(read.how, MarkerRows) else None
    stand_in = _Unfitted(reading.names if reading is not None else None)
    new = Examples(frames, names, values)
    return _choice(performance, Fitted(stand_in, target.rig, source.points), reading, new, before, filled=False)


def _read(source: Source, rig: Rig | None, *, head_moves: bool) -> Reading:
    if isinstance(source.take, Markers):
        return read_points(source.take, rig, source.pairs, neutral=source.neutral, head_moves=head_moves)
    return read_weights(source.take)


@dataclass(frozen=True)
class _Unfitted:
    """What is known of a method before it is fitted: which markers it will read."""

    markers: tuple[str, ...] | None


def _choice(
    performance: Performance,
    fitted: Fitted,
    reading: MarkerRows | ShapeRetargeter | None,
    new: Examples,
    old: Examples | None,
    *,
    filled: bool,
) -> Choice:
    markers = frames_of(fitted, performance) if reading is not None else None
    pictures = actor_pictures(performance, markers, reading, new.frames, SIZE)  # type: ignore[arg-type]
    notes: tuple[Note, ...] = ()
    if not pictures:
        text = "there is no picture of weights alone; give the rig they were recorded on with --actor."
        notes = (Note("no-pictures", text, str(performance.path)),)
    return Choice(new.frames, joined(old, new), tuple(pictures), filled, notes)


def joined(old: Examples | None, new: Examples) -> Examples:
    """Return the rows that were there, untouched, and the new ones."""
    if old is None:
        return new
    names = tuple(dict.fromkeys([*old.names, *new.names]))
    values = np.full((len(old.frames) + len(new.frames), len(names)), np.nan)
    for part, rows in ((old, slice(0, len(old.frames))), (new, slice(len(old.frames), None))):
        values[rows, [names.index(name) for name in part.names]] = part.values
    return Examples(np.concatenate([old.frames, new.frames]), names, values)


def _is_training(asked: Asked) -> bool:
    """Return whether the performance is the take that the model was labelled on."""
    if asked.labels is None or asked.labels.frames.max() >= len(asked.rows):
        return False
    return np.allclose(asked.rows[asked.labels.frames], asked.shown, equal_nan=True)


def parameters(target: Target) -> tuple[str, ...]:
    """Return the names of what can be labelled.

    Raises:
        InputError: the character has no blendshapes.
    """
    rig: Rig | None = target.rig
    if rig is not None:
        moving = tuple(name for name in rig.blendshapes.names if name not in rig.blendshapes.empty)
        if not moving:
            raise InputError(
                f"{rig.name} has no blendshapes to label; give a .csv with the parameters as its columns as the character."
            )
        return moving
    return target.animations[0].names


def check_frames(known: Ints, length: int) -> None:
    """Refuse a table of another take.

    Raises:
        InputError: it labels a frame that the performance does not have.
    """
    if len(known) and known.max() >= length:
        raise InputError(
            f"{TABLE} in the folder labels frame {known.max()}, but the performance has frames 0 … {length - 1}; "
            "it belongs to another take. Choose another folder."
        )
