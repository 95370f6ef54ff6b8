"""Puts the measured tables and pictures into `docs/bench.md` and `docs/how-to-choose.md`.

    python -m benchmarks.bench_page
    python -m benchmarks.bench_page --pictures

The tables come from the results that the benchmarks wrote.  The pictures of faces are made by running a few
methods once more, for one actor in every scene of the quick suite.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from benchmarks.accuracy.page import filled, table
from benchmarks.accuracy.plots import on_white
from benchmarks.report import RESULTS, ROOT, Row
from mien.evaluate.bench.document import read
from mien.evaluate.bench.figures import FIGURES, Spread
from mien.evaluate.bench.run import run
from mien.evaluate.bench.table import entrants
from mien.evaluate.bench.table import scenes as suite
from mien.job.bench import pictured
from mien.look.compared import spreads
from mien.look.sheet import save_png

PAGE = ROOT / "docs" / "bench.md"
PICTURE = ROOT / "docs" / "pictures" / "bench.svg"
CHOOSING = ROOT / "docs" / "how-to-choose.md"
SHOWN = ("floor", "range-of-motion", "rbf", "example-based", "layers", "latent")
"""The methods that are pictured beside the truth."""
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


def choosing(document: Row) -> str:
    """Return one line per method: vertex error and gain in every scene, and what the method took."""
    names = list(dict.fromkeys(scene_of(row) for row in document["rows"]))
    columns = ["method", *(name.split(",")[0] for name in names), "ms a frame", "set-up, s", "given"]
    lines = []
    for method in dict.fromkeys(row["method"] for row in document["rows"]):
        mine = {scene_of(row): row for row in document["rows"] if row["method"] == method}
        cells = [
            f"{mean(mine[name], 'vertex_mm')} mm, {mean(mine[name], 'gain')}" if name in mine else "–" for name in names
        ]
        costs = [f"{max(row['figures'][key]['mean'] for row in mine.values()):.2f}" for key in ("frame_ms", "fit_s")]
        given = "; ".join(dict.fromkeys(row["given"] for row in mine.values() if row["given"]))
        lines.append([method, *cells, *costs, given])
    return table(columns, lines)


def mean(row: Row, key: str) -> str:
    return f"{row['figures'][key]['mean']:.2f}" if key in row["figures"] else "–"


def faces() -> None:
    """Picture some methods beside the truth, in every scene of the quick suite."""
    alone = [replace(scene, recipes=scene.recipes[:1]) for scene in suite(full=False, real=False)]
    for scened in run(alone, entrants(SHOWN)):
        path = PICTURE.with_name(f"choose-{scened.scene.character}.png")
        save_png(path, pictured(scened))
        print(f"drawn {path}")


def picture(document: Row) -> str:
    """Return the vertex error of every method in every scene, as SVG."""
    by_scene: dict[str, dict[str, Spread]] = {}
    for row in document["rows"]:
        if "vertex_mm" in row["figures"]:
            by_scene.setdefault(scene_of(row), {})[row["method"]] = Spread(**row["figures"]["vertex_mm"])
    return on_white(spreads(by_scene, "vertex error [mm], mean and standard deviation over identities", 0.0))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", action="store_true", help="draw the faces, too: about two minutes")
    wanted = parser.parse_args()
    quick = read(RESULTS / "bench_quick.json")
    page = filled(PAGE.read_text(encoding="utf-8"), "quick", scenes(quick))
    results = RESULTS / "peers.json"
    if results.is_file():
        page = filled(page, "peers", peers(json.loads(results.read_text(encoding="utf-8"))))
    PAGE.write_text(page, encoding="utf-8")
    PICTURE.write_text(picture(quick), encoding="utf-8")
    CHOOSING.write_text(filled(CHOOSING.read_text(encoding="utf-8"), "methods", choosing(quick)), encoding="utf-8")
    print(f"filled in {PAGE} and {CHOOSING}, and drawn {PICTURE}")
    if wanted.pictures:
        faces()


if __name__ == "__main__":
    main()
