"""What each part and constant of the method is worth: switched off or swept, one at a time.

    python -m benchmarks.accuracy.ablation
    python -m benchmarks.accuracy.ablation --knobs rounds freedom
    python -m benchmarks.accuracy.ablation --full

Writes `results/accuracy_ablation.json`, from which `python -m benchmarks.accuracy.page`
makes the table and the picture of the accuracy page.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.report import RESULTS, ROOT, Row, publish
from mien.core.arrays import Floats
from mien.evaluate import Case, run_case, summary
from mien.evaluate.collection import FULL, QUICK, Recipe, made
from mien.evaluate.metrics import active_per_frame
from mien.evaluate.played import FLOOR
from mien.evaluate.suite import compare
from mien.retargeting import make_method
from mien.retargeting.initial import warped_shapes
from mien.retargeting.prepare import Prepared
from mien.retargeting.range_of_motion.method import Alignment, RangeOfMotion
from mien.retargeting.range_of_motion.refit import FIRST, LAST, ROUNDS, Refit, Take, calibrated, refitted, thinned
from mien.retargeting.settings import PAPER, SolveSettings
from mien.retargeting.shape_retargeter import shape_retargeter

STRIDE = 8
"""The vertex error is measured at every so many frames."""
CASES = (*QUICK, Recipe("p1", "adult", visemes=True))
"""The quick suite, and a character with visemes that nothing drives."""
REFERENCES = (FLOOR, "rbf", "direct")
TRUTH = "range"
OPINION = "with opinion"


@dataclass(frozen=True)
class Steps:
    """How the actor's shapes are found; the defaults are those of `personalise`.

    Attributes:
        guess: `with opinion`, the default; `own`, without the second opinion; `warp`; or the `mean` of the last two.
        first, second: how much of the way each calibration goes (0: left out).
        rounds: of refitting.
        refit: its scales.
    """

    guess: str = OPINION
    first: float = FIRST
    second: float = LAST
    rounds: int = ROUNDS
    refit: Refit = field(default_factory=Refit)

    def shapes(self, case: Case, informed: Floats) -> Floats:
        """Return the actor's shapes `(K, M, 3)` [cm]; `informed` are those the default starts from."""
        take = training_take(case.prepared, case.character.blendshapes.names)
        shapes = informed if self.guess == OPINION else starting_shapes(case.prepared, self.guess)
        shapes = calibrated(shapes, take, self.refit.full, self.first) if self.first else shapes
        for _ in range(self.rounds):
            shapes = refitted(shapes, take, self.refit)
        return calibrated(shapes, take, self.refit.full, self.second) if self.second else shapes


def training_take(prepared: Prepared, names: Sequence[str]) -> Take:
    """Return what the shapes are found from, without labels."""
    frames = prepared.take[~np.isnan(prepared.take).any(axis=(1, 2))]
    confidence = np.asarray(prepared.pairs.confidence)
    return thinned(Take(names, frames, confidence, SolveSettings().off, frames[:0], np.empty((0, len(names)))))


def starting_shapes(prepared: Prepared, guess: str) -> Floats:
    """Return the shapes that are refitted, `(K, M, 3)` [cm]."""
    own, warped = prepared.terms.deltas, warped_shapes(prepared.terms)
    return {"own": own, "warp": warped, "mean": (own + warped) / 2}[guess]


Shapes = Callable[[Case], Floats]


@dataclass(frozen=True)
class Variant:
    """One setting of one knob.

    Attributes:
        knob, value: what is changed, and to what.
        shapes: how the actor's shapes are found; None for the method's own way.
        solve: what differs in the per-frame solve.
    """

    knob: str
    value: str
    shapes: Shapes
    solve: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """What its rows are called."""
        return f"{self.knob} {self.value}"


def by_steps(steps: Steps, default: Default) -> Shapes:
    """Find shapes in these steps, if they are not the default's."""
    if steps == Steps():
        return default
    return lambda case: steps.shapes(case, default.of(case).guess)


def by_method(**settings: Any) -> Shapes:
    """Find shapes as the method does with these settings."""

    def shapes(case: Case) -> Floats:
        method: Any = make_method("range-of-motion", settings)
        return np.asarray(method.align(case.prepared, case.character).personal)

    return shapes


class Default:
    """What the default finds, once for each case."""

    def __init__(self) -> None:
        self._found: tuple[Case, Alignment] | None = None

    def of(self, case: Case) -> Alignment:
        """Return what it starts from and where it arrives."""
        if self._found is None or self._found[0] is not case:
            self._found = case, RangeOfMotion().align(case.prepared, case.character)
        return self._found[1]

    def __call__(self, case: Case) -> Floats:
        """Return the actor's shapes `(K, M, 3)` [cm]."""
        return self.of(case).personal


