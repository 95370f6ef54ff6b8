"""The benchmark as a file: what was measured, where, and from what commit."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mien.core import FileError, InputError
from mien.evaluate.bench.figures import Spread
from mien.evaluate.bench.machine import machine
from mien.evaluate.bench.run import REFERENCE, Line, Scened
from mien.evaluate.bench.table import Entrant, Scene
from mien.io.files import read_text, written_whole

FORMAT = "mien-bench"
VERSION = 1

Document = dict[str, Any]


def begun(suite: str, before: Document | None = None) -> Document:
    """Return a document of nothing yet, or what another run of the same suite left unfinished.

    Args:
        suite: what is run, in words.
        before: the unfinished document.

    Raises:
        InputError: it is of another suite or another commit, whose figures are no part of this run's.
    """
    found: Document = {
        "format": FORMAT,
        "version": VERSION,
        "suite": suite,
        "seconds": 0.0,
        "machine": machine(),
        "reference": REFERENCE,
        "crossings_of_the_truth": {},
        "rows": [],
    }
    if before is None:
        return found
    theirs, mine = ((d["suite"], d["machine"]["commit"], d["machine"]["cpu"]) for d in (before, found))
    if theirs != mine:
        raise InputError(
            f"the run to resume was {' at commit '.join(theirs[:2])} on {theirs[2]}, and this one is "
            f"{' at commit '.join(mine[:2])} on {mine[2]}; start afresh without --resume."
        )
    kept = ("seconds", "crossings_of_the_truth", "rows")
    return found | {key: before[key] for key in kept}


def extended(found: Document, played: Scened, seconds: float) -> Document:
    """Return a document with another scene, ready for JSON: no NaN, four digits.

    Args:
        found: what is known so far.
        played: the scene.
        seconds: how long it took.
    """
    scene, rows = played.scene, [_row(line) for line in played.lines]
    again = {row_key(row) for row in rows}
    return found | {
        "seconds": round(found["seconds"] + seconds, 1),
        "crossings_of_the_truth": found["crossings_of_the_truth"] | {scene.name: _number(played.witness.crossings)},
        "rows": [*(row for row in found["rows"] if row_key(row) not in again), *rows],
    }


def lacking(found: Document, suite: Sequence[Scene], methods: Sequence[Entrant]) -> tuple[Scene, ...]:
    """Return the scenes of a suite of which a document lacks a row."""
    known = {row_key(row) for row in found["rows"]}
    wanted = {scene: [row_key(scene.row(entrant.name)._asdict()) for entrant in methods] for scene in suite}
    return tuple(scene for scene in suite if not known.issuperset(wanted[scene]))


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
    rows, where = content.get("rows"), content.get("machine")
    whole = set(content) >= HEAD and isinstance(where, dict) and {"commit", "cpu"} <= set(where)
    if not whole or not isinstance(rows, list) or not all(isinstance(r, dict) and set(r) >= KEYS for r in rows):
        raise FileError(
            f"{path} lacks {', '.join(sorted(HEAD))}, or rows with {', '.join(sorted(KEYS))}. "
            f"Make it with: mien bench --json {path}"
        )
    return content


HEAD = {"suite", "seconds", "machine", "reference", "crossings_of_the_truth", "rows"}
NAMED = ("method", "performance", "character", "conditions")
KEYS = {"method", "performance", "character", "conditions", "identities", "figures", "absolute"}


def row_key(row: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return what tells a row from all others: method, scene and who acted."""
    return (*(row[name] for name in NAMED), tuple(row["identities"]))


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
