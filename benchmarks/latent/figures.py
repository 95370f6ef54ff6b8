"""The figures of Bouaziz and Pauly 2014 on real performances.

    python -m benchmarks.latent.figures --quick
    python -m benchmarks.latent.figures --figures 4 suggest --draws 20
    python -m benchmarks.latent.figures --peers transport ridge gpr --takes apfel aura

Figures: `4` labels, `clean` the same without noise, `5` unlabelled rows, `6` noise, `7` missing markers, `8` posing,
`foreign` target rows from another take, `regions` halves of the face learned apart, `suggest` suggested against random
labels, `ablation` one part of the transport taken away at a time.  Results are written after every draw.

Needs the real rigs and recordings (`MIEN_DATA`, or `--data`).
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from benchmarks.latent.cases import LIVELINK, Take, read_takes
from benchmarks.latent.plots import curves
from benchmarks.latent.posing import by_posing
from benchmarks.latent.sweeps import (
    PEERS,
    TRANSPORT,
    VARIANTS,
    Learners,
    Score,
    by_clean_labels,
    by_foreign,
    by_labels,
    by_missing,
    by_noise,
    by_regions,
    by_suggestion,
    by_unlabelled,
    table,
)
from benchmarks.report import RESULTS, ROOT, Row, publish

FIGURES = ("4", "clean", "5", "6", "7", "8", "foreign", "regions", "suggest", "ablation")
ABOUT = {
    "4": (
        "labels",
        "labels",
        "error (RMS of the targets) against labels; 100 unlabelled rows of each side, 0.2 mm noise",
    ),
    "clean": ("labels", "labels", "error against labels without any noise; 100 unlabelled rows of each side"),
    "5": ("unlabelled", "unlabelled rows of each side", "error against unlabelled rows of each side; 20 labels"),
    "6": ("noise_mm", "noise [mm]", "error against the noise of the markers; 20 labels"),
    "7": ("missing", "share of markers missing", "error against the share of markers missing; 20 labels"),
    "8": ("entries", "entries given", "error of the entries of a pose that were not given; 20 labels"),
    "foreign": ("labels", "labels", "error where the target-only rows come from another take"),
    "regions": ("labels", "labels", "error with the face learned whole, and upper and lower half apart"),
    "ablation": ("labels", "labels", "error with one part of the transport taken away at a time"),
    "suggest": ("labels", "labels", "error after suggested and after random labels, the first three random"),
}
SETTINGS = ("take", "targets", "target_only", "labels", "unlabelled", "noise_mm", "missing", "entries")
"""Columns that say what was varied."""
CHEAP = (TRANSPORT, "ridge", "gpr")


def scores_of(figure: str, takes: Sequence[Take], learners: Learners, seed: int, quick: bool) -> Iterator[Score]:
    """Score one draw of one figure."""
    if figure == "4":
        return by_labels(takes, learners, (5, 20) if quick else (5, 10, 20, 30, 50), seed)
    if figure == "clean":
        return by_clean_labels(takes, learners, (5, 50) if quick else (5, 10, 20, 30, 40, 50), seed)
    if figure == "5":
        return by_unlabelled(takes, learners, (0, 100) if quick else (0, 25, 50, 100, 200, 400), seed)
    if figure == "6":
        return by_noise(takes, learners, (0.0, 1.0) if quick else (0.0, 0.1, 0.2, 0.5, 1.0, 2.0), seed)
    if figure == "7":
        return by_missing(takes, learners, (0.0, 0.5) if quick else (0.0, 0.1, 0.3, 0.5, 0.7, 0.9), seed)
    if figure == "8":
        return by_posing(takes, seed)
    if figure == "ablation":
        return by_labels(takes, VARIANTS, (5, 20, 50), seed)
    if figure == "foreign":
        return by_foreign(takes, learners, (5, 20) if quick else (5, 10, 20, 50), seed)
    if figure == "regions":
        return by_regions(takes, (5, 20) if quick else (5, 10, 20, 50), seed)
    return by_suggestion(takes, (5, 20) if quick else (5, 10, 15, 20, 30), seed)


def against_best(rows: Sequence[Row]) -> list[Row]:
    """Return, for each setting, the transport's error over that of the best other method."""
    settings: dict[tuple[tuple[str, Any], ...], dict[str, float]] = {}
    for row in rows:
        key = tuple((k, v) for k, v in row.items() if k in SETTINGS)
        settings.setdefault(key, {})[str(row["method"])] = float(row["rms"])
    table: list[Row] = []
    for key, found in settings.items():
        others = {name: value for name, value in found.items() if name != TRANSPORT}
        if TRANSPORT not in found or not others:
            continue
        best = min(others, key=lambda name: others[name])
        table.append({**dict(key), **found, "best other": best, "over it": found[TRANSPORT] / others[best]})
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one draw, two takes, few settings: about two minutes")
    parser.add_argument("--figures", nargs="+", choices=FIGURES, default=FIGURES)
    parser.add_argument(
        "--peers", nargs="+", choices=tuple(PEERS), help="methods; all in figure 4, the quick ones in others"
    )
    parser.add_argument("--takes", nargs="+", choices=(*LIVELINK, "aura"), default=(*LIVELINK, "aura"))
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")))
    parser.add_argument("--out", type=Path, default=RESULTS)
    asked = parser.parse_args()
    names = tuple(asked.takes)[:2] if asked.quick else tuple(asked.takes)
    takes, draws = read_takes(asked.data, names), 1 if asked.quick else asked.draws
    asked.out.mkdir(parents=True, exist_ok=True)
    for figure in asked.figures:
        every = figure == "4" and not asked.quick
        learners = {name: PEERS[name] for name in asked.peers or (tuple(PEERS) if every else CHEAP)}
        scores: list[Score] = []
        for seed in range(draws):
            with threadpool_limits(limits=1):
                scores += scores_of(figure, takes, learners, seed, asked.quick)
            rows = table(scores)
            publish_figure(figure, rows, seed + 1, asked.out, quick=asked.quick)
        for line in against_best(rows):
            print("  ".join(f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in line.items()))


def publish_figure(figure: str, rows: Sequence[Row], draws: int, folder: Path, *, quick: bool) -> None:
    """Write the numbers of a figure and its curves."""
    column, label, about = ABOUT[figure]
    name = f"latent_{figure}" + ("_quick" if quick else "")
    publish(name, f"{about}; {draws} draws", rows, ("numpy", "scipy", "scikit-learn"), folder)
    (folder / f"{name}.svg").write_text(curves(rows, column, label), encoding="utf-8")


if __name__ == "__main__":
    main()
