"""The benchmark as a file: what was measured, where, and from what commit."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mien.core import FileError
from mien.evaluate.bench.figures import Spread
from mien.evaluate.bench.machine import machine
from mien.evaluate.bench.run import REFERENCE, Line, Scened
from mien.io.files import read_text, written_whole

FORMAT = "mien-bench"
VERSION = 1

Document = dict[str, Any]


def document(suite: str, scenes: Sequence[Scened], seconds: float) -> Document:
    """Return what a run found, ready for JSON: no NaN, four digits.

    Args:
        suite: what was run, in words.
        scenes: the scenes played.
        seconds: how long it took.
    """
    return {
        "format": FORMAT,
        "version": VERSION,
        "suite": suite,
        "seconds": round(seconds, 1),
        "machine": machine(),
        "reference": REFERENCE,
        "crossings_of_the_truth": {s.scene.name: _number(s.witness.crossings) for s in scenes},
        "rows": [_row(line) for s in scenes for line in s.lines],
    }


def write(path: Path, content: Document) -> None:
    """Write a document as JSON.

    Raises:
        FileError: it cannot be written.
    """
    with written_whole(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def read(path: Path) -> Document:
    """Read a document.

    Raises:
        FileError: the file is missing, or is no benchmark of this version.
    """
    try:
        content = json.loads(read_text(path))
    except ValueError as error:
        raise FileError(f"{path} is not JSON: {error}. Make it with: mien bench --json {path}") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT or content.get("version") != VERSION:
        raise FileError(f"{path} is no {FORMAT} of version {VERSION}. Make it with: mien bench --json {path}")
    rows = content.get("rows")
    if not isinstance(rows, list) or not all(isinstance(r, dict) and set(r) >= KEYS for r in rows):
        raise FileError(f"{path} lacks rows with {', '.join(sorted(KEYS))}. Make it with: mien bench --json {path}")
    return content


KEYS = {"method", "performance", "character", "conditions", "identities", "figures", "absolute"}


def _row(line: Line) -> Document:
    row: Document = dict(line.row._asdict())
    row |= {"identities": list(line.row.identities), "given": line.given}
    if line.failed:
        row["failed"] = line.failed
    row["figures"], row["absolute"] = _spreads(line.figures), _spreads(line.absolute)
    return row | {"time_ratio": _number(line.time_ratio)}


def _spreads(figures: Mapping[str, Spread]) -> Document:
    return {
        key: {name: _number(value) for name, value in spread._asdict().items()}
        for key, spread in figures.items()
        if math.isfinite(spread.mean)
    }


def _number(value: float) -> float | None:
    return float(f"{value:.5g}") if math.isfinite(value) else None