def variants() -> Iterator[Variant]:
    """Yield every setting of every knob; the default's own setting is among each knob's."""
    default = Default()
    for guess in (OPINION, "own", "mean", "warp"):
        yield Variant("guess", guess, by_steps(Steps(guess), default))
    calibrations = {
        "off": (0, 0),
        "once": (1, 0),
        "+ half": (1, 0.5),
        "default": (FIRST, LAST),
        "+ whole": (1, 1),
    }
    for value, (first, second) in calibrations.items():
        yield Variant("calibration", value, by_steps(Steps(first=first, second=second), default))
    for full in (0.95, 0.98, 0.99, 0.995, 0.999):
        yield Variant("full", f"{full:g}", by_steps(Steps(refit=Refit(full=full)), default))
    for rounds in (0, 1, 2, 3, 6):
        yield Variant("rounds", str(rounds), by_steps(Steps(rounds=rounds), default))
    for scale in ("freedom", "spread"):
        for factor in (0.1, 0.3, 1, 3):
            value = round(factor * getattr(Refit(), scale), 6)
            yield Variant(scale, f"{value:.2g}", by_steps(Steps(refit=Refit(**{scale: value})), default))
    sweeps: dict[str, Sequence[Any]] = {
        "sparsity": (0.0, 0.0002, 0.001, 0.005, 0.02, 0.6),
        "damping": (0.0, 0.001, 0.003, 0.01, 0.1),
        "smooth": (0.0, 0.0005, 0.002, 0.005, 0.02),
        "bounds": (None, (0.0, 1.0), (0.0, 1.1), (0.0, 1.5)),
        "prior": (0.0, 0.03, 0.3),
    }
    for knob, values in sweeps.items():
        for value in values:
            yield Variant(knob, text_of(value), default, {knob: value})
    yield Variant("visemes", "off", default)
    yield Variant("visemes", "in use", by_method(off=()), {"off": ()})
    printed = by_method(preset="paper")
    yield Variant("printed", "all as printed", printed, PAPER)
    yield Variant("printed", "its shapes, our solve", printed)
    yield Variant("printed", "our shapes, its solve", default, PAPER)
    strong = {"mesh": 1.0, "cross": 10.0}
    for value, settings in (
        ("keep 0.8", {"keep": 0.8}),
        ("mesh, cross × 100", strong),
        ("both", {"keep": 0.8, **strong}),
    ):
        yield Variant("printed", f"its shapes with {value}, our solve", by_method(preset="paper", **settings))


def text_of(value: Any) -> str:
    """Return a value as the tables show it."""
    if isinstance(value, tuple):
        return "–".join(f"{v:g}" for v in value)
    return "none" if value is None else f"{value:g}"


def run(recipes: Sequence[Recipe], folder: Path, knobs: Sequence[str]) -> list[Row]:
    """Return the mean figures of each variant over the cases, in the range truth."""
    chosen = [v for v in variants() if not knobs or v.knob in knobs]
    rows: list[Row] = []
    for recipe in recipes:
        case = made(folder, recipe, STRIDE)
        rows += [run_case(case, name) for name in REFERENCES]
        rows += [measured(case, variant) for variant in chosen]
        print(recipe.name, flush=True)
    means = {row["method"]: row for row in summary(rows, TRUTH)}
    active = {name: float(np.mean([r["active"] for r in rows if r["method"] == name])) for name in means}
    labelled = [(name, "reference", name) for name in REFERENCES] + [(v.name, v.knob, v.value) for v in chosen]
    return [
        {"knob": knob, "value": value, **_rounded(means[name]), "active": round(active[name], 1)}
        for name, knob, value in labelled
    ]


def measured(case: Case, variant: Variant) -> Row:
    """Return the figures of one variant on one case."""
    shapes = variant.shapes(case)
    fitted = shape_retargeter(variant.name, case.character, case.prepared, shapes, SolveSettings(**variant.solve))
    clip, _ = fitted.retarget(case.test)
    figures = compare(case, clip, TRUTH, shapes)
    return {"case": case.name, "method": variant.name, TRUTH: figures, "active": active_per_frame(clip.values)}


def _rounded(figures: Row) -> Row:
    return {k: round(float(v), 4) for k, v in figures.items() if k not in ("method", "truth")}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true", help="over the whole suite (hours) and not only the quick one")
    parser.add_argument("--knobs", nargs="*", default=[], help="only these")
    parser.add_argument("--data", type=Path, default=os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    parser.add_argument("--json", type=Path, default=RESULTS / "accuracy_ablation.json", help="where to write")
    args = parser.parse_args()
    recipes = FULL if args.full else CASES
    rows = run(recipes, Path(args.data), args.knobs)
    about = f"The default with one thing changed at a time, {len(recipes)} cases, range truth"
    publish(args.json.stem, about, rows, ["numpy", "scipy"], args.json.parent)


if __name__ == "__main__":
    main()
