"""Puts the measured tables and the picture into `docs/accuracy.md`, from the results that the benchmarks wrote.

    python -m benchmarks.accuracy.page

Everything between `<!-- begin NAME -->` and `<!-- end NAME -->` is made here; the rest is written by hand.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.accuracy.__main__ import PAPER
from benchmarks.accuracy.plots import sweep_sheet
from benchmarks.report import RESULTS, ROOT, Row
from mien.evaluate.collection import FULL, QUICK, Recipe
from mien.evaluate.played import DEFORMATION_TRANSFER, FLOOR
from mien.evaluate.suite import COPY, SAME, TRUTHS

PAGE = ROOT / "docs" / "accuracy.md"
PICTURE = ROOT / "docs" / "pictures" / "ablation.svg"
OURS = "range-of-motion"
METHODS = (FLOOR, OURS, "spacetime", "example-based", DEFORMATION_TRANSFER, "direct", "rbf", PAPER, COPY)
FIGURES = {
    "corr": "correlation",
    "gain": "gain",
    "rmse": "RMSE",
    "mm": "vertex, mm",
    "p95": "95 %, mm",
    "lids": "lids, mm",
    "lips": "lips, mm",
    "jerk": "jerk",
    "closed": "closed",
    "worse": "worse",
}
ABLATED = {
    "vertex_mm": "vertex, mm",
    "gain": "gain",
    "correlation": "correlation",
    "lid_mm": "lids, mm",
    "lip_mm": "lips, mm",
    "jerk": "jerk",
    "active": "active",
    "closed": "closed",
    "worse": "worse",
}
STANDING = ("closed", "worse")
"""Figures that are no means over cases."""
PEOPLE = ("p1", "p2", "p3")
USUAL = 99

LEVELS: Mapping[str, Callable[[Recipe], bool]] = {
    "person → ICT face, same ranges": lambda r: _plain(r, "ict") and not r.spread,
    "person → ICT face, ranges ±30 %": lambda r: _plain(r, "ict") and r.spread > 0,
    "person → caricature, same ranges": lambda r: _plain(r, "toon") and not r.spread,
    "person → caricature, ranges ±30 %": lambda r: _plain(r, "toon") and r.spread > 0,
    "person → MakeHuman adult": lambda r: _plain(r, "adult"),
    "person → MakeHuman child": lambda r: _plain(r, "child"),
    "MakeHuman adult → ICT face": lambda r: (r.actor, r.character) == ("adult", "ict"),
    "MakeHuman adult → caricature": lambda r: (r.actor, r.character) == ("adult", "toon"),
    "MakeHuman adult ↔ child": lambda r: {r.actor, r.character} == {"adult", "child"},
    "41 markers": lambda r: r.conditions.markers == 41,
    "noise 0.5 mm": lambda r: r.conditions.noise_mm == 0.5,
    "gaps": lambda r: r.conditions.gaps > 0,
    "head motion left in": lambda r: r.conditions.head,
    "test S07-001": lambda r: r.test == "S07-001",
    "test apfel": lambda r: r.test == "apfel",
    "test: other half of the training take": lambda r: r.test == "rom",
    "all": lambda r: True,
}
"""Groups of cases; they overlap."""


def _plain(recipe: Recipe, character: str) -> bool:
    return recipe.actor in PEOPLE and recipe.character == character and recipe.conditions.markers == USUAL


def filled(page: str, name: str, table: str) -> str:
    """Return the page with a table between the marks of that name."""
    begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
    before, _, rest = page.partition(begin)
    _, found, after = rest.partition(end)
    assert found, f"{PAGE} lacks the marks of {name}"
    return f"{before}{begin}\n{table}\n{end}{after}"


def table(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Return a Markdown table."""
    lines = [columns, ["---"] * len(columns), *([text(cell) for cell in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def text(cell: Any) -> str:
    """Return a cell as it is printed."""
    if isinstance(cell, float):
        return "–" if np.isnan(cell) else f"{cell:.2f}"
    return str(cell)


def by_method(document: Row) -> str:
    """Return the means of each method in both truths."""
    means = [row for row in document["rows"] if row["case"] == "all"]
    lines = []
    for truth in reversed(TRUTHS):
        for method in METHODS:
            for row in means:
                if (row["method"], row["truth"]) == (method, truth):
                    lines.append([truth, method, *(_figure(row, key) for key in FIGURES)])
    return _source(document) + table(["truth", "method", *FIGURES.values()], lines)


def by_case(document: Row) -> str:
    """Return the vertex error of each method, and the gain of ours, case by case."""
    errors, gains = _of_cases(document, "mm"), _of_cases(document, "gain")
    names = [r.name for r in QUICK]
    lines = [[name, *(errors[name].get(m, float("nan")) for m in METHODS), gains[name][OURS]] for name in names]
    return table(["case", *(f"{m}, mm" for m in METHODS), "gain"], lines)


def by_level(document: Row) -> str:
    """Return how the method stands between the baselines and the floor, for groups of cases."""
    errors, gains, correlations = (_of_cases(document, key) for key in ("mm", "gain", "corr"))
    lines: list[list[Any]] = []
    for level, belongs in LEVELS.items():
        names = [r.name for r in FULL if belongs(r) and r.name in errors]
        if not names:
            continue
        mm = {m: np.array([errors[n][m] for n in names]) for m in (FLOOR, OURS, "direct", "rbf")}
        gap = mm["rbf"] - mm[FLOOR]
        closed = float(np.median(((mm["rbf"] - mm[OURS]) / gap)[gap > 0]))
        worse = int((mm[OURS] > np.minimum(mm["rbf"], mm["direct"]) * (1 + SAME)).sum())
        weights = [float(np.mean([of[n][OURS] for n in names])) for of in (gains, correlations)]
        lines.append([level, len(names), *(float(v.mean()) for v in mm.values()), closed, worse, *weights])
    columns = ["cases", "number", *(f"{m}, mm" for m in mm), "closed", "worse", "gain", "correlation"]
    return _source(document) + table(columns, lines)


def ablation(document: Row) -> str:
    """Return the figures of every setting of every knob."""
    lines = [[row["knob"], row["value"], *(_figure(row, key) for key in ABLATED)] for row in document["rows"]]
    return _source(document) + table(["knob", "value", *ABLATED.values()], lines)


def by_labels(document: Row) -> str:
    """Return the mean figures of each method with so many labelled frames."""
    rows = document["rows"]
    error = {(r["method"], r["case"]): r["mm"] for r in rows if r["method"] in (FLOOR, "rbf", "direct")}
    lines = []
    for labels, method in dict.fromkeys((r["labels"], r["method"]) for r in rows):
        mine = [r for r in rows if (r["labels"], r["method"]) == (labels, method)]
        names = list(dict.fromkeys(r["case"] for r in mine))
        mm = {name: float(np.mean([r["mm"] for r in mine if r["case"] == name])) for name in names}
        closed = [(error["rbf", n] - mm[n]) / (error["rbf", n] - error[FLOOR, n]) for n in names]
        worse = sum(mm[n] > min(error["rbf", n], error["direct", n]) * (1 + SAME) for n in names)
        means = [float(np.nanmean([r.get(key, np.nan) for r in mine])) for key in FIGURES if key not in STANDING]
        lines.append([labels or "none", method, *means, float(np.median(closed)), worse])
    return _source(document) + table(["labels", "method", *FIGURES.values()], lines)


def _figure(row: Row, key: str) -> float | int:
    """Return a figure of a row; counts are whole."""
    value = row.get(key, float("nan"))
    return int(value) if key == "worse" else value


def _of_cases(document: Row, key: str) -> dict[str, dict[str, float]]:
    """Return a figure in the range truth by case and method."""
    found: dict[str, dict[str, float]] = {}
    for row in document["rows"]:
        if row["case"] != "all" and row["truth"] == "range":
            found.setdefault(row["case"], {})[row["method"]] = row.get(key, float("nan"))
    return found


def _source(document: Row) -> str:
    machine = document["machine"]
    return f"{document['about']}; measured at commit {machine['commit']}, {machine['time'][:10]}.\n\n"


def main() -> None:
    read = {
        name: json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
        for name in ("accuracy_quick", "accuracy_library", "accuracy", "accuracy_ablation", "accuracy_labels")
    }
    page = PAGE.read_text(encoding="utf-8")
    page = filled(page, "methods", by_method(read["accuracy_quick"]))
    page = filled(page, "cases", by_case(read["accuracy_quick"]))
    page = filled(page, "library", by_method(read["accuracy_library"]))
    page = filled(page, "levels", by_level(read["accuracy"]))
    page = filled(page, "all-methods", by_method(read["accuracy"]))
    page = filled(page, "labels", by_labels(read["accuracy_labels"]))
    page = filled(page, "ablation", ablation(read["accuracy_ablation"]))
    PAGE.write_text(page, encoding="utf-8")
    PICTURE.write_text(sweep_sheet(read["accuracy_ablation"]["rows"]), encoding="utf-8")
    print(f"filled in {PAGE} and drawn {PICTURE}")


if __name__ == "__main__":
    main()
