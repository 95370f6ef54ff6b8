"""Table 1: how long the alignment takes, and a frame, beside the paper's own times.

    python -m benchmarks.paper_figures.range_of_motion.timings

The paper: i7 at 3.4 GHz; the alignment in Python with SciPy's sparse solver, the frames in C++ with Eigen.
"""

from __future__ import annotations

import numpy as np

from benchmarks.paper_figures.range_of_motion.performers import cases, name_of
from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import Row, median_seconds, publish
from mien.evaluate import Case
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.settings import PAPER, SolveSettings
from mien.retargeting.shape_retargeter import shape_retargeter

PUBLISHED = (
    ("Loki", 46, 73, 46, 18.71),
    ("Osipa", 33, 71, 43, 5.37),
    ("Mery", 54, 82, 49, 23.25),
    ("Billy", 39, 76, 48, 7.57),
)
"""Face, shapes, key expressions of their first and second sequence, seconds of blendshape transfer."""
PUBLISHED_MARKERS, PUBLISHED_FPS = 99, 105
PRESETS = {
    "as published": RangeOfMotion(shapes="alignment", solve=SolveSettings(**PAPER)),
    "default": RangeOfMotion(),
}


def timings(settings: Settings) -> None:
    """Time the method on every case."""
    rows: list[Row] = [
        {
            "face": f"{face} (paper)",
            "preset": "as published",
            "shapes": count,
            "markers": PUBLISHED_MARKERS,
            "keys": f"{first}, {second}",
            "alignment s": seconds,
            "frames/s": PUBLISHED_FPS,
        }
        for face, count, first, second, seconds in PUBLISHED
    ]
    repeats = 1 if settings.quick else 3
    rows += [_timed(case, preset, repeats) for case in cases(settings) for preset in PRESETS]
    publish(
        "range_of_motion_timings", "Table 1: alignment and solve", rows, ("numpy", "scipy", "mien"), settings.results
    )


def _timed(case: Case, preset: str, repeats: int) -> Row:
    method, names = PRESETS[preset], case.character.blendshapes.names
    prepared = case.prepared
    found = method.align(prepared, case.character)
    fitted = shape_retargeter(method.name, case.character, prepared, found.personal, method.solve)
    take, _ = fitted.displacements(case.test.only(fitted.markers).points)
    fitted.solver.batch(take[:2])
    solve = median_seconds(lambda: fitted.solver.batch(take, case.test.fps), repeats)
    state, live = fitted.start(), []
    for frame in case.test.points[:: max(1, len(take) // 200)]:
        state, weights = fitted.step(state, frame)
        live.append(weights)
    assert np.isfinite(live).all()
    return {
        "face": name_of(case),
        "preset": preset,
        "shapes": len(names),
        "markers": len(case.pairs),
        "keys": str(len(found.keys.frames)),
        "training frames": len(prepared.take),
        "alignment s": median_seconds(lambda: method.align(prepared, case.character), repeats),
        "frames/s": round(len(take) / solve),
    }


if __name__ == "__main__":
    run(__doc__, timings)
