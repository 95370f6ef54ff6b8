"""Figure 17: the character's shapes, their warp onto the actor, and the actor's own found by alignment.

    python -m benchmarks.paper_figures.range_of_motion.shapes

The table says how far each is from what the actor's shapes really are.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks.paper_figures.range_of_motion.performers import cases, found_shapes, name_of
from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import Row, publish
from mien.core.arrays import Floats
from mien.evaluate import Case
from mien.evaluate.metrics import shape_error
from mien.io.files import written_whole
from mien.look.plots import as_png, sparse_blendshapes

SHOWN = 8
PICTURED = ("adult", "toon", "cartoon")


def shapes(settings: Settings) -> None:
    """Measure the shapes of every case, and picture some."""
    rows: list[Row] = []
    for case in cases(settings):
        found = found_shapes(case)
        rows += [_measured(case, label, values) for label, values in found.items()]
        if name_of(case) in PICTURED:
            _pictured(case, found, settings.out)
    about = "The actor's shapes as found, against the true ones (figure 17)"
    publish("range_of_motion_shapes", about, rows, ("numpy", "scipy", "mien"), settings.results)


def _measured(case: Case, label: str, found: Floats) -> Row:
    truth, shown = case.shapes("range"), case.shown
    size, true_size = (np.linalg.norm(values[shown], axis=(1, 2)) for values in (found, truth))
    alike = (found[shown] * truth[shown]).sum(axis=(1, 2)) / np.maximum(size * true_size, 1e-12)
    return {
        "character": name_of(case),
        "shapes": label,
        "relative error": shape_error(found, truth, shown),
        "median cosine": float(np.median(alike)),
        "median strength": float(np.median(size / np.maximum(true_size, 1e-12))),
    }


def _pictured(case: Case, found: Mapping[str, Floats], folder: Path) -> None:
    truth = case.shapes("range") * case.shown[:, None, None]
    chosen = np.sort(np.argsort(-np.linalg.norm(truth, axis=(1, 2)), kind="stable")[:SHOWN])
    turn = case.prepared.terms.placement.rotation.T
    neutral = case.prepared.terms.actor_neutral @ turn / 100
    own, warped, aligned = (found[label][chosen] @ turn / 100 for label in ("own", "RBF", "aligned"))
    names = [case.character.blendshapes.names[k] for k in chosen]
    path = folder / f"figure17-{name_of(case)}.png"
    with written_whole(path) as temporary:
        temporary.write_bytes(as_png(sparse_blendshapes(neutral, names, own, warped, aligned), 110))


if __name__ == "__main__":
    run(__doc__, shapes)
