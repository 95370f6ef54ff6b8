"""Live Link Face recordings: a phone's 52 ARKit weights, head and eyes, as text.

One row a frame: a timecode `hh:mm:ss:ff.mmm` whose last part counts thousandths of a
frame, the number of values, 52 weights, and yaw, pitch, roll of the head and of both
eyes in radians.  Columns are found by name, as their order differs between versions.

Angles.  The format has no published definition, so the signs here were measured.
For the eyes, the angles of three takes were compared with the `eyeLook…` weights
beside them: yaw is positive towards the subject's right, pitch positive downwards,
and roll follows from both only if rotations are composed yaw · pitch · roll.  For
the head, the signs are those under which the gaze of someone watching the phone
stays on it while the head shakes: yaw positive to the subject's left, which is
clear, and pitch positive upwards with roll as for the eyes, which is likelier than
the alternatives by a smaller margin.  mien's own angles turn right-handedly about +Y (yaw),
+X (pitch) and +Z (roll), applied in the order R = R_y R_x R_z.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mien.core import Clip, FileError, InputError, Note, Rig
from mien.core.arrays import Floats
from mien.io.files import read_bytes, read_text, written_whole
from mien.io.table import numbers, ranges
from mien.io.timecode import seconds, timecodes, timing
from mien.vocabularies import ARKIT_NAMES, arkit_name, match

_HEAD = ("HeadYaw", "HeadPitch", "HeadRoll")
_EYES = tuple(f"{side}Eye{angle}" for side in ("Left", "Right") for angle in ("Yaw", "Pitch", "Roll"))
_HEAD_SIGNS = np.array([1.0, -1.0, -1.0])
_EYE_SIGNS = np.array([-1.0, 1.0, -1.0])


def is_livelink(path: Path) -> bool:
    """Return whether a file has the header of a Live Link Face recording."""
    try:
        start = read_bytes(path)[:4096].decode("utf-8-sig", errors="replace")
    except FileError:
        return False
    columns = [cell.strip().strip('"').lower() for cell in start.split("\n", 1)[0].split(",")]
    return columns[:2] == ["timecode", "blendshapecount"]


def read_clip(path: Path) -> Clip:
    """Read a recording; frames in which the phone lost the face are rows of NaN.

    The head is held still over lost frames; a head that is zero throughout was not
    recorded and is None.  Weights a little outside 0 … 1 are kept.

    Raises:
        FileError: the file is missing, damaged, or not a Live Link Face recording.
    """
    lines = [line for line in read_text(path).splitlines() if line.strip()]
    if not is_livelink(path):
        raise FileError(
            f"{path} is not a Live Link Face recording: its first columns are not Timecode,BlendShapeCount."
        )
    names = [name.strip().strip('"') for name in lines[0].split(",")]
    notes: list[Note] = []
    rows = _whole_rows(lines[1:], len(names), notes, str(path))
    if not rows:
        raise FileError(f"{path} has a header but no frame.")
    fps, start = timing(path, seconds(path, rows), notes)
    lost = [row.count(",") == 1 for row in rows]
    blank = "," * (len(names) - 1)
    table = [blank if gone else row[row.index(",") :] for row, gone in zip(rows, lost, strict=True)]
    values = numbers(path, table, 2, ",", names)
    if any(lost):
        where = np.flatnonzero(lost).tolist()
        message = f"the face was lost in {len(where)} of {len(rows)} frames: {ranges(where)}; they are kept as gaps"
        notes.append(Note("tracking-lost", message, str(path)))
    head, eyes = (_places(names, wanted) for wanted in (_HEAD, _EYES))
    channels = [i for i in range(2, len(names)) if i not in head + eyes]
    try:
        return Clip(
            tuple(arkit_name(names[i]) or names[i] for i in channels),
            values[:, channels],
            fps,
            head=_head(values[:, head], notes, str(path)),
            eyes=_eyes(values[:, eyes]),
            start=start,
            notes=tuple(notes),
        )
    except InputError as error:
        raise FileError(f"{path}: {error}") from None


def write_clip(path: Path, clip: Clip, rig: Rig | None = None) -> None:
    """Write a recording as the phone would: 61 values in its order and its timecode.

    Channels under any spelling go to the ARKit shape they name; left and right halves
    of a shape that ARKit has whole become their mean; other channels are left out.
    Of the head only the rotation is kept.  A frame of NaN is written as a lost one.

    Args:
        path: where to.
        clip: what is written.
        rig: not used; the signature is that of every clip writer.

    Raises:
        InputError: no channel names an ARKit shape, or a frame is only partly known.
        FileError: the file cannot be written.
    """
    del rig
    mapped = match(clip.names, ARKIT_NAMES)
    if len(mapped.unmatched_target) == len(ARKIT_NAMES):
        shown = ", ".join(clip.names[:8]) or "none"
        raise InputError(
            f"none of the clip's {len(clip.names)} channels ({shown} …) names an ARKit shape, and Live Link Face "
            "knows no others; write plain weights, or retarget to a rig with ARKit shapes first."
        )
    weights = mapped.apply(clip.values)
    lost = _lost(weights, np.asarray(mapped.matrix.any(axis=1)))
    table = np.hstack([weights, _head_angles(clip), _eye_angles(clip)])
    table[np.isnan(table)] = 0.0
    row_format = ",".join(["%.10f"] * table.shape[1])
    header = ",".join(["Timecode", "BlendShapeCount", *(n[0].upper() + n[1:] for n in ARKIT_NAMES), *_HEAD, *_EYES])
    rows = [
        f"{code},0" if gone else f"{code},{table.shape[1]},{row_format % tuple(row)}"
        for code, gone, row in zip(timecodes(clip), lost, (table + 0.0).tolist(), strict=True)
    ]
    with written_whole(path) as temporary:
        temporary.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8", newline="")


def _whole_rows(lines: list[str], width: int, notes: list[Note], where: str) -> list[str]:
    """Return the rows, without a last one that was cut short."""
    if lines and lines[-1].count(",") + 1 not in {2, width}:
        cells = lines[-1].count(",") + 1
        notes.append(Note("truncated-row", f"the last row has {cells} of {width} cells and is left out", where))
        return lines[:-1]
    return lines


def _places(names: list[str], wanted: tuple[str, ...]) -> list[int]:
    """Return the columns of these names, none unless all are there."""
    place = {name.lower(): i for i, name in enumerate(names)}
    return [place[name.lower()] for name in wanted] if all(name.lower() in place for name in wanted) else []


def _head(angles: Floats, notes: list[Note], where: str) -> Floats | None:
    seen = np.flatnonzero(~np.isnan(angles).any(axis=1))
    if not angles.size or not len(seen):
        return None
    if not np.nan_to_num(angles).any():
        notes.append(
            Note("head-not-recorded", "the head's rotation is zero in every frame: it was not recorded", where)
        )
        return None
    last = np.maximum(np.searchsorted(seen, np.arange(len(angles)), side="right") - 1, 0)
    return _matrices(angles[seen[last]] * _HEAD_SIGNS)


def _eyes(angles: Floats) -> Floats | None:
    if np.isnan(angles).all():
        return None
    return np.asarray(angles.reshape(-1, 2, 3) * _EYE_SIGNS)


def _head_angles(clip: Clip) -> Floats:
    return np.zeros((len(clip), 3)) if clip.head is None else _angles(clip.head) * _HEAD_SIGNS


def _eye_angles(clip: Clip) -> Floats:
    return np.zeros((len(clip), 6)) if clip.eyes is None else (clip.eyes * _EYE_SIGNS).reshape(-1, 6)


def _lost(weights: Floats, driven: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which frames have no weight at all among the driven shapes; a frame with some is refused."""
    gaps = np.isnan(weights) & driven
    lost: NDArray[np.bool_] = gaps.sum(axis=1) == driven.sum()
    partly = gaps.any(axis=1) & ~lost
    if partly.any():
        frame = int(np.argmax(partly))
        channel = ARKIT_NAMES[int(np.argmax(gaps[frame]))]
        raise InputError(f"frame {frame} lacks a value for {channel!r} but has others; fill the gaps before writing.")
    return lost


