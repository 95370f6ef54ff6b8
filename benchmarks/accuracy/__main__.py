"""Methods on the accuracy suite, beside the baselines and the floor.

    python -m benchmarks.accuracy --quick
    python -m benchmarks.accuracy --quick --methods floor rbf range-of-motion --set sparsity=0.02
    python -m benchmarks.accuracy --cases toon apfel --json toon.json
    python -m benchmarks.accuracy --every 3

The cases need the real rigs and recordings (`MIEN_DATA`, or `--data`); without them only
the embedded ones are run.  `floor` is the actor's true shapes in the same solve,
`deformation-transfer` the character's shapes moved onto the actor's mesh, which no method
sees, and `paper` the range-of-motion method as published.  Methods that learn from labels
are measured by `mien bench`, or if named.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from benchmarks.report import RESULTS, ROOT, Row, publish
from mien.evaluate import Case, embedded_cases, run_case, run_suite, summary
from mien.evaluate.collection import FULL, QUICK, made
from mien.evaluate.played import REFERENCES
from mien.evaluate.suite import TRUTHS

STRIDE = 4
"""The vertex error, which takes longest, is measured at every so many frames."""
PAPER = "paper"
UNLABELLED = ("range-of-motion", "spacetime", "example-based", "direct", "rbf", "copy")
"""The methods that need nothing but takes and pairs (and names, `copy`)."""
SHOWN = {
    "rmse": "rmse",
    "correlation": "corr",
    "correlation_each": "each",
    "gain": "gain",
    "vertex_mm": "mm",
    "vertex_p95_mm": "p95",
    "lid_mm": "lids",
    "lip_mm": "lips",
    "jerk": "jerk",
    "other_side": "other",
    "shapes": "shapes",
    "closed": "closed",
    "worse": "worse",
}
"""Figures in the table, and what their columns are called."""


def chosen_cases(folder: Path, quick: bool, every: int, wanted: list[str]) -> Iterator[Case]:
    """Make every so many of the cases whose names hold all the wanted words, one at a time."""
    if not (folder / "rigs").is_dir() or (wanted and "library" in wanted):
        yield from embedded_cases(STRIDE)
        return
    named = [r for r in (QUICK if quick else FULL) if all(word in r.name for word in wanted)]
    for recipe in named[::every]:
        yield made(folder, recipe, STRIDE)


def run_paper(case: Case) -> Row:
    """Run the method as published."""
    return run_case(case, "range-of-motion", {"preset": "paper"}) | {"method": PAPER}


def lines(rows: list[Row]) -> list[Row]:
    """Return one line per result and truth."""
    return [
        {"case": row["case"], "method": row["method"], "truth": truth, **shown(row[truth]), "active": row["active"]}
        for row in rows
        for truth in TRUTHS
    ]


def shown(figures: Row) -> Row:
    return {title: round(float(figures[key]), 4) for key, title in SHOWN.items() if key in figures}


def assignment(text: str) -> tuple[str, Any]:
    key, _, value = text.partition("=")
    if "," in value:
        return key, tuple(float(part) for part in value.split(","))
    return key, value


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help=f"{len(QUICK)} cases and not all {len(FULL)}")
    parser.add_argument("--every", type=int, default=1, help="only every so many of the cases")
    parser.add_argument("--cases", nargs="*", default=[], help="only cases whose names hold all these words")
    parser.add_argument("--methods", nargs="*", default=[*REFERENCES, *UNLABELLED, PAPER], help="which methods")
    parser.add_argument("--set", nargs="*", default=[], type=assignment, dest="settings", help="KEY=VALUE of methods")
    parser.add_argument("--data", type=Path, default=os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    parser.add_argument("--json", type=Path, help="where to write the results")
    args = parser.parse_args()

    def say(row: Row) -> None:
        figures = row["range"]
        print(f"{row['case']}: {row['method']} {figures['vertex_mm']:.2f} mm, gain {figures['gain']:.2f}", flush=True)

    methods = [name for name in args.methods if name != PAPER]
    rows: list[Row] = []
    for case in chosen_cases(Path(args.data), args.quick, args.every, args.cases):
        rows += run_suite([case], methods, dict(args.settings), say)
        if PAPER in args.methods:
            rows.append(run_paper(case))
            say(rows[-1])
    means = [
        {"method": r["method"], "truth": t, "cases": r["cases"], **shown(r)} for t in TRUTHS for r in summary(rows, t)
    ]
    out = args.json or RESULTS / ("accuracy_quick.json" if args.quick else "accuracy.json")
    about = f"Accuracy against known truths, {len({row['case'] for row in rows})} cases, settings {dict(args.settings)}"
    publish(out.stem, about, [*lines(rows), *({"case": "all", **row} for row in means)], ["numpy", "scipy"], out.parent)


if __name__ == "__main__":
    main()
