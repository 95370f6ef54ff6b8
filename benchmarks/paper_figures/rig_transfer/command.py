"""The command line that all figures share."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path

from threadpoolctl import threadpool_limits

from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import RESULTS, ROOT

Figure = Callable[[Settings], None]


def run(about: str | None, *figures: Figure) -> None:
    """Read the arguments and make the figures."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer faces, smaller pictures, tables beside them")
    parser.add_argument("--out", type=Path, default=Path("figures"), help="folder of the pictures")
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    there = (args.data / "rigs").is_dir()
    if not there:
        print(f"no real heads at {args.data}: the cast alone is shown; name their folder with --data or MIEN_DATA.")
    settings = Settings(args.out, args.data if there else None, args.quick, args.out if args.quick else RESULTS)
    with threadpool_limits(1):
        for figure in figures:
            began = time.perf_counter()
            figure(settings)
            print(f"{figure.__name__}: {time.perf_counter() - began:.0f} s")
