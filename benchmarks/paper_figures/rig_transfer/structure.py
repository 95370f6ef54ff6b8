"""Figures 4 and 10: muscles carried by the landmarks alone and by the whole skin, and how deep they lie after.

    python -m benchmarks.paper_figures.rig_transfer.structure

For every point of every fibre, its distance from the skin.  What that should be on the target is
the generic distance times the growth of the skin around the point: the difference, as a share of the
root mean square distance, is the `relative RMS`.  `as is` compares without the growth, as the paper's
figure 10 does.  `on the other side` counts points that were clearly under the skin and are clearly
above it, or the reverse; a face whose skin lines its eye sockets has the muscle of the lid outside it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.drawing import BLUE, GREY, ORANGE, line, sitter
from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import Row, publish
from mien.core import Mesh, Muscle, Rig
from mien.core.arrays import Flags, Floats
from mien.core.units import face_radius, human_centimetre
from mien.geometry.surface import closest_points, vertex_normals
from mien.library.generic import generic_rig
from mien.look.camera import View
from mien.look.plots import as_png
from mien.look.raster import Dots, Picture
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Pictures
from mien.rigging.structure import Structure
from mien.rigging.transfer import Transfer

SHOWN = ("actor", "cartoon", "goat")
CLEAR_MM = 1.0
"""A point is clearly on one side of the skin if it is this far from it, on a human-sized face."""


@dataclass(frozen=True, eq=False)
class Depths:
    """How deep the fibres lie, point by point, in millimetres of a human-sized face.

    Attributes:
        generic: `(P,)` on the generic rig.
        expected: `(P,)` the same, grown as the skin around each point is.
        sparse: `(P,)` on the face, carried by the landmarks.
        dense: `(P,)` on the face, carried by the whole skin.
    """

    generic: Floats
    expected: Floats
    sparse: Floats
    dense: Floats

    @classmethod
    def of(cls, transfer: Transfer) -> Depths:
        """Measure a transferred rig."""
        fit, structure = transfer.fit, Structure.of(transfer.fit)
        fibres = np.concatenate([muscle.fibre for muscle in _muscles(generic_rig())])
        carried = np.concatenate([muscle.fibre for muscle in _muscles(transfer.rig)])
        growth = np.array([structure.around(point)[1] for point in fibres])
        here, there = 0.1 * human_centimetre(fit.warp.centres), 0.1 * human_centimetre(fit.warp(fit.warp.centres))
        generic = depth(fit.source, fit.source_skin, fibres)
        return cls(
            generic / here,
            generic * growth / there,
            depth(fit.target, fit.target_skin, fit.warp(fibres)) / there,
            depth(fit.target, fit.target_skin, carried) / there,
        )


def depth(mesh: Mesh, skin: Flags, points: Floats) -> Floats:
    """Return how far points `(P, 3)` lie under the skin; negative above it."""
    triangles = mesh.triangles[skin[mesh.triangles].all(axis=1)]
    nearest, distance, _ = closest_points(mesh.vertices, triangles, points)
    outward = nearest.of(vertex_normals(mesh.vertices, triangles))
    above = ((points - nearest.of(mesh.vertices)) * outward).sum(axis=1) > 0
    return np.where(above, -distance, distance)


def structure(settings: Settings) -> None:
    """Write the table, the diagram and the pictures."""
    found = {name: Depths.of(settings.transfer(name)) for name in settings.faces}
    rows = [row for name, depths in found.items() for row in _rows(name, depths)]
    points = len(next(iter(found.values())).generic)
    about = f"Distances of {points} muscle points from the skin, on the face and as they should be, mm on a human face"
    publish("rig_transfer_muscles", about, rows, ["numpy", "scipy", "libigl"], settings.results)
    (settings.out / "muscle-distances.png").write_bytes(_diagram({name: found[name] for name in SHOWN}))
    save_png(settings.out / "muscles.png", _pictures(settings))


def _rows(name: str, depths: Depths) -> list[Row]:
    """Return the agreement of the distances on one face, by either warp."""
    rows = []
    wanted = np.abs(depths.expected)
    for warp, result in (("landmarks", depths.sparse), ("whole skin", depths.dense)):
        off = np.abs(result) - wanted
        as_is = np.abs(result) - np.abs(depths.generic)
        through = (result * depths.generic < 0) & (np.minimum(np.abs(result), np.abs(depths.generic)) > CLEAR_MM)
        rows.append(
            {
                "face": name,
                "carried by": warp,
                "correlation": float(np.corrcoef(np.abs(result), wanted)[0, 1]),
                "relative RMS": float(np.sqrt((off**2).mean() / (wanted**2).mean())),
                "as is": float(np.sqrt((as_is**2).mean() / (depths.generic**2).mean())),
                "mean error mm": float(np.abs(off).mean()),
                "95 % mm": float(np.percentile(np.abs(off), 95)),
                "on the other side": int(through.sum()),
            }
        )
    return rows


def _diagram(found: dict[str, Depths]) -> bytes:
    """Draw the depths as the paper's figure 10 does: the generic rig a line, the face dots."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 2.4 * len(found)), layout="constrained")
    panels = figure.subplots(len(found), 1, squeeze=False)[:, 0]
    for axes, (name, depths) in zip(panels, found.items(), strict=True):
        order = np.arange(len(depths.generic))
        axes.plot(order, depths.expected, color="0.25", linewidth=0.8, label="generic rig, to scale")
        axes.plot(order, depths.sparse, "x", color=ORANGE, markersize=3, alpha=0.5, label="by the landmarks")
        axes.plot(order, depths.dense, ".", color=BLUE, markersize=4, label="by the whole skin")
        axes.set_title(name, loc="left", fontsize=10)
        axes.set_ylabel("under the skin [mm]", fontsize=8)
        axes.tick_params(labelsize=7)
        axes.margins(x=0.01)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].legend(fontsize=8, frameon=False, ncols=3, loc="upper right")
    panels[-1].set_xlabel("points of the muscles' fibres, muscle after muscle", fontsize=8)
    return as_png(figure)


