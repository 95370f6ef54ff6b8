"""What a take made by the list of docs/calibration-take.md is worth, beside a recorded one.

python -m benchmarks.accuracy.calibration_take
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import numpy as np

from benchmarks.report import RESULTS, ROOT, Row, publish
from mien.core import Clip
from mien.evaluate import run_case
from mien.evaluate.collection import TRAINING, Recipe, made
from mien.vocabularies.arkit import ARKIT_NAMES

FPS = 30
NEUTRAL_S, RAMP_S, HOLD_S, REST_S = 1.0, 0.3, 1.0, 0.5
EXPRESSIONS = (
    "jawOpen",
    "jawLeft",
    "jawRight",
    "jawForward",
    "mouthLeft",
    "mouthRight",
    "mouthPucker",
    "mouthFunnel",
    "mouthSmileLeft mouthDimpleLeft=.3",
    "mouthSmileRight mouthDimpleRight=.3",
    "mouthSmile* cheekSquint*=.6",
    "mouthStretch*",
    "mouthFrown* mouthShrugLower=.3",
    "mouthShrugLower mouthShrugUpper=.7",
    "mouthUpperUp* noseSneer*",
    "mouthLowerDown*",
    "mouthRollUpper mouthRollLower",
    "mouthPress* mouthDimple*",
    "jawOpen=.6 mouthClose=.6",
    "cheekPuff",
    "eyeBlink*",
    "eyeWide* browInnerUp=.6 browOuterUp*=.6",
    "eyeSquint* cheekSquint*",
    "browInnerUp browOuterUp*",
    "browDown*",
    "eyeLookUp*",
    "eyeLookDown*",
    "eyeLookOutLeft eyeLookInRight",
    "eyeLookInLeft eyeLookOutRight",
)
"""The list; a star stands for both sides, a number for what accompanies the expression less strongly."""
RECIPES = (
    Recipe("p1", "ict"),
    Recipe("p1", "toon", spread=0.3),
    Recipe("adult", "ict"),
    Recipe("p1", "adult"),
    Recipe("adult", "child"),
)
SHOWN = ("rmse", "correlation", "gain", "vertex_mm")


def played() -> Clip:
    """Return the list as a take: each expression reached, held and left again."""
    parts = [np.zeros((int(NEUTRAL_S * FPS), len(ARKIT_NAMES)))]
    rise = np.linspace(0, 1, int(RAMP_S * FPS))[:, None]
    for expression in EXPRESSIONS:
        full = weights(expression)
        held = np.repeat(full[None], int(HOLD_S * FPS), axis=0)
        parts += [rise * full, held, rise[::-1] * full, np.zeros((int(REST_S * FPS), len(full)))]
    return Clip(ARKIT_NAMES, np.concatenate(parts), FPS)


def weights(expression: str) -> np.ndarray:
    """Return the weights `(52,)` of one line of the list."""
    full = np.zeros(len(ARKIT_NAMES))
    for word in expression.split():
        name, _, amount = word.partition("=")
        for side in ("Left", "Right") if name.endswith("*") else ("",):
            full[ARKIT_NAMES.index(name.rstrip("*") + side)] = float(amount or 1)
    return full


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    parser.add_argument("--json", type=Path, default=RESULTS / "calibration_take.json", help="where to write")
    args = parser.parse_args()
    rows: list[Row] = []
    for recipe in RECIPES:
        for name, training in ((TRAINING, None), ("list", played())):
            figures = run_case(made(Path(args.data), recipe, 8, training), "range-of-motion")
            for truth in ("absolute", "range"):
                row = {"case": recipe.name, "training": name, "truth": truth}
                rows.append(row | {key: round(float(figures[truth][key]), 4) for key in SHOWN})
    about = f"A calibration take of {len(played()) / FPS:.0f} s by the list, beside a recorded range-of-motion take"
    publish(args.json.stem, about, rows, ["numpy", "scipy"], args.json.parent)


if __name__ == "__main__":
    main()
