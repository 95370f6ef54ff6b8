"""Blendshapes carried to faces whose own shapes are known.

    python -m benchmarks.rigging.ground_truth
    python -m benchmarks.rigging.ground_truth --pairs "ict_head>makehuman_adult" --no-contact

*Another identity*: ICT-FaceKit's head onto a random person of its own identity space.
That model gives everyone the same deltas, so the truth is the source's deltas, on a face
of the same size: a method that makes a larger mouth open further is marked down for it.

*Another head*: ICT's shapes onto the MakeHuman adult and child and back, and between those
two, compared with the receiving head's own ARKit shapes.  Two authors draw a smile
differently, so a perfect transfer would not reach a cosine of 1; adult and child are by
one author, who gave both nearly the same deltas in metres.

Figures over the skin vertices that move in the truth: `cos` is the direction, `gain` the
intensity along it (1 is right), median and range over the shapes.  Gaps are in mm on a
23 cm head.  `other side` counts skin near lips and lids whose source point is on the other
side of the slit.
"""

from __future__ import annotations

import argparse
import os
import resource
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.report import ROOT, Row, publish
from mien.core import Mesh, Rig, SurfacePoints
from mien.core.arrays import Floats, Ints
from mien.evaluate.gaps import gaps
from mien.evaluate.metrics import millimetre
from mien.geometry.surface import distances_along
from mien.io.documents import join, landmarks_on_mesh, read_landmarks
from mien.io.formats import read_rig
from mien.rigging.blendshapes import METHODS, carried
from mien.rigging.dense import DenseFit, lay
from mien.vocabularies import match, shape_key
from mien.vocabularies.openings import INNER_LIPS, LEFT_LIDS, RIGHT_LIDS

PAIRS = (
    ("ict_head", "another identity"),
    ("ict_head", "another identity, exact"),
    ("ict_head", "makehuman_adult"),
    ("ict_head", "makehuman_child"),
    ("makehuman_adult", "ict_head"),
    ("makehuman_adult", "makehuman_child"),
    ("makehuman_child", "makehuman_adult"),
)
MOVING = 0.05
"""A vertex moves in a shape if it goes at least this share of the farthest."""
LEAST = 1e-4
"""A shape that moves no skin farther than this [m] has nothing to compare."""
NEAR_SLIT_MM = 12.0
CLEAR_MM = 3.0
"""A vertex is on a side of a slit if the other is this much farther along the skin."""


class Agreement(NamedTuple):
    """How a carried shape compares with the target's own: cosine and gain."""

    cosine: float
    gain: float


def load(folder: Path, name: str) -> Rig:
    """Read a rig of the collection with its landmarks."""
    rig = read_rig(folder / "rigs" / f"{name}.glb")
    path = folder / "rigs" / f"{name}.landmarks.json"
    return replace(rig, landmarks=landmarks_on_mesh(read_landmarks(path), rig.neutral, path), name=name)


def identity(folder: Path, rig: Rig, seed: int = 0) -> Rig:
    """Make another person of ICT's: a random combination of its identities, one standard deviation each."""
    with np.load(folder / "rigs" / "ict_identities.npz") as archive:
        basis = archive[archive.files[0]][:, : len(rig.neutral.vertices)]
    shares = np.random.default_rng(seed).normal(size=len(basis))
    moved = rig.neutral.vertices + np.tensordot(shares, basis, axes=1)
    return replace(rig, neutral=replace(rig.neutral, vertices=moved), name="another identity")


def laid(source: Rig, target: Rig) -> DenseFit:
    """Lay a rig on another by all landmarks they share."""
    names = [name for name in source.landmarks if name in target.landmarks]
    ours, theirs = (join([rig.landmarks[name] for name in names]) for rig in (source, target))
    return lay(source.neutral, ours, target.neutral, theirs)