def _pictures(settings: Settings) -> Picture:
    """Picture the muscles through the skin: the generic rig's, and each face's by either warp."""
    generic = generic_rig()
    own = [muscle.fibre for muscle in _muscles(generic)]
    skin = settings.transfer(SHOWN[0]).fit.source_skin
    rows = [Pictures("generic", _views(generic, skin, own, "", settings.tile))]
    for name in SHOWN:
        transfer, face = settings.transfer(name), settings.bare(name)
        fit = transfer.fit
        sparse = [fit.warp(fibre) for fibre in own]
        dense = [muscle.fibre for muscle in _muscles(transfer.rig)]
        cells = (
            *_views(face, fit.target_skin, sparse, "by the landmarks", settings.tile),
            *_views(face, fit.target_skin, dense, "by the whole skin", settings.tile),
        )
        rows.append(Pictures(name, cells))
    return sheet(rows, "Muscles under the skin (blue) and where they come through it (orange)")


def _views(face: Rig, skin: Flags, fibres: list[Floats], label: str, tile: int) -> tuple[Labelled, ...]:
    """Picture muscles through the skin, from the front and the side."""
    places = np.concatenate([point.of(face.neutral.vertices) for point in face.landmarks.values()])
    radius = 0.016 * face_radius(places)
    strings = np.concatenate([line(fibre, radius) for fibre in fibres])
    above = depth(face.neutral, skin, strings) < -0.1 * CLEAR_MM * human_centimetre(places)
    dots = Dots(strings, np.where(above[:, None], ORANGE, BLUE), radius, on_top=True)
    plain = np.broadcast_to(GREY, face.neutral.vertices.shape)
    views: tuple[View, ...] = ("front", "side")
    return tuple(Labelled(sitter(face, view, tile).picture(colours=plain, dots=[dots]), label) for view in views)


def _muscles(rig: Rig) -> tuple[Muscle, ...]:
    assert rig.anatomy is not None
    return rig.anatomy.muscles


if __name__ == "__main__":
    run(__doc__, structure)
