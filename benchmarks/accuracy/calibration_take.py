"""What a take made by the list of docs/calibration-take.md is worth, beside a recorded one.

python -m benchmarks.accuracy.calibration_take

Once as it is, and once labelled as `mien label --list` labels it, by what is recognised in it.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import numpy as np

from benchmarks.report import RESULTS, ROOT, Row, publish
from mien.core import Clip, Examples
from mien.evaluate import Case, run_case
from mien.evaluate.collection import TRAINING, Recipe, made
from mien.evaluate.played import FLOOR
from mien.evaluate.suite import TRUTHS, compare
from mien.job.label_list import labels_of
from mien.retargeting import make_method
from mien.retargeting.listed import recognise
from mien.vocabularies.arkit import ARKIT_NAMES
from mien.vocabularies.calibration import list_weights

FPS = 30
NEUTRAL_S, RAMP_S, HOLD_S, REST_S = 1.0, 0.3, 1.0, 0.5
RECIPES = (
    Recipe("p1", "ict"),
    Recipe("p1", "toon", spread=0.3),
    Recipe("adult", "ict"),
    Recipe("p1", "adult"),
    Recipe("adult", "child"),
)
SHOWN = ("rmse", "correlation", "gain", "vertex_mm", "lid_mm")
METHODS = (FLOOR, "rbf", "range-of-motion")
LABELLED = {"full_range": False}
"""Where all is labelled, strength is what the labels say, not the range of the take."""


def played() -> Clip:
    """Return the list as a take: each expression reached, held and left again."""
    parts = [np.zeros((int(NEUTRAL_S * FPS), len(ARKIT_NAMES)))]
    rise = np.linspace(0, 1, int(RAMP_S * FPS))[:, None]
    for full in list_weights():
        held = np.repeat(full[None], int(HOLD_S * FPS), axis=0)
        parts += [rise * full, held, rise[::-1] * full, np.zeros((int(REST_S * FPS), len(full)))]
    return Clip(ARKIT_NAMES, np.concatenate(parts), FPS)


def labels_for(case: Case) -> Examples:
    """Return the labels that the list's order tells, for the expressions that are recognised in a case's training."""
    names = case.character.blendshapes.names
    weights = labels_of(names)
    listed = recognise(case.prepared, np.nan_to_num(weights))
    return Examples(listed.frames, names, weights[listed.entries])


def labelled(case: Case) -> Row:
    """Return the figures of the default that is given those labels, by truth."""
    examples, moves = labels_for(case), case.head_moves
    method = make_method("range-of-motion", LABELLED)
    fitted = method.fit(
        case.character, case.training, case.pairs, neutral=case.neutral, head_moves=moves, examples=examples
    )
    clip = fitted.retarget(case.test)[0]
    return {"labels": len(examples.frames), **{truth: compare(case, clip, truth) for truth in TRUTHS}}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    parser.add_argument("--json", type=Path, default=RESULTS / "calibration_take.json", help="where to write")
    args = parser.parse_args()
    rows: list[Row] = []
    for recipe in RECIPES:
        recorded, played_list = (made(Path(args.data), recipe, 8, training) for training in (None, played()))
        results = {(TRAINING, method): run_case(recorded, method) for method in METHODS}
        results |= {("list", method): run_case(played_list, method) for method in METHODS}
        results["list, labelled", "range-of-motion"] = labelled(played_list)
        for (training, method), figures in results.items():
            for truth in TRUTHS:
                row = {"case": recipe.name, "training": training, "method": method, "truth": truth}
                shown = {key: round(float(figures[truth][key]), 4) for key in SHOWN}
                rows.append(row | shown | {"labels": figures.get("labels", 0)})
    about = f"A calibration take of {len(played()) / FPS:.0f} s by the list, beside a recorded range-of-motion take"
    publish(args.json.stem, about, rows, ["numpy", "scipy"], args.json.parent)


if __name__ == "__main__":
    main()
