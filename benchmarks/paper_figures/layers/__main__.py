"""Figures 6 to 10 of the layers paper.

    MIEN_DATA=/path/to/data python -m benchmarks.paper_figures.layers
    python -m benchmarks.paper_figures.layers --quick --out figures

Figures 6 to 8 need the real rigs and recordings (`MIEN_DATA`); 9 and 10 are made of the built-in
cast.  Numbers go to `benchmarks/results`, pictures to the folder.  Which frames are extremes
is decided by `mien.retargeting.layers.choose`, or they are the cast's own.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from threadpoolctl import threadpool_limits

from benchmarks.paper_figures.layers.acting import closure_rows, film, speech_closure_rows
from benchmarks.paper_figures.layers.performances import performances
from benchmarks.paper_figures.layers.reconstruction import reconstruction
from benchmarks.paper_figures.layers.shares import speech_rows, weight_plot
from benchmarks.report import RESULTS, publish

PACKAGES = ("numpy", "scipy", "numba", "mien")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="two takes, and no film")
    parser.add_argument("--out", type=Path, default=Path("layers_figures"), help="folder for the pictures")
    arguments = parser.parse_args()
    folder: Path = arguments.out
    folder.mkdir(parents=True, exist_ok=True)
    results = folder if arguments.quick else RESULTS
    named = os.environ.get("MIEN_DATA", "")
    data = Path(named) if named else None
    with threadpool_limits(1):
        if data is not None:
            takes = performances(data, arguments.quick)
            about = "Error of the layered model and of each layer alone (figure 8)"
            publish("layers_reconstruction", about, reconstruction(takes, folder), PACKAGES, results)
            weight_plot(takes[1], folder)
        about = "Weight of the speech layer at the mouth (figures 6 and 7)"
        publish("layers_speech", about, speech_rows(data), PACKAGES, results)
        about = "How far mouths are open at /p/ and /a/"
        publish("layers_closure", about, closure_rows(folder), PACKAGES, results)
        if data is not None:
            about = "How far mouths are open where an actor's lips close in recorded speech"
            publish("layers_speech_closure", about, speech_closure_rows(data), PACKAGES, results)
        film(folder, arguments.quick)
    print(f"pictures are in {folder}")


if __name__ == "__main__":
    main()
