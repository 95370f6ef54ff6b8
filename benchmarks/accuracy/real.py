"""Methods on real optical captures, where there is no truth: held-out markers, symmetry, closures.

python -m benchmarks.accuracy.real
python -m benchmarks.accuracy.real --takes jaw --characters ict --methods rbf range-of-motion
"""

from __future__ import annotations

import argparse
import os
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.report import RESULTS, ROOT, Row, publish
from mien.core import Correspondence, Markers, Rig
from mien.evaluate.collection import RIGS, rig
from mien.evaluate.real import closures, predict_held_out, symmetry
from mien.job.pairs import find_pairs
from mien.job.performance import load_performance
from mien.retargeting import make_method, parameters
from mien.retargeting.prepare import prepare
from mien.retargeting.shape_retargeter import ShapeRetargeter

TAKES = ("jaw", "cheeks", "eyebrows")
LIPS = ("Mouth_Up", "Mouth_Down")
METHODS = ("direct", "rbf", "range-of-motion")


def judge(name: str, character: Rig, markers: Markers, pairs: Correspondence) -> Row:
    """Return the figures of one method on one take, which is no range-of-motion take: strength is as performed."""
    method = make_method(name, {"full_range": False} if "full_range" in parameters(make_method(name)) else {})
    held_out = predict_held_out(method, character, markers, pairs, stride=4)
    fitted = method.fit(character, markers, pairs)
    assert isinstance(fitted, ShapeRetargeter)
    clip, _ = fitted.retarget(markers)
    weights = np.asarray(clip.values)
    prepared = prepare(character, markers, pairs)
    terms = prepared.terms
    alike = symmetry(weights, clip.names, prepared.take, terms.actor_neutral, terms.character_neutral)
    upper, lower = np.moveaxis(markers.only(LIPS).points, 1, 0)
    met = closures(character, weights, upper, lower)
    row = asdict(held_out) | {"symmetric frames": alike.frames, "asymmetry": alike.difference}
    return row | (
        {} if met is None else {"closed frames": met.frames, "lip_mm": met.lip_mm, "lip_p95_mm": met.lip_p95_mm}
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--takes", nargs="*", default=TAKES)
    parser.add_argument("--characters", nargs="*", default=list(RIGS))
    parser.add_argument("--methods", nargs="*", default=METHODS)
    parser.add_argument("--data", type=Path, default=os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    parser.add_argument("--json", type=Path, default=RESULTS / "accuracy_real.json", help="where to write the results")
    args = parser.parse_args()
    folder = Path(args.data)
    rows: list[Row] = []
    for take in args.takes:
        performance = load_performance(folder / "clips" / "markers" / f"{take}.c3d")
        assert performance.markers is not None
        for name in args.characters:
            character = rig(folder, name)
            pairs, _ = find_pairs(performance, character)
            for method in args.methods:
                figures = judge(method, character, performance.markers, pairs)
                rows.append({"take": take, "character": name, "method": method, **figures})
    publish(args.json.stem, "Real optical takes without a truth", rows, ["numpy", "scipy"], args.json.parent)


if __name__ == "__main__":
    main()
