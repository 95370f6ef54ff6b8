"""Puts the measured tables and smaller copies of the pictures into `docs/rig-transfer.md`.

    python -m benchmarks.paper_figures.rig_transfer --out figures
    python -m benchmarks.speed.rig_transfer
    python -m benchmarks.rigging.ground_truth
    python -m benchmarks.paper_figures.rig_transfer.page --out figures

Everything between `<!-- begin NAME -->` and `<!-- end NAME -->` is made here; the rest is written by hand.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from PIL import Image

from benchmarks.accuracy.page import filled, table
from benchmarks.report import RESULTS, ROOT

PAGE = ROOT / "docs" / "rig-transfer.md"
PICTURES = {
    "expressions": 1150,
    "correspondence-cartoon": 1100,
    "muscles": 900,
    "muscle-distances": 1200,
    "attributes": 1100,
    "elsewhere": 1300,
}
"""What is shown, and how wide [pixels]."""
TABLES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "correspondence": (
        "rig_transfer_correspondence",
        (
            "face",
            "landmarks",
            "warp misses",
            "stuck misses",
            "off the surface",
            "folds before",
            "folds after",
            "triangles",
            "stuck rms mm",
            "without place",
        ),
    ),
    "muscles": (
        "rig_transfer_muscles",
        ("face", "carried by", "correlation", "relative RMS", "mean error mm", "95 % mm", "on the other side"),
    ),
    "expressions": (
        "rig_transfer_expressions",
        ("face", "landmarks", "joy", "surprise", "viseme_aa", "lids at rest", "lids left open", "worst"),
    ),
    "attributes": (
        "rig_transfer_attributes",
        ("face", "sums off by", "influences", "labels", "of", "jaw there and back", "95 %", "labels there and back"),
    ),
    "decimated": (
        "rig_transfer_decimated",
        ("head", "vertices", "copy's", "landmarks", "copy off %", "skin to copy %", "copy to skin %", "place %"),
    ),
    "elsewhere": ("rig_transfer_elsewhere", ()),
    "truth": (
        "rigging_ground_truth",
        ("pair", "method", "shapes", "cos", "cos min", "gain", "lids mm", "lips mm", "other side", "cpu s"),
    ),
    "folds": ("rigging_folds", ()),
    "speed": ("speed_rig_transfer", ()),
}
"""By the mark on the page: which results, and which of their columns; all if none is named."""


def shrink(source: Path, target: Path, width: int) -> None:
    """Write a picture no wider than `width`, in 256 colours."""
    with Image.open(source) as picture:
        wide = min(width, picture.width)
        small = picture.convert("RGB").resize((wide, picture.height * wide // picture.width), Image.Resampling.LANCZOS)
    few = small.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=3, dither=Image.Dither.NONE)
    few.save(target, optimize=True)


def measured(name: str, columns: tuple[str, ...]) -> str:
    """Return the table of a benchmark's results, with where they come from."""
    document = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    shown = columns or tuple(dict.fromkeys(key for row in document["rows"] for key in row))
    rows = [[_text(row.get(column, "")) for column in shown] for row in document["rows"]]
    machine = document["machine"]
    source = f"{document['about']}; measured at commit {machine['commit']}, {machine['time'][:10]}."
    return f"{source}\n\n{table(shown, rows)}"


def _text(value: Any) -> str:
    if not isinstance(value, float):
        return str(value).strip().replace(">", "→")
    return f"{value:.0e}" if 0 < abs(value) < 1e-6 else f"{value:.3g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder the figures were written to")
    args = parser.parse_args()
    page = PAGE.read_text(encoding="utf-8")
    for mark, (name, columns) in TABLES.items():
        if (RESULTS / f"{name}.json").is_file():
            page = filled(page, mark, measured(name, columns))
    PAGE.write_text(page, encoding="utf-8")
    for name, width in PICTURES.items():
        if (args.out / f"{name}.png").is_file():
            shrink(args.out / f"{name}.png", ROOT / "docs" / "pictures" / f"rig-{name}.png", width)
    print(f"filled in {PAGE}")


if __name__ == "__main__":
    main()
