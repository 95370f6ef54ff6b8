"""Motion as BVH: joints with offsets from their parents, and rotations over time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mien.core import FileError
from mien.core.arrays import Floats
from mien.io.files import read_text

MOST_JOINTS = 4096
"""More joints than this no body has."""


@dataclass(frozen=True, eq=False)
class Motion:
    """What a BVH file says, in its own unit and axes.

    Attributes:
        names: `J` joints, parents first.
        parents: index of each joint's parent, -1 for a root.
        offsets: `(J, 3)` from the parent at rest.
        rotations: `(F, J, 3, 3)` relative to the parent; all axes are parallel at rest.
        fps: frames per second.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Floats
    rotations: Floats
    fps: float


def read_motion(path: Path) -> Motion:
    """Read the rotations of a BVH file; translations over time are not read.

    Raises:
        FileError: the file is missing or damaged.
    """
    words = read_text(path).split()
    try:
        split = words.index("MOTION")
    except ValueError:
        raise FileError(f"{path} is not a BVH file: it has no line MOTION.") from None
    try:
        names, parents, offsets, channels = _hierarchy(path, words[:split])
        frames, fps, numbers = _table(path, words[split + 1 :])
    except (ValueError, IndexError, OverflowError) as error:
        raise FileError(f"{path} is damaged: {error}. Export it again.") from None
    width = sum(map(len, channels))
    if not names or frames < 1 or numbers.size != frames * width:
        raise FileError(f"{path} is damaged: {frames} frames of {width} channels, but {numbers.size} numbers.")
    if not (np.isfinite(numbers).all() and np.isfinite(offsets).all() and 0 < fps < np.inf):
        raise FileError(f"{path} is damaged: it holds NaN, infinity or a frame time that is not positive.")
    rotations = np.empty((frames, len(names), 3, 3))
    table, at = numbers.reshape(frames, width), 0
    for j, own in enumerate(channels):
        axes = [i for i, channel in enumerate(own) if channel.endswith("rotation")]
        order = "".join(own[i][0] for i in axes)
        turned = Rotation.from_euler(order, table[:, [at + i for i in axes]], degrees=True) if order else None
        rotations[:, j] = np.eye(3) if turned is None else turned.as_matrix()
        at += len(own)
    return Motion(tuple(names), tuple(parents), offsets, rotations, fps)


def _hierarchy(path: Path, words: list[str]) -> tuple[list[str], list[int], Floats, list[list[str]]]:
    names: list[str] = []
    parents: list[int] = []
    offsets: list[list[float]] = []
    channels: list[list[str]] = []
    line: list[int] = []
    at = 0
    while at < len(words):
        word = words[at]
        if word in {"ROOT", "JOINT"}:
            parents.append(line[-1] if line else -1)
            names.append(words[at + 1])
            offsets.append([0.0] * 3)
            channels.append([])
            at += 2
        elif word == "End":
            at += 1 + words[at:].index("}")  # End Site { OFFSET x y z }: where a bone ends is not needed
        elif word == "{":
            line.append(len(names) - 1)
            at += 1
        elif word == "}":
            line.pop()
            at += 1
        elif word == "OFFSET":
            offsets[line[-1]] = [float(number) for number in words[at + 1 : at + 4]]
            at += 4
        elif word == "CHANNELS":
            count = int(words[at + 1])
            channels[line[-1]] = _checked(path, words[at + 2 : at + 2 + count], count)
            at += 2 + count
        else:
            at += 1
        if len(names) > MOST_JOINTS:
            raise FileError(f"{path} has more than {MOST_JOINTS} joints.")
    return names, parents, np.array(offsets, dtype=np.float64).reshape(len(names), 3), channels


def _checked(path: Path, channels: list[str], count: int) -> list[str]:
    known = {axis + kind for axis in "XYZ" for kind in ("position", "rotation")}
    order = [channel for channel in channels if channel.endswith("rotation")]
    if len(channels) != count or not 0 <= count <= 6 or not known.issuperset(channels) or len(set(order)) != len(order):
        raise FileError(f"{path} has the channels {channels[:6]}; positions and rotations along X, Y and Z are known.")
    return channels


def _table(path: Path, words: list[str]) -> tuple[int, float, Floats]:
    if words[0] != "Frames:" or words[2:4] != ["Frame", "Time:"]:
        raise FileError(f"{path} is damaged: after MOTION it must say the number of frames and their time.")
    frames, time = int(words[1]), float(words[4])
    return frames, 1 / time if time else 0.0, np.array(words[5:], dtype=np.float64)
