"""Rig transfer: how long it takes, beside SciPy's radial basis functions and deformation transfer as it is usually done.

    python -m benchmarks.speed.rig_transfer
    python -m benchmarks.speed.rig_transfer --quick
    python -m benchmarks.speed.rig_transfer --most 50000 --methods warp-and-stick    # minutes less
    MIEN_DATA=/path/to/data python -m benchmarks.speed.rig_transfer    # with ICT's 26,719 vertices too

One thread, in seconds of the processor, so that a busy machine favours nobody; compilation happens
before the clock starts.  Peak memory is the whole process', interpreter and libraries included, each
case of its own process.  The cost curve moves the generic rig onto the actor's skin, decimated and
then subdivided; its exponent is the slope of a line through the logarithms.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import igl
import numpy as np
from scipy.interpolate import RBFInterpolator
from threadpoolctl import threadpool_limits

from benchmarks.paper_figures.rig_transfer.decimated import fewer, skin_mesh
from benchmarks.report import RESULTS, ROOT, Row, publish
from mien.core import Mesh, Rig, SurfacePoints
from mien.core.rig import no_blendshapes
from mien.geometry.tps import fit_thin_plate
from mien.library.generic import generic_rig
from mien.library.heads import HEADS
from mien.rigging.dense import lay
from mien.rigging.landmarks import paired_landmarks
from mien.rigging.structure import Structure
from mien.rigging.transfer import METHODS, transfer_rig

SIZES = (1_000, 3_125, 12_500, 50_000, 200_000)
SMALL = 1_500
PEER_SHAPES = 2


def cpu_seconds(work: Callable[[], object], repeats: int) -> float:
    """Return the least processor time of some runs."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def head(vertices: int) -> Rig:
    """Return the actor's skin with about so many vertices, decimated and then subdivided in the plane."""
    rig = HEADS["actor"]()
    halvings, wanted = 0, float(vertices)
    while wanted > 3_500:
        wanted, halvings = wanted / 4, halvings + 1
    coarse = fewer(rig, min(1.0, wanted / len(skin_mesh(rig)[0].vertices)))
    points, triangles = igl.upsample(coarse.neutral.vertices, coarse.neutral.triangles, halvings)
    mesh = Mesh(np.asarray(points), np.asarray(triangles))
    # the vertices of the coarse mesh come first; two landmarks on one vertex would be one too many
    vertex = {int(point.corners[0, point.weights[0].argmax()]): name for name, point in coarse.landmarks.items()}
    marks = {name: SurfacePoints.at_vertices(np.array([number])) for number, name in vertex.items()}
    return Rig(mesh, no_blendshapes(len(points)), landmarks=marks, name=f"actor of {len(points)}")


def small(repeats: int) -> list[Row]:
    """Time the whole transfer onto a small face, and its stages."""
    generic, face = generic_rig(), head(SMALL)
    pairs = paired_landmarks(generic, face)

    def laid() -> object:
        return lay(generic.neutral, pairs.source, face.neutral, pairs.target)

    fit = lay(generic.neutral, pairs.source, face.neutral, pairs.target)
    name = f"generic rig ({int(fit.source_skin.sum())} of skin) onto {len(face.neutral.vertices)}"
    transfer_rig(generic, face)
    return [
        {"case": name, "cpu s": cpu_seconds(lambda: transfer_rig(generic, face), repeats)},
        {"case": "… of it warping and sticking", "cpu s": cpu_seconds(laid, repeats)},
        {"case": "… of it the dense warp", "cpu s": cpu_seconds(lambda: Structure.of(fit), repeats)},
    ]


def dense_warp(repeats: int) -> list[Row]:
    """Solve and evaluate the same dense warp with SciPy: the same centres, the same points."""
    generic, face = generic_rig(), head(SMALL)
    pairs = paired_landmarks(generic, face)
    structure = Structure.of(lay(generic.neutral, pairs.source, face.neutral, pairs.target))
    centres = structure.warp.centres
    targets = structure.warp(centres)
    assert generic.anatomy is not None
    points = np.concatenate([muscle.fibre for muscle in generic.anatomy.muscles] + [generic.neutral.vertices])

    def peer() -> np.ndarray:
        return np.asarray(RBFInterpolator(centres, targets, kernel="linear", degree=1)(points))

    ours = cpu_seconds(lambda: fit_thin_plate(centres, targets)(points), repeats)
    theirs = cpu_seconds(peer, repeats)
    mine = fit_thin_plate(centres, targets)(points)
    difference = float(np.abs(mine - peer()).max() / np.ptp(mine))
    return [
        {"case": f"warp of {len(centres)} centres at {len(points)} points", "cpu s": ours},
        {
            "case": "… SciPy RBFInterpolator",
            "cpu s": theirs,
            "times mien's": theirs / ours,
            "difference": difference,
        },
    ]