def exact(source: Rig, target: Rig) -> DenseFit:
    """Return the correspondence of two meshes with the same vertices."""
    fit = laid(source, target)
    same = SurfacePoints.at_vertices(np.arange(len(source.neutral.vertices)))
    stuck = np.where(fit.source_skin[:, None], target.neutral.vertices, fit.warped)
    nothing = np.zeros(len(stuck))
    return replace(fit, points=same, back=same, stuck=stuck, paired=fit.source_skin, back_distance=nothing)


def own_shapes(source: Rig, target: Rig) -> Rig:
    """Return the source with its shapes under the target's names, halves added up; those both have only."""
    found = match(source.blendshapes.names, target.blendshapes.names)
    keys = [shape_key(name) for name in source.blendshapes.names]
    moving = np.abs(target.blendshapes.deltas).max(axis=(1, 2)) > LEAST
    rows = []
    for i, name in enumerate(target.blendshapes.names):
        parts = np.flatnonzero(found.matrix[i])
        half = shape_key(name).side and not any(keys[p].side for p in parts)
        if len(parts) and moving[i] and not half:
            rows.append((name, parts))
    deltas = np.stack([source.blendshapes.deltas[parts].sum(axis=0) for _, parts in rows])
    return replace(source, blendshapes=replace(source.blendshapes, names=tuple(n for n, _ in rows), deltas=deltas))


def agreement(result: Floats, truth: Floats, skin: np.ndarray) -> list[Agreement]:
    """Compare shapes `(K, N, 3)`."""
    rows = []
    for ours, theirs in zip(result, truth, strict=True):
        length = np.linalg.norm(theirs, axis=1)
        counted = skin & (length >= MOVING * length[skin].max())
        product, power = (ours[counted] * theirs[counted]).sum(), (theirs[counted] ** 2).sum()
        size = np.sqrt((ours[counted] ** 2).sum() * power)
        rows.append(Agreement(float(product / size) if size > 0 else 0.0, float(product / power)))
    return rows


def closed_gaps(rig: Rig) -> dict[str, float]:
    """Measure the lids in a blink and the lips with the jaw open and the mouth closed, the worse side [mm]."""
    stems = [shape_key(name).stem for name in rig.blendshapes.names]
    poses = np.array([[stem == "eyeblink" for stem in stems], [stem in ("jawopen", "mouthclose") for stem in stems]])
    measured = gaps(rig, poses.astype(np.float64), millimetre(rig))
    assert measured is not None
    both = {"jawopen", "mouthclose"} <= set(stems)
    return {"lids": float(measured.lids[0].max()), "lips": float(measured.lips[1]) if both else float("nan")}


def other_side(source: Rig, target: Rig, fit: DenseFit) -> tuple[int, int]:
    """Count target vertices near slits whose source point is on the other side, and all that are near."""
    wrong, near = 0, np.zeros(len(fit.target.vertices), np.bool_)
    for pairs in (RIGHT_LIDS, LEFT_LIDS, INNER_LIPS):
        there, distance = _sides(target, pairs)
        here, _ = _sides(source, pairs)
        close = fit.target_skin & (distance < NEAR_SLIT_MM * millimetre(target)) & (np.abs(there) > CLEAR_MM)
        at = fit.back.of(np.clip(here, -10, 10)[:, None])[:, 0]
        wrong += int((close & (there * at < 0) & (np.abs(at) > CLEAR_MM)).sum())
        near |= close
    return wrong, int(near.sum())


def _sides(rig: Rig, pairs: tuple[tuple[int, int], ...]) -> tuple[Floats, Floats]:
    """`(N,)` how much nearer [mm] the upper side is than the lower along the skin, and the distance to the nearer."""
    along = [_along(rig.neutral, rig, [pair[side] for pair in pairs]) for side in (0, 1)]
    finite = [np.where(np.isfinite(a), a, 1e3) for a in along]
    return (finite[1] - finite[0]) / millimetre(rig), np.minimum(*finite)


