"""Damaged copies of a file, for the test every reader must pass: only a MienError, ever."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from mien.core import MienError

PAGES = (
    b"<!DOCTYPE html><html><body>404</body></html>",
    b"\0" * 2000,
    b"\xff\xfe" * 600,
    b"\n\n\n",
    b"a",
    b"v v v\nf f f\n",
)


def damaged(content: bytes, rng: np.random.Generator, count: int = 60) -> Iterator[bytes]:
    """Yield cut, overwritten and replaced versions of a file's content."""
    yield from PAGES
    yield bytes(rng.integers(0, 256, 3000, dtype=np.uint8))
    for cut in np.linspace(1, len(content) - 1, count).astype(int):
        yield content[:cut]
    for _ in range(count):
        changed = np.frombuffer(content, dtype=np.uint8).copy()
        places = rng.integers(0, min(len(changed), 1500), 5)
        changed[places] = rng.integers(0, 256, 5)
        yield changed.tobytes()


def survives(read: Callable[[Path], object], path: Path, rng: np.random.Generator) -> None:
    """Read damaged versions of the file at `path`; anything but success or a MienError fails the test."""
    refused: list[str] = []
    content = path.read_bytes()
    for version in damaged(content, rng):
        path.write_bytes(version)
        try:
            read(path)
        except MienError as error:
            refused.append(str(error))
    path.write_bytes(content)
    read(path)
    assert len(refused) >= len(PAGES)
    assert [said for said in refused if str(path.parent) not in said] == []
