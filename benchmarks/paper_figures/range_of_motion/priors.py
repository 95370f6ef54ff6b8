"""Figure 14: priors at equal fit, judged by self-intersections, fold-overs and weights in use.

As in the paper, the actor's shapes are the warped ones (`rbf`), weights have no bounds, every shape
is in use and nothing but the prior and a little sparsity holds them.  Each prior is made as strong
as it must be for the same residual at the markers, by bisection; then its worst frames are counted
on the full mesh.  A prior is better if fewer triangles cross or fold at the same loss of fit.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.paper_figures.range_of_motion.folds import folded
from benchmarks.report import RESULTS, Row, publish
from mien.core import Correspondence, Markers, Rig
from mien.core.arrays import Floats
from mien.evaluate.intersections import crossing_pairs, new_crossings
from mien.io.documents import join
from mien.job.learn import learn
from mien.job.request import Request
from mien.job.retarget import frames_of
from mien.job.stages import stopwatch
from mien.library import actor, character, performance
from mien.look.portrait import Portrait
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Strip
from mien.retargeting.energy import frame_solver
from mien.retargeting.prior import PRIORS
from mien.retargeting.rbf import Rbf
from mien.retargeting.settings import SolveSettings
from mien.retargeting.shape_retargeter import ShapeRetargeter

COMPARED = ("geometric", "l2", "elastic-net", "pca")
LOST = (0.02, 0.05, 0.1)
"""Loss of fit at which priors are compared: the residual grows by this share."""
SHOWN = 0.05
"""The loss of fit that the picture shows."""
FRAMES, JUDGED = 150, 6
"""Frames solved of each take, and how many of them, those with the largest weights, are counted on the mesh."""
REACH = (1e-7, 1e4)
"""Strengths between which the right one lies."""
STEPS = 16
FREE: dict[str, Any] = {"bounds": None, "off": (), "damping": 0.0, "smooth": 0.0}
TAKES = {"jaw.c3d": "clips/markers/jaw.c3d", "adult plays S07": "clips/adult_plays_S07.glb"}
CHARACTERS = ("ict_face", "makehuman_adult", "toon")


@dataclass(frozen=True, eq=False)
class Cell:
    """A take on a character.

    Attributes:
        take, name: which.
        rig: the character.
        fitted: its method.
        frames: `(F, M, 3)` displacements of the actor [cm].
    """

    take: str
    name: str
    rig: Rig
    fitted: ShapeRetargeter
    frames: Floats

    def weights(self, kind: str, strength: float) -> Floats:
        """Solve all frames with a prior."""
        settings = SolveSettings(prior=strength, prior_kind=kind, **FREE)
        confidence = self.fitted.solver.confidence
        solver = frame_solver(self.fitted.shapes, self.fitted.names, self.forms[kind], confidence, settings)
        return solver.batch(self.frames)[0]

    @cached_property
    def forms(self) -> dict[str, Floats]:
        """The quadratic form of every prior."""
        centimetre = self.fitted.centimetre * self.fitted.placement.scale
        return {kind: prior.quadratic(self.rig, centimetre) for kind, prior in PRIORS.items()}

    def residual(self, weights: Floats) -> float:
        """Return the root mean square misfit that the solve minimises [mm]."""
        square = ((np.tensordot(weights, self.fitted.shapes, axes=1) - self.frames) ** 2).sum(axis=2)
        counts = np.where(np.isnan(square), 0, self.fitted.solver.confidence)
        return float(10 * np.sqrt((np.nan_to_num(square) * counts).sum() / counts.sum()))

    def at(self, kind: str, residual: float) -> tuple[float, Floats]:
        """Return the strength at which a prior leaves a residual, and the weights there."""
        low, high = np.log(REACH)
        for _ in range(STEPS):
            middle = (low + high) / 2
            weights = self.weights(kind, float(np.exp(middle)))
            low, high = (middle, high) if self.residual(weights) < residual else (low, middle)
        return float(np.exp(middle)), weights


def cells(data: Path | None) -> Iterator[Cell]:
    """Make every take on every character at hand; the built-in ones without real data."""
    if data is None:
        yield _embedded()
        return
    for take, file in TAKES.items():
        for name in CHARACTERS:
            if not (name == "makehuman_adult" and "adult" in take):
                marks = data / "rigs" / "makehuman_adult.landmarks.json", data / "rigs" / f"{name}.landmarks.json"
                landmarks = marks if "adult" in take else None
                request = Request(
                    data / file, data / "rigs" / f"{name}.glb", "rbf", landmarks=landmarks, settings=dict(FREE)
                )
                fitted, played = learn(request, stopwatch({}, lambda _: None))
                assert fitted.character is not None
                markers = frames_of(fitted, played)
                assert isinstance(markers, Markers)
                yield _cell(take, name, fitted.character, fitted.retargeter, markers)


def _embedded() -> Cell:
    rig, (_, markers) = character(), performance(actor())
    names = [name for name in markers.names if name in rig.landmarks]
    pairs = Correspondence(tuple(names), join([rig.landmarks[name] for name in names]))
    fitted = Rbf(solve=SolveSettings(**FREE)).fit(rig, markers, pairs)
    return _cell("script", rig.name, rig, fitted, markers)


def _cell(take: str, name: str, rig: Rig, fitted: ShapeRetargeter, markers: Markers) -> Cell:
    moved, _ = fitted.displacements(markers.only(fitted.markers).points)
    return Cell(take, name, rig, fitted, moved[:: max(1, len(moved) // FRAMES)])


def judged(cell: Cell) -> tuple[list[Row], Strip]:
    """Compare the priors on one take and character; picture the worst frame at the loss `SHOWN`."""
    free = cell.weights("none", 0.0)
    base = cell.residual(free)
    frames = np.argsort(-np.abs(free).sum(axis=1))[:JUDGED]
    at_rest = crossing_pairs(cell.rig.neutral.vertices, cell.rig.neutral.triangles)

    def row(kind: str, lost: float, strength: float, weights: Floats) -> Row:
        poses = weights[frames]
        folds = [int(folded(cell.rig.neutral, cell.rig.pose(pose)).sum()) for pose in poses]
        return {
            "take": cell.take,
            "character": cell.name,
            "prior": kind,
            "fit lost": lost,
            "strength": strength,
            "residual mm": cell.residual(weights),
            "crossings": float(new_crossings(cell.rig, poses, at_rest).mean()),
            "folds": float(np.mean(folds)),
            "weights used": float((np.abs(weights) > 0.01).sum(axis=1).mean()),
            "largest weight": float(np.abs(weights).max()),
        }

    rows = [row("none", 0.0, 0.0, free)]
    worst = frames[int(np.argmax(new_crossings(cell.rig, free[frames], at_rest)))]
    sitter = Portrait.of(cell.rig, size=(260, 300))
    pictures = [Labelled(sitter.picture(free[worst]), f"none, {rows[0]['crossings']:.0f} cross")]
    for kind in COMPARED:
        for lost in LOST:
            strength, weights = cell.at(kind, base * (1 + lost))
            rows.append(row(kind, lost, strength, weights))
            if lost == SHOWN:
                label = f"{kind}, {rows[-1]['crossings']:.0f} cross"
                pictures.append(Labelled(sitter.picture(weights[worst]), label))
    return rows, Strip(f"{cell.take}, {cell.name}", tuple(pictures))


def main(out: Path, data: Path | None) -> Row:
    """Picture the priors in `figure14.png`, write the numbers, and return who has fewest artefacts at which loss."""
    rows, strips = [], []
    for cell in cells(data):
        found, strip = judged(cell)
        rows += found
        strips.append(strip)
    save_png(out / "figure14.png", sheet(strips, f"Priors at equal fit: residual up by {SHOWN:.0%}, mean crossings"))
    about = "Priors at equal fit: crossings and folds on the mesh in the worst frames (figure 14)"
    publish("range_of_motion_priors", about, rows, ["numpy", "libigl", "mien"], RESULTS if data else out)
    return {"figure": "14", "means": [_mean(rows, kind, lost) for kind in COMPARED for lost in LOST]}


def _mean(rows: list[Row], kind: str, lost: float) -> Row:
    """Average a prior over the cells, artefacts as shares of those without a prior."""
    before = {(r["take"], r["character"]): r for r in rows if r["prior"] == "none"}
    mine = [r for r in rows if r["prior"] == kind and r["fit lost"] == lost]
    left = {
        what: sum(r[what] for r in mine) / max(sum(before[r["take"], r["character"]][what] for r in mine), 1e-12)
        for what in ("crossings", "folds")
    }
    return {"prior": kind, "fit lost": lost, **left, "weights used": float(np.mean([r["weights used"] for r in mine]))}


if __name__ == "__main__":
    named = os.environ.get("MIEN_DATA", "")
    folder = Path("range_of_motion_figures")
    folder.mkdir(exist_ok=True)
    for mean in main(folder, Path(named) if named else None)["means"]:
        print(mean)
