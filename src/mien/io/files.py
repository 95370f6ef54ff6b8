"""Opening files politely and writing them whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mien.core.errors import FileError


def read_bytes(path: Path) -> bytes:
    """Return the content of a file.

    Raises:
        FileError: it is missing, a folder, empty, unreadable, or a web page saved under another name.
    """
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        near = sorted(p.name for p in path.parent.glob(f"*{path.suffix}"))[:8] if path.parent.is_dir() else []
        hint = f" In {path.parent}/ there is: {', '.join(near)}." if near else ""
        raise FileError(f"{path} does not exist.{hint}") from None
    except IsADirectoryError:
        raise FileError(f"{path} is a folder; a file is needed here.") from None
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror}.") from None
    if not content:
        raise FileError(f"{path} is empty (0 bytes); export or download it again.")
    start = content[:200].lstrip().lower()
    if path.suffix.lower() not in {".html", ".htm"} and start.startswith((b"<!doctype html", b"<html")):
        raise FileError(
            f"{path} is a web page, not a {path.suffix or 'data'} file: the download failed; fetch it again."
        )
    return content


def read_text(path: Path) -> str:
    """Return the content of a UTF-8 (or Latin-1) text file, without a byte-order mark.

    Raises:
        FileError: as `read_bytes`, or the file is binary.
    """
    content = read_bytes(path)
    if b"\0" in content[:4096]:
        raise FileError(f"{path} is a binary file; text was expected.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path`, renamed onto it when the block succeeds.

    If the block fails nothing is left behind and what stood at `path` stays.

    Raises:
        FileError: the folder does not exist or cannot be written to.
    """
    if not path.parent.is_dir():
        raise FileError(f"cannot write {path}: the folder {path.parent} does not exist; create it first.")
    if path.is_dir():
        raise FileError(f"cannot write {path}: it is a folder.")
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise FileError(f"cannot write in {path.parent}: {error.strerror}.") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
