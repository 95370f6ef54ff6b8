"""Peers beside mien's own methods, on the same cases and the same frames.

    python -m benchmarks.peers
    python -m benchmarks.peers --peers scipy-nnls squared-l1 --frames 60
    python -m benchmarks.peers --cases acting cartoon --json peers.json

Some peers need a second or more for a frame, so the test takes are cut to their first frames,
for everybody.  What is not installed is skipped with a word; how to get it stands in each adapter.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.peers.adapter import Absent
from benchmarks.peers.published_range_of_motion import REPRODUCED
from benchmarks.peers.refined_inverse_rigging import REFINED
from benchmarks.peers.solvers import SOLVERS
from benchmarks.peers.squared_l1 import RESTATED
from benchmarks.report import RESULTS, Row, publish
from mien.core import Clip, Markers
from mien.evaluate.bench.cell import Witness, measure
from mien.evaluate.bench.figures import FIGURES
from mien.evaluate.bench.table import STRIDE, Entrant, entrants
from mien.evaluate.cases import Case
from mien.evaluate.collection import Recipe, made
from mien.evaluate.conditions import Conditions
from mien.evaluate.embedded import LibraryRecipe, library_case

PEERS = (*SOLVERS, *RESTATED, *REFINED, *REPRODUCED)
OURS = ("floor", "range-of-motion", "paper", "rbf", "direct")
FEW = Conditions(markers=41)
FRAMES = 90


def cases(data: Path | None, wanted: list[str]) -> Iterator[Case]:
    """Make the cases whose names hold all the wanted words: the library's, and real ones where the data is."""
    for recipe in (LibraryRecipe(1), LibraryRecipe(1, spread=0.3, conditions=FEW)):
        name = f"a1>{recipe.character} {recipe.test} {recipe.special}".rstrip()
        if all(word in name for word in wanted):
            yield library_case(recipe, STRIDE, name)
    for real in (Recipe("p1", "ict", spread=0.3, conditions=FEW), Recipe("adult", "ict")) if data else ():
        if all(word in real.name for word in wanted):
            assert data is not None
            yield made(data, real, STRIDE)


def shortened(case: Case, frames: int) -> Case:
    """Return a case whose test take is cut to the frames around its strongest."""
    middle = int(Witness.of(case).frames[0])
    begin = max(0, min(middle - frames // 2, len(case.test) - frames))
    part = slice(begin, begin + frames)

    def cut(clip: Clip) -> Clip:
        return Clip(clip.names, clip.values[part], clip.fps)

    test = Markers(case.test.names, case.test.points[part], case.test.fps)
    return replace(
        case,
        test=test,
        recording=cut(case.recording),
        truth=cut(case.truth),
        truth_range=cut(case.truth_range),
        stride=1,
    )


def field(wanted: list[str]) -> list[Entrant]:
    """Return mien's methods and the peers that are installed; say which are not."""
    found = list(entrants(OURS))
    for peer in PEERS:
        if wanted and peer.name not in wanted:
            continue
        try:
            found.append(Entrant(peer.name, peer.method()))
        except Absent as reason:
            print(f"{peer.name} ({peer.about}) is skipped: {reason}; install: {peer.install}", flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", nargs="*", default=[], help="only these peers")
    parser.add_argument("--cases", nargs="*", default=[], help="only cases whose names hold all these words")
    parser.add_argument("--frames", type=int, default=FRAMES, help="how many frames of each test take")
    parser.add_argument("--data", default=os.environ.get("MIEN_DATA"), help="folder of the real data")
    parser.add_argument("--json", type=Path, default=RESULTS / "peers.json", help="where to write the results")
    args = parser.parse_args()
    methods = field(args.peers)
    rows: list[Row] = []
    for case in cases(Path(args.data) if args.data else None, args.cases):
        witness = Witness.of(shortened(case, args.frames))
        for entrant in methods:
            cell = measure(witness, entrant, case.name)
            known = {f.title: cell.figures[f.key] for f in FIGURES if np.isfinite(cell.figures.get(f.key, np.nan))}
            figures = {title: float(f"{value:.4g}") for title, value in known.items()}
            rows.append({"case": case.name, "method": entrant.name, **figures})
            rows[-1] |= {"failed": cell.failed} if cell.failed else {}
            print(f"{case.name}: {entrant.name} {figures.get('mm')} mm, {figures.get('ms')} ms a frame", flush=True)
    about = f"Peers and mien's own methods on {args.frames} frames; other solvers have the shapes of range-of-motion"
    publish(args.json.stem, about, rows, ["mien", "numpy", "scipy", "scikit-learn"], args.json.parent)


if __name__ == "__main__":
    main()
