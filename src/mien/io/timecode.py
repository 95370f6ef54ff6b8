"""Timecodes of Live Link Face, `hh:mm:ss:ff.mmm`, where `mmm` is thousandths of a frame.

The phone counts `ff` at its camera's 60 frames per second also when it records at
30, so the rate of the recording is not the rate of the timecode: both are told from
how the codes advance.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mien.core import Clip, FileError, Note
from mien.core.arrays import Floats
from mien.io.table import ranges, snapped

_CODE = re.compile(r'\s*"?(\d{1,2})[:;](\d{1,2})[:;](\d{1,2})[:;](\d{1,3})(?:\.(\d{1,9}))?"?\s*$', re.ASCII)
_BASES = (24, 25, 30, 48, 50, 60, 120, 240)
_WRITTEN_BASE = 60
_DAY = 86400


def seconds(path: Path, rows: Sequence[str]) -> tuple[Floats, Floats]:
    """Return whole seconds since midnight and frames within the second of each row's first cell.

    Raises:
        FileError: a cell is not a timecode.
    """
    whole, frames = np.zeros(len(rows)), np.zeros(len(rows))
    for i, row in enumerate(rows):
        cell = row.split(",", 1)[0]
        found = _CODE.match(cell)
        if found is None:
            raise FileError(f"{path}, frame {i}: {cell[:40]!r} is not a timecode hh:mm:ss:ff.mmm.")
        hours, minutes, secs, ff, part = found.groups()
        whole[i] = 3600 * int(hours) + 60 * int(minutes) + int(secs)
        frames[i] = int(ff) + float(f"0.{part or 0}")
    return whole, frames


def timing(path: Path, codes: tuple[Floats, Floats], notes: list[Note]) -> tuple[float, float]:
    """Return frames per second and the time of the first frame [s], noting what is doubtful.

    Args:
        path: the file, for notes.
        codes: whole seconds and frames within the second, as from `seconds`.
        notes: where dropped frames and guesses are noted.
    """
    whole, frames = codes
    base = _base(whole, frames)
    time = whole + frames / base
    start = float(time[0])
    if len(time) < 2:
        notes.append(Note("fps-assumed", "one frame does not tell a frame rate; 60 is assumed", str(path)))
        return 60.0, start
    steps = np.diff(time)
    steps[steps < -_DAY / 2] += _DAY
    typical = float(np.median(steps))
    if not typical > 0:
        notes.append(Note("fps-assumed", "the timecodes do not advance; 60 frames per second are assumed", str(path)))
        return 60.0, start
    if not np.any(np.diff(whole)):
        notes.append(
            Note("fps-assumed", "the take is shorter than a second; its timecode is taken to be at 60", str(path))
        )
    missed = np.rint(steps / typical) - 1
    if np.any(missed != 0):
        odd = np.flatnonzero(missed != 0)
        count = int(missed[missed > 0].sum())
        message = f"the timecode skips {count} frames, before {ranges((odd + 1).tolist())}; they are not filled in"
        notes.append(Note("frames-dropped", message, str(path)))
    steady = steps[missed == 0]
    return snapped(1 / float(steady.mean() if len(steady) else typical), 0.02), start


def timecodes(clip: Clip) -> list[str]:
    """Return the timecode of each frame, at 60 frames per second as the phone writes it."""
    thousandths = np.rint((clip.start + np.arange(len(clip)) / clip.fps) * _WRITTEN_BASE * 1000).astype(np.int64)
    frames, part = np.divmod(thousandths % (_DAY * _WRITTEN_BASE * 1000), 1000)
    secs, ff = np.divmod(frames, _WRITTEN_BASE)
    minutes, secs = np.divmod(secs, 60)
    hours, minutes = np.divmod(minutes, 60)
    columns = zip(*(c.tolist() for c in (hours, minutes, secs, ff, part)), strict=True)
    return [f"{h:02d}:{m:02d}:{s:02d}:{f:02d}.{p:03d}" for h, m, s, f, p in columns]


def _base(whole: Floats, frames: Floats) -> int:
    """Return the rate at which the timecode counts: the least usual one above its highest frame number."""
    if not np.any(np.diff(whole)):
        return max(_WRITTEN_BASE, int(frames.max()) + 1)
    highest = int(frames.max())
    return next((base for base in _BASES if base > highest), highest + 1)
