"""Clips as NumPy arrays in one file: exact, quick, and readable without mien.

The arrays are `names`, `values`, `fps`, `start` and, where the clip has them, `head`,
`eyes` and `joints`, as `mien.core.Clip` describes them.  Nothing is unpickled, and
every size is checked against the file before memory is taken for it.
"""

from __future__ import annotations

import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import Clip, FileError, InputError, Rig
from mien.io.archive import DAMAGED, array_of
from mien.io.files import read_bytes, written_whole

_REQUIRED = ("names", "values", "fps")
_OPTIONAL = ("head", "eyes", "joints", "start")
_MOST_BYTES = 1 << 30


def read_clip(path: Path) -> Clip:
    """Read a clip.

    Raises:
        FileError: the file is missing, damaged, too large, or not a clip.
    """
    arrays = _arrays(path)
    missing = [name for name in _REQUIRED if name not in arrays]
    if missing:
        held = ", ".join(arrays) or "nothing"
        raise FileError(f"{path} is not a clip: it lacks {', '.join(missing)} and holds {held}.")
    if arrays["names"].dtype.kind != "U" or arrays["names"].ndim != 1:
        raise FileError(
            f"{path}: names must be a list of text, but is {arrays['names'].dtype} {arrays['names'].shape}."
        )
    for name in {*_REQUIRED, *_OPTIONAL} - {"names"}:
        if name in arrays and arrays[name].dtype.kind not in "fiu":
            raise FileError(f"{path}: {name} must hold numbers, but holds {arrays[name].dtype}.")
    for name in ("fps", "start"):
        if name in arrays and (arrays[name].shape != () or not np.isfinite(arrays[name])):
            raise FileError(f"{path}: {name} must be one finite number.")
    try:
        return Clip(
            tuple(arrays["names"].tolist()),
            arrays["values"],
            float(arrays["fps"]),
            head=arrays.get("head"),
            eyes=arrays.get("eyes"),
            joints=arrays.get("joints"),
            start=float(arrays.get("start", np.float64(0))),
        )
    except InputError as error:
        raise FileError(f"{path}: {error}") from None


def write_clip(path: Path, clip: Clip, rig: Rig | None = None) -> None:
    """Write a clip exactly, without its notes.

    Args:
        path: where to.
        clip: what is written.
        rig: not used; the signature is that of every clip writer.

    Raises:
        FileError: the file cannot be written.
    """
    del rig
    arrays: dict[str, Any] = {
        "names": np.array(clip.names, dtype=np.str_),
        "values": clip.values,
        "fps": clip.fps,
        "start": clip.start,
    }
    for name in ("head", "eyes", "joints"):
        if getattr(clip, name) is not None:
            arrays[name] = getattr(clip, name)
    with written_whole(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    content = read_bytes(path)
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            members = {m.filename.removesuffix(".npy"): m for m in archive.infolist() if m.filename.endswith(".npy")}
            wanted = {name: member for name, member in members.items() if name in {*_REQUIRED, *_OPTIONAL}}
            size = sum(member.file_size for member in wanted.values())
            if size > _MOST_BYTES:
                raise FileError(f"{path} unpacks to {size / 2**30:.1f} GiB; clips of more than 1 GiB are not read.")
            return {name: array_of(archive.read(member)) for name, member in wanted.items()}
    except DAMAGED as error:
        raise FileError(f"{path} is not a readable .npz file ({error}); write or download it again.") from None
