"""Where the folds are that repair leaves: on skin that the face has, or on skin that it lacks?

    MIEN_DATA=/path/to/data python -m benchmarks.rigging.folds --picture docs/pictures/rig-folds.png

A triangle of the generic face that sticking turned over lies on skin that the face lacks if one of
its corners has no place there, or was moved so far by sticking that nothing of the face is near:
the warp has brought it within a millimetre or two wherever there is something.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import numpy as np

from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import RESULTS, ROOT, Row, publish
from mien.core.arrays import Flags, Floats, Ints
from mien.core.units import face_radius
from mien.library.generic import generic_rig
from mien.rigging.dense import DenseFit, lay
from mien.rigging.landmarks import paired_landmarks
from mien.rigging.warp_and_stick.folds import folded

FAR = 0.25
"""Skin that sticking moves by more than this share of the face's radius has nothing of the face near."""
SHOWN = "toon"


def fits(settings: Settings, name: str) -> DenseFit:
    """Lay the generic face on another by all landmarks."""
    generic, face = generic_rig(), settings.bare(name)
    pairs = paired_landmarks(generic, face)
    return lay(generic.neutral, pairs.source, face.neutral, pairs.target)


def folds_of(fit: DenseFit) -> tuple[Ints, Flags, Flags]:
    """Return the triangles of the skin `(T, 3)`, which are folded, and which lie on skin that the face lacks."""
    triangles = fit.source.triangles[fit.source_skin[fit.source.triangles].all(axis=1)]
    radius = face_radius(fit.warp(fit.warp.centres))
    lost = ~fit.paired | (np.linalg.norm(fit.stuck - fit.warped, axis=1) > FAR * radius)
    return triangles, folded(fit.warped, fit.stuck, triangles), np.asarray(lost[triangles].any(axis=1))


def measure(fit: DenseFit, name: str) -> Row:
    """Count one face's folds."""
    region = generic_rig().anatomy
    assert region is not None
    labels = region.labels["region"]
    triangles, turned, lacking = folds_of(fit)
    inside = labels.of[triangles[:, 0]] == labels.names.index("mouth_interior")
    return {
        "face": name,
        "folds": int(turned.sum()),
        "on skin it lacks": int((turned & lacking).sum()),
        "… in its mouth": int((turned & lacking & inside).sum()),
        "on skin it has": int((turned & ~lacking).sum()),
    }


def section(vertices: Floats, triangles: Ints, height: float) -> list[Floats]:
    """Cut triangles at `x = height`; return the cuts, `(2, 2)` ends in z and y."""
    corners = vertices[triangles]
    side = corners[:, :, 0] - height
    crossed = np.flatnonzero((side.min(axis=1) < 0) & (side.max(axis=1) > 0))
    cuts = []
    for points, off in zip(corners[crossed], side[crossed], strict=True):
        ends = [
            points[i] + off[i] / (off[i] - off[j]) * (points[j] - points[i])
            for i, j in ((0, 1), (1, 2), (2, 0))
            if off[i] * off[j] < 0
        ]
        if len(ends) == 2:
            cuts.append(np.array(ends)[:, [2, 1]])
    return cuts


def picture(fit: DenseFit, name: str, path: Path) -> None:
    """Draw the middle of a face with the generic skin on it, and its folds from in front."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.collections import LineCollection, PolyCollection

    triangles, turned, lacking = folds_of(fit)
    own = fit.target.triangles[fit.target_skin[fit.target.triangles].all(axis=1)]
    centimetre = 100.0
    middle = float(fit.warp(fit.warp.centres)[:, 0].mean()) + 1e-4
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 5.2), width_ratios=(1.15, 1))
    for vertices, faces, colour, wide, what in (
        (fit.warped, triangles, "#4c9fd6", 1.0, "generic, warped"),
        (fit.stuck, triangles, "#d64545", 1.0, "generic, stuck"),
        (fit.target.vertices, own, "black", 1.8, f"the {name}'s own skin"),
    ):
        cuts = [centimetre * cut for cut in section(vertices, faces, middle)]
        left.add_collection(LineCollection(cuts, colors=colour, linewidths=wide, label=what))
    left.autoscale()
    left.set_title("cut through the middle [cm]", fontsize=10)
    left.legend(fontsize=8, loc="lower left")
    front = centimetre * fit.target.vertices[:, :2]
    edges = front[np.concatenate([own[:, [0, 1]], own[:, [1, 2]]])]
    right.add_collection(LineCollection(list(edges), colors="#00000020", linewidths=0.3))
    shapes = centimetre * fit.stuck[:, :2][triangles]
    for which, colour, what in (
        (turned & lacking, "#d64545", "folds on skin it lacks"),
        (turned & ~lacking, "#2f6fd0", "folds on skin it has"),
    ):
        some = PolyCollection(list(shapes[which]), facecolors=colour, edgecolors=colour, alpha=0.6, linewidths=1.2)
        some.set_label(f"{what}: {int(which.sum())}")
        right.add_collection(some)
    right.autoscale()
    right.set_title("from in front", fontsize=10)
    right.legend(fontsize=8, loc="lower right")
    for axes in (left, right):
        axes.set_aspect("equal")
        axes.tick_params(labelsize=7)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")))
    parser.add_argument("--picture", type=Path, help=f"where the picture of the {SHOWN} is written")
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the table")
    args = parser.parse_args()
    data = args.data if (args.data / "rigs").is_dir() else None
    settings = Settings(args.out, data, False, args.out)
    rows = []
    for name in settings.faces:
        fit = fits(settings, name)
        rows.append(measure(fit, name))
        if name == SHOWN and args.picture is not None:
            picture(fit, name, args.picture)
    about = "Folds that repair leaves, by all landmarks, on skin that the face has and on skin that it lacks"
    publish("rigging_folds", about, rows, ["numpy", "scipy", "libigl"], args.out)


if __name__ == "__main__":
    main()
