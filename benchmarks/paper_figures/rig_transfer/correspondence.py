"""Figures 3, 13 and 14: the generic face warped onto another and stuck to it, in pictures and in numbers.

    python -m benchmarks.paper_figures.rig_transfer.correspondence

The table says how well the landmarks are met, whether every stuck vertex lies on the face (found
again by an independent closest-point search), and how many triangles are turned over.
Lengths are shares of the face's radius, the root mean square distance of its landmarks from
their middle, or millimetres on a human-sized face.
"""

from __future__ import annotations

import igl
import numpy as np

from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.drawing import BLUE, GREY, camera, heat, lines, shell, sitter, wires
from benchmarks.paper_figures.rig_transfer.faces import SETS, Settings
from benchmarks.report import Row, publish
from mien.core.arrays import Floats, Ints
from mien.core.units import face_radius, human_centimetre
from mien.library.generic import generic_rig
from mien.look.camera import View
from mien.look.raster import Picture, render
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Pictures
from mien.rigging.dense import DenseFit
from mien.rigging.landmarks import paired_landmarks
from mien.rigging.transfer import Transfer

FARTHEST_MM = 20.0
"""Stick lines of this length and longer are red."""


def figures(settings: Settings) -> None:
    """Write the table and the pictures."""
    rows = [measure(name, landmarks, settings) for name in settings.faces for landmarks in SETS]
    about = "The generic face on other faces: landmarks and surface in face radii, sticking in mm on a human face"
    publish("rig_transfer_correspondence", about, rows, ["numpy", "scipy", "libigl"], settings.results)
    for name in ("actor", "cartoon", "goat"):
        if name in settings.faces:
            save_png(settings.out / f"correspondence-{name}.png", _sheet(settings, name))


def measure(name: str, landmarks: str, settings: Settings) -> Row:
    """Return one face's figures."""
    transfer = settings.transfer(name, landmarks)
    fit = transfer.fit
    size, millimetre = _sizes(fit)
    pairs = paired_landmarks(generic_rig(), transfer.rig)
    used = [i for i, (mine, _) in enumerate(pairs.names) if SETS[landmarks] is None or mine in (SETS[landmarks] or ())]
    goals = pairs.target.of(fit.target.vertices)[used]
    warped, stuck = (pairs.source.of(places)[used] for places in (fit.warped, fit.stuck))
    off = np.sqrt(_squared_distances(fit.stuck[fit.paired], fit.target.vertices, _skin(fit)))
    moved = np.linalg.norm(fit.stuck - fit.warped, axis=1)[fit.paired] / millimetre
    return {
        "face": name,
        "landmarks": len(used),
        "warp misses": float(np.linalg.norm(warped - goals, axis=1).max() / size),
        "stuck misses": float(np.linalg.norm(stuck - goals, axis=1).max() / size),
        "off the surface": float(off.max() / size),
        "stuck rms mm": float(np.sqrt((moved**2).mean())),
        "stuck max mm": float(moved.max()),
        "triangles": int(fit.source_skin[fit.source.triangles].all(axis=1).sum()),
        "folds before": fit.folds_before,
        "folds after": fit.folds_after,
        "without place": int((fit.source_skin & ~fit.paired).sum()),
        "uncovered rms mm": transfer.figures["uncovered_rms_mm"],
    }


def _sizes(fit: DenseFit) -> tuple[float, float]:
    """Return the target's radius and the length that is a millimetre there if it were human-sized."""
    landmarks = fit.warp(fit.warp.centres)
    return face_radius(landmarks), 0.1 * human_centimetre(landmarks)


def _skin(fit: DenseFit) -> Ints:
    return fit.target.triangles[fit.target_skin[fit.target.triangles].all(axis=1)]


def _squared_distances(points: Floats, vertices: Floats, triangles: Ints) -> Floats:
    return np.asarray(igl.point_mesh_squared_distance(points, vertices, triangles)[0])


def _sheet(settings: Settings, name: str) -> Picture:
    """Picture every step, one row a set of landmarks."""
    rows = []
    for landmarks in SETS:
        transfer = settings.transfer(name, landmarks)
        rows.append(Pictures(f"{transfer.figures['landmarks']}", tuple(_steps(transfer, settings.tile))))
    return sheet(rows, f"The generic face warped and stuck to the {name}, by this many landmarks")


def _steps(transfer: Transfer, tile: int) -> list[Labelled]:
    generic, fit = generic_rig(), transfer.fit
    face = transfer.rig
    radius = 0.004 * face_radius(fit.warp(fit.warp.centres))
    plain = np.broadcast_to(GREY, face.neutral.vertices.shape)
    moved = np.linalg.norm(fit.stuck - fit.warped, axis=1) / _sizes(fit)[1]
    strokes = [np.stack([fit.warped[v], fit.stuck[v]]) for v in np.flatnonzero(fit.paired & (moved > 0.05))]
    warmth = heat(1 - np.minimum(moved[fit.paired & (moved > 0.05)] / FARTHEST_MM, 1))
    stick_lines = lines(strokes, [tuple(colour) for colour in warmth], radius, on_top=True)
    skin = fit.source.triangles[fit.paired[fit.source.triangles].all(axis=1)]
    laid = wires(fit.stuck, skin, 0.6 * radius)
    return [
        Labelled(sitter(generic, size=tile).picture(), "generic"),
        Labelled(_overlay(transfer, "front", tile), "warped (blue)"),
        Labelled(_overlay(transfer, "side", tile), "from the side"),
        Labelled(sitter(face, "three-quarter", tile).picture(colours=plain, dots=[stick_lines]), "stick lines, red far"),
        Labelled(sitter(face, size=tile).picture(colours=plain, dots=[laid]), "after sticking"),
    ]


def _overlay(transfer: Transfer, view: View, tile: int) -> Picture:
    """Picture the face and, in blue, the warped generic face; what is in front shows."""
    fit = transfer.fit
    vertices = np.concatenate([fit.target.vertices, fit.warped])
    warped = fit.source.triangles[fit.source_skin[fit.source.triangles].all(axis=1)] + len(fit.target.vertices)
    rig = shell(vertices, np.concatenate([fit.target.triangles, warped]))
    colours = np.concatenate([np.broadcast_to(tint, p.shape) for tint, p in ((GREY, fit.target.vertices), (BLUE, fit.warped))])
    return render(
        rig.neutral.vertices, rig.neutral.triangles, camera(transfer.rig, view), size=(tile, tile), colours=colours
    )


if __name__ == "__main__":
    run(__doc__, figures)
