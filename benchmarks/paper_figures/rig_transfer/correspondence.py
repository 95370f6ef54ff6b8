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
from benchmarks.paper_figures.rig_transfer.drawing import BLUE, GREY, camera, heat, lines, sitter, wires
from benchmarks.paper_figures.rig_transfer.faces import SETS, Settings, with_landmarks
from benchmarks.report import Row, publish
from mien.core import Rig
from mien.core.arrays import Floats, Ints
from mien.core.units import face_radius, human_centimetre
from mien.geometry.surface import vertex_normals
from mien.library.generic import generic_rig
from mien.look.camera import View
from mien.look.raster import Picture, render
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Pictures
from mien.rigging.dense import DenseFit
from mien.rigging.landmarks import paired_landmarks

SHORTEST_MM, FARTHEST_MM = 0.05, 20.0
"""Stick lines shorter than the first are not drawn; those longer than the second are red."""


def correspondence(settings: Settings) -> None:
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
    pairs = paired_landmarks(generic_rig(), with_landmarks(settings.bare(name), SETS[landmarks]))
    goals = pairs.target.of(fit.target.vertices)
    warped, stuck = pairs.source.of(fit.warped), pairs.source.of(fit.stuck)
    off = np.sqrt(_squared_distances(fit.stuck[fit.paired], fit.target.vertices, _skin(fit)))
    moved = np.linalg.norm(fit.stuck - fit.warped, axis=1)[fit.paired] / millimetre
    return {
        "face": name,
        "landmarks": len(goals),
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
        steps = _steps(transfer.fit, settings.bare(name), settings.tile)
        rows.append(Pictures(f"{transfer.figures['landmarks']}", tuple(steps)))
    return sheet(rows, f"The generic face warped and stuck to the {name}, by this many landmarks")


def _steps(fit: DenseFit, face: Rig, tile: int) -> list[Labelled]:
    radius = 0.004 * _sizes(fit)[0]
    plain = np.broadcast_to(GREY, face.neutral.vertices.shape)
    moved = np.linalg.norm(fit.stuck - fit.warped, axis=1) / _sizes(fit)[1]
    far = np.flatnonzero(fit.paired & (moved > SHORTEST_MM))
    warmth = heat(1 - np.minimum(moved[far] / FARTHEST_MM, 1))
    sticks = lines([np.stack([fit.warped[v], fit.stuck[v]]) for v in far], warmth, radius, on_top=True)
    skin = fit.source.triangles[fit.paired[fit.source.triangles].all(axis=1)]
    lifted = fit.stuck + radius * fit.points.of(vertex_normals(fit.target.vertices, fit.target.triangles))
    return [
        Labelled(sitter(generic_rig(), size=tile).picture(), "generic"),
        Labelled(_overlay(fit, face, "front", tile), "warped (blue)"),
        Labelled(_overlay(fit, face, "side", tile), "from the side"),
        Labelled(sitter(face, "three-quarter", tile).picture(colours=plain, dots=[sticks]), "stick lines, red far"),
        Labelled(sitter(face, size=tile).picture(colours=plain, dots=[wires(lifted, skin, radius)]), "after sticking"),
    ]


def _overlay(fit: DenseFit, face: Rig, view: View, tile: int) -> Picture:
    """Picture the face and, in blue, the warped generic face; what is in front shows."""
    own, warped = fit.target.vertices, fit.warped
    skin = fit.source.triangles[fit.source_skin[fit.source.triangles].all(axis=1)]
    return render(
        np.concatenate([own, warped]),
        np.concatenate([fit.target.triangles, len(own) + skin]),
        camera(face, view),
        size=(tile, tile),
        colours=np.concatenate([np.broadcast_to(GREY, own.shape), np.broadcast_to(BLUE, warped.shape)]),
    )


if __name__ == "__main__":
    run(__doc__, correspondence)