def large(data: Path, method: str) -> Row:
    """Move ICT's whole head with its shapes onto another person of it."""
    from benchmarks.rigging.ground_truth import identity, load

    source = load(data, "ict_head")
    target = identity(data, source, seed=1)
    target = replace(target, blendshapes=no_blendshapes(len(target.neutral.vertices)))
    _warm()
    start = time.process_time()
    moved = transfer_rig(source, target, method=method)
    seconds = time.process_time() - start
    return {
        "case": f"{len(source.blendshapes)} shapes, {len(source.neutral.vertices)} onto {len(target.neutral.vertices)}: {method}",
        "cpu s": seconds,
        "peak MB": _peak(),
        **{name: value for name, value in moved.figures.items() if name.startswith("structure")},
    }


def curve(vertices: int) -> Row:
    """Move the generic rig onto the actor of some size."""
    face = head(vertices)
    _warm()
    start = time.process_time()
    transfer_rig(generic_rig(), face)
    seconds = time.process_time() - start
    return {"case": "cost curve", "vertices": len(face.neutral.vertices), "cpu s": seconds, "peak MB": _peak()}


def peer_transfer(data: Path) -> list[Row]:
    """Solve deformation transfer shape by shape, as public implementations do, beside ours."""
    from benchmarks.rigging.deformation_transfer import shape_by_shape
    from benchmarks.rigging.ground_truth import exact, identity, load
    from mien.rigging.blendshapes import dense
    from mien.rigging.blendshapes.deformation_transfer import Anchors, counterparts, solve

    rig = load(data, "ict_face")
    deltas, triangles, source = rig.blendshapes.deltas, rig.neutral.triangles, rig.neutral.vertices
    fit = exact(rig, identity(data, rig, seed=1))
    target = fit.target.vertices
    guess = dense.transfer(deltas, fit, fit.back)

    def ours() -> object:
        return solve(source, triangles, deltas, target, triangles, fit.back, guess=guess, turn=np.eye(3))

    seconds = cpu_seconds(ours, 1)
    origin, anchors = counterparts(source, triangles, fit.back, triangles), Anchors.of(guess, triangles)
    some = np.flatnonzero(np.abs(deltas).max(axis=(1, 2)) > 0)[:PEER_SHAPES]
    peer = cpu_seconds(
        lambda: shape_by_shape(source, deltas[some], target, triangles, origin, guess[some], anchors.held), 1
    )
    peer *= len(deltas) / len(some)
    return [
        {"case": f"deformation transfer, {len(deltas)} shapes, {len(target)} vertices", "cpu s": seconds},
        {"case": f"… shape by shape, from {len(some)} of them", "cpu s": peer, "times mien's": peer / seconds},
    ]


def _warm() -> None:
    """Compile everything, so that the clock sees only work."""
    transfer_rig(generic_rig(), head(1_000))


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _apart(work: Callable[..., Row], *arguments: object) -> Row:
    """Run one case in a process of its own, so that its memory is told from the others'."""
    with multiprocessing.get_context("spawn").Pool(1, threadpool_limits, (1,)) as pool:
        return pool.apply(work, arguments)


def exponent(rows: list[Row]) -> float:
    """Return the slope of time over vertices in logarithms."""
    vertices, seconds = (np.log([row[key] for row in rows]) for key in ("vertices", "cpu s"))
    return float(np.polyfit(vertices, seconds, 1)[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--quick", action="store_true", help="without the large meshes")
    parser.add_argument("--most", type=int, default=max(SIZES), help="vertices of the largest mesh of the cost curve")
    parser.add_argument("--methods", nargs="*", choices=METHODS, default=list(METHODS), help="for ICT's head")
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the table")
    args = parser.parse_args()
    with threadpool_limits(1):
        rows = small(args.repeats) + dense_warp(args.repeats)
        sizes = [size for size in (SIZES[:2] if args.quick else SIZES) if size <= args.most]
        points = [_apart(curve, size) for size in sizes]
        points[-1] |= {"exponent": exponent(points)}
        if len(points) > 3:
            points[-1] |= {"of the last three": exponent(points[-3:])}
        rows += points
        if (args.data / "rigs").is_dir() and not args.quick:
            rows += [_apart(large, args.data, method) for method in args.methods]
            if "deformation-transfer" in args.methods:
                rows += peer_transfer(args.data)
    about = "Rig transfer, one thread, seconds of the processor; peak memory of the whole process"
    publish("speed_rig_transfer", about, rows, ["numpy", "scipy", "libigl"], args.out)


if __name__ == "__main__":
    main()
