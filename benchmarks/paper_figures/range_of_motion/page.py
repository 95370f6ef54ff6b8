"""Puts the measured tables and smaller copies of the pictures into `docs/range-of-motion-figures.md`.

    python -m benchmarks.paper_figures.range_of_motion --out figures --data /path/to/data
    python -m benchmarks.paper_figures.range_of_motion.page --out figures

Everything between `<!-- begin NAME -->` and `<!-- end NAME -->` is made here; the rest is written by hand.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.accuracy.page import filled, table
from benchmarks.paper_figures.rig_transfer.page import measured, shrink
from benchmarks.report import RESULTS, ROOT, Row

PAGE = ROOT / "docs" / "range-of-motion-figures.md"
PICTURES = {
    "figure7-ict-raw": 800,
    "figure7-ict-enhanced": 800,
    "figure8-ict": 800,
    "figure12": 1500,
    "figure13": 1300,
    "figure15": 1500,
    "figure16": 1300,
    "figure17-adult": 900,
    "figure17-toon": 900,
}
"""What is shown, and how wide [pixels]."""
TABLES: Mapping[str, tuple[str, ...]] = {
    "timings": ("face", "preset", "shapes", "markers", "keys", "alignment s", "frames/s"),
    "similarity": (),
}
"""By the mark on the page and the results' name: which columns; all if none is named."""


class Beside(NamedTuple):
    """A table with a column for each character.

    Attributes:
        results: whose.
        lines: what tells the lines apart.
        figures: what stands in a cell, one after the other.
    """

    results: str
    lines: tuple[str, ...]
    figures: tuple[str, ...]


BESIDE: Mapping[str, Beside] = {
    "comparison": Beside("comparison", ("figure", "shapes", "solve"), ("vertex_mm", "gain", "correlation")),
    "closures": Beside("comparison", ("figure", "shapes", "solve"), ("lid_mm", "lip_mm", "jerk")),
    "mouths": Beside("mouths", ("shapes",), ("same shape strongest", "its gain", "others' weight over it")),
    "blends": Beside("mouths", ("shapes",), ("off the warp's", "off the actor's")),
    "shapes": Beside("shapes", ("shapes",), ("relative error", "median cosine", "median strength")),
}
"""By the mark on the page."""


def beside(document: Row, lines: tuple[str, ...], figures: tuple[str, ...]) -> str:
    """Return a table of results with a column for each character."""
    rows = document["rows"]
    characters = list(dict.fromkeys(row["character"] for row in rows))
    cells = {(*(row[key] for key in lines), row["character"]): _cell(row, figures) for row in rows}
    kinds = dict.fromkeys(key[:-1] for key in cells)
    shown = [[*kind, *(cells.get((*kind, character), "–") for character in characters)] for kind in kinds]
    machine = document["machine"]
    source = f"{document['about']}; measured at commit {machine['commit']}, {machine['time'][:10]}."
    return f"{source} In each cell: {', '.join(figures)}.\n\n{table([*lines, *characters], shown)}"


def _cell(row: Row, figures: tuple[str, ...]) -> str:
    return " / ".join(f"{row[key]:.2f}" if np.isfinite(row.get(key, np.nan)) else "–" for key in figures)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder the figures were written to")
    args = parser.parse_args()
    page = PAGE.read_text(encoding="utf-8")
    for mark, columns in TABLES.items():
        page = filled(page, mark, measured(f"range_of_motion_{mark}", columns))
    for mark, (results, lines, figures) in BESIDE.items():
        document = json.loads((RESULTS / f"range_of_motion_{results}.json").read_text(encoding="utf-8"))
        page = filled(page, mark, beside(document, lines, figures))
    PAGE.write_text(page, encoding="utf-8")
    for name, width in PICTURES.items():
        if (args.out / f"{name}.png").is_file():
            shrink(args.out / f"{name}.png", ROOT / "docs" / "pictures" / f"rom-{name}.png", width)
    print(f"filled in {PAGE}")


if __name__ == "__main__":
    main()
