"""Arrays and a JSON header in one zip: how fitted models are kept.

Nothing is unpickled, so reading a file from elsewhere cannot run code; every size is
checked against the file before memory is taken for it.
"""

from __future__ import annotations

import json
import zipfile
import zlib
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from mien.core import FileError
from mien.io.files import read_bytes, written_whole

HEADER = "header.json"
MOST_BYTES = 1 << 30
DAMAGED = (ValueError, TypeError, EOFError, OSError, RuntimeError, SyntaxError, zipfile.BadZipFile, zlib.error)
"""What the standard library raises on damaged archives."""


def write_archive(path: Path, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays and a header, whole or not at all.

    Raises:
        FileError: the file cannot be written.
    """
    with written_whole(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(HEADER, json.dumps(header, indent=1, ensure_ascii=False))
        for name, array in arrays.items():
            stream = BytesIO()
            npy.write_array(stream, np.ascontiguousarray(array), allow_pickle=False)
            archive.writestr(f"{name}.npy", stream.getvalue())


def read_archive(path: Path, format_name: str, version: int) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Read a header and arrays.

    Args:
        path: the file.
        format_name: what the header must say it is.
        version: the version it must have.

    Raises:
        FileError: the file is missing, damaged, too large, or something else.
    """
    content = read_bytes(path)
    try:
        with zipfile.ZipFile(BytesIO(content)) as archive:
            members = archive.infolist()
            size = sum(member.file_size for member in members)
            if size > MOST_BYTES:
                raise FileError(f"{path} unpacks to {size / 2**30:.1f} GiB; more than 1 GiB is not read.")
            if HEADER not in archive.namelist():
                raise FileError(f"{path} is a zip file, but not a {format_name}: it has no {HEADER}.")
            header = json.loads(archive.read(HEADER))
            named = [m for m in members if m.filename.endswith(".npy")]
            arrays = {m.filename.removesuffix(".npy"): array_of(archive.read(m)) for m in named}
    except (*DAMAGED, RecursionError) as error:
        raise FileError(f"{path} is not a readable {format_name} file ({error}); make or download it again.") from None
    if not isinstance(header, dict) or header.get("format") != format_name:
        raise FileError(f"{path} is not a {format_name} file.")
    if header.get("version") != version:
        raise FileError(
            f"{path} is version {header.get('version')!r} of {format_name}; this mien reads version {version}. Fit it again."
        )
    return header, arrays


def array_of(content: bytes) -> NDArray[Any]:
    """Return the array of one `.npy` member, once its header agrees with its size.

    Raises:
        ValueError: it does not, or it would need unpickling.
    """
    stream = BytesIO(content)
    version = npy.read_magic(stream)
    read_header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = read_header(stream)
    wanted = int(dtype.itemsize)
    for n in shape:
        wanted *= int(n)
    if dtype.hasobject or wanted != len(content) - stream.tell():
        raise ValueError(f"an array of shape {shape} and type {dtype} does not fit its {len(content)} bytes")
    stream.seek(0)
    return np.asarray(npy.read_array(stream, allow_pickle=False))
