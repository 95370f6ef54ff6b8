"""Fit: a head laid on a decimated copy of itself, where every vertex's true place is known.

    python -m benchmarks.paper_figures.rig_transfer.decimated

`skin to copy` is how far the stuck vertices are from the copy's surface, `copy to skin` how far the
copy's vertices are from the stuck skin, `place` how far a stuck vertex is from the point of the copy
nearest to where it really is: all means, as shares of the diagonal of the head's box.  A copy cannot
have every point of the original: how far the original is from it is `copy off`.
"""

from __future__ import annotations

import igl
import numpy as np

from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.faces import SETS, Settings, with_landmarks
from benchmarks.report import Row, publish
from mien.core import Mesh, Rig
from mien.core.arrays import Ints
from mien.core.rig import no_blendshapes
from mien.geometry.surface import closest_points, distances_along
from mien.library.generic import generic_rig
from mien.rigging.dense import lay
from mien.rigging.landmarks import paired_landmarks
from mien.rigging.warp_and_stick.sheet import skin_of, twins_of

KEPT = (0.9, 0.5, 0.25)
"""Shares of the triangles that the copies keep."""
HEADS = ("actor", "cartoon", "MakeHuman adult", "MakeHuman child")
"""Heads whose skin is a manifold, which the decimation needs."""


def decimated(settings: Settings) -> None:
    """Write the table."""
    heads = {"generic": generic_rig()} | {name: settings.bare(name) for name in HEADS if name in settings.faces}
    rows = [_row(name, rig, share, marks) for name, rig in heads.items() for share in KEPT for marks in SETS]
    about = "A head laid on a decimated copy of itself: mean distances in % of the diagonal"
    publish("rig_transfer_decimated", about, rows, ["numpy", "libigl"], settings.results)


def fewer(rig: Rig, share: float) -> Rig:
    """Return the skin of a head with a share of its triangles, and its landmarks on them.

    Lips touch, so a landmark goes to the closest point around the vertex nearest to it along the skin.
    """
    skin, number = skin_mesh(rig)
    vertices, triangles, _, kept = igl.qslim(skin.vertices, skin.triangles, int(share * len(skin.triangles)))
    mesh = Mesh(np.asarray(vertices), np.asarray(triangles))
    places = np.concatenate([point.of(rig.neutral.vertices) for point in rig.landmarks.values()])
    corners = np.array([point.corners[0, point.weights[0].argmax()] for point in rig.landmarks.values()])
    near = np.argmin(distances_along(skin, number[corners])[:, kept], axis=1)
    marks = {}
    for name, place, vertex in zip(rig.landmarks, places, near, strict=True):
        around = mesh.triangles[(mesh.triangles == vertex).any(axis=1)]
        marks[name] = closest_points(mesh.vertices, around, place[None])[0]
    return Rig(mesh, no_blendshapes(len(mesh.vertices)), landmarks=marks, name=f"{rig.name}, {share:.0%}")


def skin_mesh(rig: Rig) -> tuple[Mesh, Ints]:
    """Return what hangs together with the landmarks, seams sewn, and the number there of each vertex `(N,)`, or -1."""
    mesh = rig.neutral
    twins = twins_of(mesh.vertices, mesh.triangles)
    carrying = np.concatenate([point.corners.ravel() for point in rig.landmarks.values()])
    chosen = skin_of(mesh.triangles, twins, len(mesh.vertices), carrying)[mesh.triangles].all(axis=1)
    first = np.arange(len(mesh.vertices))
    np.minimum.at(first, twins[:, 1], twins[:, 0])
    used, triangles = np.unique(first[mesh.triangles[chosen]], return_inverse=True)
    number = np.full(len(first), -1)
    number[used] = np.arange(len(used))
    return Mesh(mesh.vertices[used], triangles.reshape(-1, 3)), number[first]


def _row(name: str, rig: Rig, share: float, marks: str) -> Row:
    copy = with_landmarks(fewer(rig, share), SETS[marks])
    pairs = paired_landmarks(rig, copy)
    fit = lay(rig.neutral, pairs.source, copy.neutral, pairs.target)
    diagonal = float(np.linalg.norm(np.ptp(copy.neutral.vertices, axis=0)))
    skin = fit.paired
    own, target = rig.neutral.vertices[skin], (copy.neutral.vertices, copy.neutral.triangles)
    true, off, _ = closest_points(*target, own)
    stuck = fit.stuck[skin]
    _, apart, _ = closest_points(*target, stuck)
    places = np.linalg.norm(stuck - true.of(copy.neutral.vertices), axis=1)
    percent = 100 / diagonal
    return {
        "head": name,
        "vertices": int(fit.source_skin.sum()),
        "copy's": len(copy.neutral.vertices),
        "landmarks": len(pairs.names),
        "skin to copy %": percent * float(apart.mean()),
        "copy to skin %": percent * float(fit.back_distance.mean()),
        "place %": percent * float(places.mean()),
        "place 95 %": percent * float(np.percentile(places, 95)),
        "copy off %": percent * float(off.mean()),
        "folds": fit.folds_after,
    }


if __name__ == "__main__":
    run(__doc__, decimated)
