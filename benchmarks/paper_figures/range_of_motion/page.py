"""Puts the measured tables and smaller copies of the pictures into `docs/range-of-motion-figures.md`.

    python -m benchmarks.paper_figures.range_of_motion --out figures --data /path/to/data
    python -m benchmarks.paper_figures.range_of_motion.page --out figures

Everything between `<!-- begin NAME -->` and `<!-- end NAME -->` is made here; the rest is written by hand.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from benchmarks.accuracy.page import filled
from benchmarks.paper_figures.rig_transfer.page import measured, shrink
from benchmarks.report import RESULTS, ROOT

PAGE = ROOT / "docs" / "range-of-motion-figures.md"
PICTURES = {
    "figure7-ict-raw": 800,
    "figure7-ict-enhanced": 800,
    "figure8-cartoon": 800,
    "figure12": 1500,
    "figure13": 1200,
    "figure15": 1500,
    "figure16": 1300,
    "figure17-cartoon": 900,
}
"""What is shown, and how wide [pixels]."""
TABLES: Mapping[str, tuple[str, ...]] = {
    "timings": ("face", "preset", "shapes", "markers", "keys", "alignment s", "frames/s"),
    "similarity": (),
    "comparison": (),
    "mouths": (),
    "shapes": (),
}
"""By the mark on the page and the results' name: which columns; all if none is named."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder the figures were written to")
    args = parser.parse_args()
    page = PAGE.read_text(encoding="utf-8")
    for mark, columns in TABLES.items():
        if (RESULTS / f"range_of_motion_{mark}.json").is_file():
            page = filled(page, mark, measured(f"range_of_motion_{mark}", columns))
    PAGE.write_text(page, encoding="utf-8")
    for name, width in PICTURES.items():
        if (args.out / f"{name}.png").is_file():
            shrink(args.out / f"{name}.png", ROOT / "docs" / "pictures" / f"rom-{name}.png", width)
    print(f"filled in {PAGE}")


if __name__ == "__main__":
    main()
