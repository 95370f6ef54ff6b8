"""What labelled frames are worth: the quick suite again, with some frames of the training take labelled.

    python -m benchmarks.accuracy.labels
    python -m benchmarks.accuracy.labels --counts 0 10 --draws 1

Frames are those that `mien label` would ask for.  They are labelled with the truth as a person would see it:
in tenths, and off by about a tenth.  Writes `results/accuracy_labels.json`, from which
`python -m benchmarks.accuracy.page` makes the tables of the accuracy page.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.accuracy.__main__ import shown
from benchmarks.report import RESULTS, ROOT, Row, publish
from mien.core import Examples
from mien.evaluate import Case, run_case
from mien.evaluate.collection import QUICK, made
from mien.evaluate.given import chosen_frames
from mien.evaluate.played import FLOOR
from mien.evaluate.suite import compare
from mien.retargeting import make_method

STRIDE = 8
"""The vertex error is measured at every so many frames."""
COUNTS = (0, 5, 10, 20)
DRAWS = 3
METHODS = ("range-of-motion", "latent")
"""`latent` learns from nothing but labels; without any it cannot be fitted."""
REFERENCES = (FLOOR, "rbf", "direct")
TRUTH = "range"
ERROR, STEP = 0.1, 0.1
"""Standard deviation of a person's error, and what they round to."""
SEEN = 0.05
"""What is shown less than this is labelled 0."""


def by_eye(truth: Examples, rng: np.random.Generator) -> Examples:
    """Return labels as a person would give them."""
    off = truth.values + rng.normal(0, ERROR, truth.values.shape)
    values = np.where(truth.values > SEEN, np.clip(np.round(off / STEP) * STEP, 0, 1), 0.0)
    return Examples(truth.frames, truth.names, values)


def run(case: Case, name: str, examples: Examples | None) -> Row:
    """Return the figures of a method that is given these labels."""
    fitted = make_method(name).fit(
        case.character,
        case.training,
        case.pairs,
        neutral=case.neutral,
        head_moves=case.head_moves,
        examples=examples,
    )
    return compare(case, fitted.retarget(case.test)[0], TRUTH)


def rows_of(case: Case, counts: list[int], draws: int) -> Iterator[Row]:
    """Yield the figures of the references, and of every method with every number of labels."""
    for name in REFERENCES:
        yield {"case": case.name, "method": name, "labels": 0, "draw": 0, **shown(run_case(case, name)[TRUTH])}
    for count in counts:
        truth = case.labels(chosen_frames(case, count)) if count else None
        for draw in range(draws if count else 1):
            examples = None if truth is None else by_eye(truth, np.random.default_rng(draw))
            for name in METHODS if count else METHODS[:1]:
                figures = shown(run(case, name, examples))
                yield {"case": case.name, "method": name, "labels": count, "draw": draw, **figures}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", nargs="*", type=int, default=[*COUNTS], help="how many frames are labelled")
    parser.add_argument("--draws", type=int, default=DRAWS, help="how often, each time with other errors")
    parser.add_argument("--data", type=Path, default=os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    args = parser.parse_args()
    rows: list[Row] = []
    for recipe in QUICK:
        for row in rows_of(made(args.data, recipe, STRIDE), args.counts, args.draws):
            rows.append(row)
            print(f"{row['case']}: {row['method']}, {row['labels']} labels, {row['mm']:.2f} mm", flush=True)
    about = f"Accuracy with labelled frames, {len(QUICK)} cases, {args.draws} draws of the labels' errors"
    publish("accuracy_labels", about, rows, ["numpy", "scipy"], RESULTS)


if __name__ == "__main__":
    main()
