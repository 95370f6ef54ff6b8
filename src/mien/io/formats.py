"""Every file format mien knows, one row each.

The command line's choices, the documentation's table and the contract tests read
`FORMATS`.  A new format is one file in this folder and one row here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mien.core import Clip, FileError, Markers, Rig
from mien.io import c3d, gltf, livelink, makehuman, npz, obj, trc, weights


@dataclass(frozen=True)
class Format:
    """One file format: what can be read from it and written to it.

    Attributes:
        name: a short identifier.
        suffixes: lower-case file suffixes; the first is the usual one.
        about: one line for tables.
        claims: whether a path of this suffix is really of this format (told by its content).
    """

    name: str
    suffixes: tuple[str, ...]
    about: str
    read_rig: Callable[[Path], Rig] | None = None
    read_clip: Callable[[Path], Clip] | None = None
    read_markers: Callable[[Path], Markers] | None = None
    write_clip: Callable[[Path, Clip, Rig | None], None] | None = None
    claims: Callable[[Path], bool] = lambda path: True


FORMATS: tuple[Format, ...] = (
    Format(
        "gltf",
        (".glb", ".gltf"),
        "meshes with blendshapes, skins and animation",
        read_rig=gltf.read_rig,
        read_clip=gltf.read_clip,
        write_clip=gltf.write_clip,
    ),
    Format("obj", ("", ".obj"), "a folder: the neutral and one file per shape", read_rig=obj.read_rig),
    Format(
        "makehuman", (".mhskel",), "MakeHuman bones, with their mesh and weights beside", read_rig=makehuman.read_rig
    ),
    Format("c3d", (".c3d",), "optical markers, binary", read_markers=c3d.read_markers),
    Format("trc", (".trc",), "optical markers, text", read_markers=trc.read_markers),
    Format(
        "livelink",
        (".csv",),
        "Live Link Face: 52 weights, head and eyes",
        read_clip=livelink.read_clip,
        write_clip=livelink.write_clip,
        claims=livelink.is_livelink,
    ),
    Format(
        "weights",
        (".csv",),
        "frame, time and one column per channel",
        read_clip=weights.read_clip,
        write_clip=weights.write_clip,
    ),
    Format("npz", (".npz",), "NumPy arrays of channels", read_clip=npz.read_clip, write_clip=npz.write_clip),
)


def format_of(path: Path | str) -> Format:
    """Return the row for a path, told by its suffix and, where that is shared, its content.

    Raises:
        FileError: no format has that suffix.
    """
    path = Path(path)
    suffix = "" if path.is_dir() else path.suffix.lower()
    for row in FORMATS:
        if suffix in row.suffixes and (not path.exists() or row.claims(path)):
            return row
    known = ", ".join(sorted({s for row in FORMATS for s in row.suffixes if s}))
    raise FileError(
        f"{path}: no format has the suffix {suffix or '(none)'!r}. Known suffixes: {known}, or a folder of .obj."
    )


def read_rig(path: Path | str) -> Rig:
    """Read a character: mesh, blendshapes, skin.

    Raises:
        FileError: the file is missing, damaged, or holds no mesh.
    """
    path = Path(path)
    row = format_of(path)
    if row.read_rig is None:
        raise FileError(f"{path} holds {row.about}, not a character; give a .glb, .gltf or a folder of .obj files.")
    return row.read_rig(path)


def read_clip(path: Path | str) -> Clip:
    """Read an animation as channels over time.

    Raises:
        FileError: the file is missing, damaged, or holds no animation.
    """
    path = Path(path)
    row = format_of(path)
    if row.read_clip is None:
        raise FileError(f"{path} holds {row.about}, not weights over time.")
    return row.read_clip(path)


def read_markers(path: Path | str) -> Markers:
    """Read captured markers.

    Raises:
        FileError: the file is missing, damaged, or holds no markers.
    """
    path = Path(path)
    row = format_of(path)
    if row.read_markers is None:
        raise FileError(f"{path} holds {row.about}, not markers.")
    return row.read_markers(path)


def write_clip(path: Path | str, clip: Clip, rig: Rig | None = None, *, to: str | None = None) -> None:
    """Write an animation; `rig` is the character it plays on, needed for meshes.

    Args:
        to: a format's name, where the suffix alone does not decide (`livelink` for .csv).

    Raises:
        FileError: the format cannot hold an animation, or the file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    rows = [r for r in FORMATS if suffix in r.suffixes and r.write_clip and (to is None or r.name == to)]
    rows.sort(key=lambda row: row.name == "livelink")  # .csv means plain weights unless asked otherwise
    if not rows or rows[0].write_clip is None:
        known = ", ".join(sorted({s for row in FORMATS if row.write_clip for s in row.suffixes}))
        raise FileError(f"cannot write {path}: animation is written to {known}.")
    rows[0].write_clip(path, clip, rig)