def _along(mesh: Mesh, rig: Rig, numbers: list[int]) -> Floats:
    marks: Ints = np.concatenate([rig.landmarks[f"ibug_{n}"].corners[:, 0] for n in numbers])
    return np.asarray(distances_along(mesh, marks).min(axis=0))


def measure(source: Rig, target: Rig, fit: DenseFit, method: str, contact: bool, label: str, sides: str) -> Row:
    """Return a row of figures, with the figures of each shape under `per_shape`."""
    start, busy = time.perf_counter(), time.process_time()
    shapes, _ = carried(source, fit, method, contact=contact)
    seconds, busy = time.perf_counter() - start, time.process_time() - busy
    truth = np.stack([target.blendshapes.deltas[target.blendshapes.index(name)] for name in shapes.names])
    seen = np.flatnonzero(np.abs(truth[:, fit.target_skin]).max(axis=(1, 2)) > LEAST)
    each = agreement(shapes.deltas[seen], truth[seen], fit.target_skin)
    cosines, gains = (np.array([row[i] for row in each]) for i in (0, 1))
    before, after, goal = (
        closed_gaps(rig) for rig in (source, replace(target, blendshapes=shapes, skeleton=None, skin=None), target)
    )
    row: Row = {"pair": f"{source.name}>{label}", "method": method, "shapes": len(each)}
    row |= {"cos": float(np.median(cosines)), "cos min": float(cosines.min()), "cos max": float(cosines.max())}
    row |= {"gain": float(np.median(gains)), "gain min": float(gains.min()), "gain max": float(gains.max())}
    for part in ("lids", "lips"):
        row[f"{part} mm"] = " / ".join(f"{value[part]:.2f}" for value in (before, after, goal))
    row |= {"other side": sides, "s": seconds, "cpu s": busy}
    row["peak MB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    row["per_shape"] = {
        name: agree._asdict() for name, agree in zip([shapes.names[i] for i in seen], each, strict=True)
    }
    return row


def run(folder: Path, pair: tuple[str, str], contact: bool) -> list[Row]:
    """Return the rows of a pair, one a method."""
    source = load(folder, pair[0])
    same = pair[1].startswith("another identity")
    target = identity(folder, source) if same else load(folder, pair[1])
    rig = own_shapes(source, target)
    fit = exact(source, target) if pair[1].endswith("exact") else laid(source, target)
    wrong, near = other_side(source, target, fit)
    return [measure(rig, target, fit, method, contact, pair[1], f"{wrong} of {near}") for method in METHODS]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data")))
    parser.add_argument("--pairs", nargs="+", help="only pairs source>target that contain one of these")
    parser.add_argument("--no-contact", action="store_true", help="without closing lids and lips")
    parser.add_argument("--shapes", action="store_true", help="also every shape on its own")
    args = parser.parse_args()
    chosen = [p for p in PAIRS if args.pairs is None or any(word in ">".join(p) for word in args.pairs)]
    with threadpool_limits(1):
        rows = [row for pair in chosen for row in run(args.data, pair, not args.no_contact)]
    each = [row.pop("per_shape") for row in rows]
    for row, figures in zip(rows, each, strict=True):
        weakest = min(figures, key=lambda name: figures[name]["cosine"])
        row["weakest"] = weakest
    name = "rigging_ground_truth" + ("_no_contact" if args.no_contact else "")
    about = "Blendshapes carried, all landmarks; gaps: on the source / carried / the target's own"
    publish(name, about, rows, ["numpy", "scipy", "libigl"])
    if not args.shapes:
        return
    detail = [
        {"pair": row["pair"], "method": row["method"], "shape": shape, **values}
        for row, figures in zip(rows, each, strict=True)
        for shape, values in figures.items()
    ]
    publish(name + "_shapes", "The same shape by shape", detail, ["numpy"])


if __name__ == "__main__":
    main()