def _matrices(angles: Floats) -> Floats:
    """Return `(F, 4, 4)` rotations R_y(yaw) R_x(pitch) R_z(roll) of `(F, 3)` yaw, pitch, roll [rad]."""
    (sy, sx, sz), (cy, cx, cz) = np.sin(angles).T, np.cos(angles).T
    matrices = np.tile(np.eye(4), (len(angles), 1, 1))
    matrices[:, 0, :3] = np.stack([cy * cz + sy * sx * sz, sy * sx * cz - cy * sz, sy * cx], axis=1)
    matrices[:, 1, :3] = np.stack([cx * sz, cx * cz, -sx], axis=1)
    matrices[:, 2, :3] = np.stack([cy * sx * sz - sy * cz, sy * sz + cy * sx * cz, cy * cx], axis=1)
    return matrices


def _angles(matrices: Floats) -> Floats:
    """Return `(F, 3)` yaw, pitch, roll [rad] of `(F, 4, 4)` rotations: the inverse of `_matrices`."""
    yaw = np.arctan2(matrices[:, 0, 2], matrices[:, 2, 2])
    pitch = np.arctan2(-matrices[:, 1, 2], np.hypot(matrices[:, 0, 2], matrices[:, 2, 2]))
    roll = np.arctan2(matrices[:, 1, 0], matrices[:, 1, 1])
    return np.stack([yaw, pitch, roll], axis=1)
