"""Puts the measured tables and the picture into `docs/bench.md`, from the results that the benchmarks wrote.

python -m benchmarks.bench_page
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from benchmarks.accuracy.page import filled, table
from benchmarks.accuracy.plots import on_white
from benchmarks.report import RESULTS, ROOT, Row
from mien.evaluate.bench.document import read
from mien.evaluate.bench.figures import FIGURES, Spread
from mien.look.compared import spreads

PAGE = ROOT / "docs" / "bench.md"
PICTURE = ROOT / "docs" / "pictures" / "bench.svg"
PEER_FIGURES = ("RMSE", "corr", "gain", "mm", "jerk", "fit", "ms")


def scene_of(row: Row) -> str:
    return f"{row['performance']} > {row['character']}, {row['conditions']}"


def scenes(document: Row) -> str:
    """Return a table for each scene of a run."""
    machine = document["machine"]
    parts = [
        f"{document['suite']}, {document['seconds']:.0f} s on {machine['cpu']} with {machine['threads']} threads; "
        f"commit {machine['commit']}, {machine['time'][:10]}."
    ]
    for scene in dict.fromkeys(scene_of(row) for row in document["rows"]):
        crossings = document["crossings_of_the_truth"][scene]
        parts.append(f"**{scene}** (the truth has {crossings:.0f} crossings)")
        rows = [[r["method"], *cells(r), r["given"]] for r in document["rows"] if scene_of(r) == scene]
        parts.append(table(["method", *(figure.title for figure in FIGURES), "given"], rows))
    return "\n\n".join(parts)


def cells(row: Row) -> list[str]:
    """Return means with their standard deviations."""
    return [written(row["figures"].get(figure.key)) for figure in FIGURES]


def written(spread: dict[str, float] | None) -> str:
    if spread is None:
        return "–"
    mean, deviation = (
        f"{spread[part]:.2f}" if spread[part] < 10 else f"{spread[part]:.0f}" for part in ("mean", "std")
    )
    return mean if float(deviation) == 0 else f"{mean} ±{deviation.removeprefix('0')}"


def peers(document: Row) -> str:
    """Return a table for each case that peers ran on."""
    machine = document["machine"]
    parts = [f"{document['about']}; commit {machine['commit']}, {machine['time'][:10]}."]
    for case in dict.fromkeys(row["case"] for row in document["rows"]):
        rows: Sequence[Sequence[Any]] = [
            [row["method"], *(row.get(figure, float("nan")) for figure in PEER_FIGURES)]
            for row in document["rows"]
            if row["case"] == case
        ]
        parts += [f"**{case}**", table(["method", *PEER_FIGURES], rows)]
    return "\n\n".join(parts)


def picture(document: Row) -> str:
    """Return the vertex error of every method in every scene, as SVG."""
    by_scene: dict[str, dict[str, Spread]] = {}
    for row in document["rows"]:
        if "vertex_mm" in row["figures"]:
            by_scene.setdefault(scene_of(row), {})[row["method"]] = Spread(**row["figures"]["vertex_mm"])
    return on_white(spreads(by_scene, "vertex error [mm], mean and standard deviation over identities", 0.0))


def main() -> None:
    quick = read(RESULTS / "bench_quick.json")
    page = filled(PAGE.read_text(encoding="utf-8"), "quick", scenes(quick))
    results = RESULTS / "peers.json"
    if results.is_file():
        page = filled(page, "peers", peers(json.loads(results.read_text(encoding="utf-8"))))
    PAGE.write_text(page, encoding="utf-8")
    PICTURE.write_text(picture(quick), encoding="utf-8")
    print(f"filled in {PAGE} and drawn {PICTURE}")


if __name__ == "__main__":
    main()
