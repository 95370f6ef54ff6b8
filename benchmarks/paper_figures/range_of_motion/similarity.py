"""Figures 7 and 8: similarity of frames and shapes before and after contrast, and the key expressions.

python -m benchmarks.paper_figures.range_of_motion.similarity
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.paper_figures.range_of_motion.performers import cases, name_of
from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import Row, publish
from mien.core.arrays import Floats
from mien.evaluate import Case
from mien.io.files import written_whole
from mien.look.plots import as_png, cumulative_correlation, similarity_matrix
from mien.retargeting.range_of_motion import Alignment, RangeOfMotion

SHOWN = 24
"""Shapes in the picture: those with the largest movement, as many as can be read."""
WINDOW = 500
"""Frames of the take that figure 8 shows: more, and the peaks hide the curve."""
CLEAR, NONE = 0.7, 0.2
"""A similarity above the first says yes, below the second no; what lies between says neither."""


def likeness(settings: Settings) -> None:
    """Picture the first and the last case, and measure all."""
    rows: list[Row] = []
    made = list(cases(settings))
    for case in made:
        found = RangeOfMotion(shapes="alignment").align(case.prepared, case.character)
        rows.append(_measured(case, found))
        if case in (made[0], made[-1]):
            _pictured(case, found, settings.out)
    about = "Similarity of the actor's frames to the character's shapes (figures 7 and 8)"
    publish("range_of_motion_similarity", about, rows, ("numpy", "scipy", "mien"), settings.results)


def _measured(case: Case, found: Alignment) -> Row:
    raw, enhanced = np.maximum(found.similarity.correlation, 0), found.similarity.enhanced
    seen = raw.max(axis=0) > 0
    keys = found.keys.frames
    truth = np.asarray(case.truth_range.values)
    return {
        "character": name_of(case),
        "shapes": len(raw),
        "frames": raw.shape[1],
        "keys": len(keys),
        "keys per 1000 frames": 1000 * len(keys) / raw.shape[1],
        "undecided, raw": float(_undecided(raw[:, seen])),
        "undecided, enhanced": float(_undecided(enhanced[:, seen])),
        "shapes with a key above .7": int((raw[:, keys].max(axis=1) > CLEAR).sum()),
        "moving shapes": int((truth.max(axis=0) > 0.1).sum()),
    }


def _undecided(similarity: Floats) -> Floats:
    """Return the share of entries that say neither yes nor no."""
    return np.asarray(((similarity > NONE) & (similarity < CLEAR)).mean())


def _pictured(case: Case, found: Alignment, folder: Path) -> None:
    size = np.linalg.norm(found.original, axis=(1, 2))
    largest = np.sort(np.argsort(-size, kind="stable")[:SHOWN])
    order = largest[np.argsort(-found.similarity.trust[largest], kind="stable")]
    names = [case.character.blendshapes.names[k] for k in order]
    name = name_of(case)
    for kind, values in (
        ("raw", np.maximum(found.similarity.correlation, 0)),
        ("enhanced", found.similarity.enhanced),
    ):
        _save(folder / f"figure7-{name}-{kind}.png", similarity_matrix(values[order], names))
    keys = found.keys.frames[found.keys.frames < WINDOW].tolist()
    _save(folder / f"figure8-{name}.png", cumulative_correlation(found.keys.cumulative[:WINDOW], keys))


def _save(path: Path, figure: Figure) -> None:
    with written_whole(path) as temporary:
        temporary.write_bytes(as_png(figure, 110))


if __name__ == "__main__":
    run(__doc__, likeness)
