"""Figures 5, 7, 8, 9 and 12: the generic rig's expressions on other faces, by few and by all landmarks.

    python -m benchmarks.paper_figures.rig_transfer.expressions

Nothing is tuned for a face: each plays the generic rig's own templates.  The close-ups are those
of figure 12.  The table says by how much the surface moves and what a
blink leaves open at the lids' landmarks, in millimetres on a human-sized face.
"""

from __future__ import annotations

import numpy as np

from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.drawing import camera, sitter
from benchmarks.paper_figures.rig_transfer.faces import (
    EYE_CORNERS,
    MOUTH_CORNERS,
    SETS,
    Settings,
    acting,
    generic_acting,
)
from benchmarks.report import Row, publish
from mien.core import Rig
from mien.core.units import human_centimetre
from mien.geometry.surface import unit
from mien.io.documents import join
from mien.library.generic import generic_rig
from mien.look.raster import Picture
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Pictures
from mien.vocabularies.anthropometry import same_landmarks

TEMPLATES = ("joy", "surprise", "anger", "sadness", "disgust", "blink_closed", "viseme_aa", "viseme_U")
FEW = ("joy", "surprise", "anger", "blink_closed", "viseme_aa")
"""Shown where there is a row for each set of landmarks."""
LIDS = tuple(
    f"palpebrale_{edge}_{third}_{side}"
    for side in ("left", "right")
    for third in ("medial", "lateral")
    for edge in ("superius", "inferius")
)
"""Landmarks of the lids' edges, each upper one before the lower it meets."""


def expressions(settings: Settings) -> None:
    """Write the sheets and the table."""
    own = generic_acting(TEMPLATES)
    rows = [_row("generic", own, own, settings.tile)]
    for name in settings.faces:
        rows.append(_row(name, settings.bare(name), acting(settings.transfer(name), TEMPLATES), settings.tile))
    save_png(settings.out / "expressions.png", sheet(rows, "The generic rig's templates, by all landmarks"))
    for name in settings.faces:
        save_png(settings.out / f"expressions-{_slug(name)}.png", _by_landmarks(settings, name))
    save_png(settings.out / "close-up.png", _close_ups(settings))
    table = [figures_of("generic", "", generic_rig(), own)]
    table += [
        figures_of(name, landmarks, settings.bare(name), acting(settings.transfer(name, landmarks), TEMPLATES))
        for name in settings.faces
        for landmarks in SETS
    ]
    about = "Templates on other faces: largest movement, lids left open by blink_closed, mm on a human-sized face"
    publish("rig_transfer_expressions", about, table, ["numpy", "scipy", "libigl"], settings.results)


def figures_of(title: str, landmarks: str, face: Rig, rig: Rig) -> Row:
    """Return by how much each template moves a face, and what a blink leaves open; `face` has all landmarks."""
    places = np.concatenate([point.of(face.neutral.vertices) for point in face.landmarks.values()])
    millimetre = 0.1 * human_centimetre(places)
    farthest = np.linalg.norm(rig.blendshapes.deltas, axis=2).max(axis=1) / millimetre
    blink = rig.pose(np.eye(len(TEMPLATES))[TEMPLATES.index("blink_closed")])
    names = dict(same_landmarks(LIDS, face.landmarks))
    upper, lower = (join([face.landmarks[names[name]] for name in LIDS[half::2]]) for half in (0, 1))
    apart = upper.of(rig.neutral.vertices) - lower.of(rig.neutral.vertices)
    left_open = ((upper.of(blink) - lower.of(blink)) * unit(apart)).sum(axis=1) / millimetre
    return {
        "face": title,
        "landmarks": landmarks,
        **dict(zip(TEMPLATES, farthest.tolist(), strict=True)),
        "lids at rest": float(np.linalg.norm(apart, axis=1).mean() / millimetre),
        "lids left open": float(np.maximum(left_open, 0).mean()),
        "worst": float(np.maximum(left_open, 0).max()),
    }


def _row(title: str, framed: Rig, rig: Rig, tile: int, names: tuple[str, ...] = TEMPLATES) -> Pictures:
    """Picture a face at rest and in some of its shapes, framed by the landmarks of another rig of it."""
    seen = sitter(rig, size=tile, at=camera(framed))
    cells = [Labelled(seen.picture(), "at rest")]
    for name in names:
        weights = np.zeros(len(rig.blendshapes))
        weights[rig.blendshapes.index(name)] = 1.0
        cells.append(Labelled(seen.picture(weights), name.replace("_", " ")))
    return Pictures(title, tuple(cells))


def _by_landmarks(settings: Settings, name: str) -> Picture:
    rows = []
    for landmarks in SETS:
        transfer = settings.transfer(name, landmarks)
        title = f"{transfer.figures['landmarks']} landmarks"
        rows.append(_row(title, settings.bare(name), acting(transfer, FEW), settings.tile, FEW))
    return sheet(rows, f"The {name}, by few and by all landmarks")


def _close_ups(settings: Settings) -> Picture:
    """Picture one expression as a whole, its mouth and its eyes, on the generic rig and on the cartoon."""
    rows = []
    for title, rig in (
        ("generic", generic_acting(("joy",))),
        ("cartoon", acting(settings.transfer("cartoon"), ("joy",))),
    ):
        names = dict(same_landmarks(generic_rig().landmarks, rig.landmarks))
        cells = [Labelled(sitter(rig, size=2 * settings.tile).picture(np.ones(1)), "joy")]
        for label, corners in (("mouth", MOUTH_CORNERS), ("eyes", EYE_CORNERS)):
            close = camera(rig, names=[names[corner] for corner in corners], around=1.5)
            cells.append(Labelled(sitter(rig, size=2 * settings.tile, at=close).picture(np.ones(1)), label))
        rows.append(Pictures(title, tuple(cells)))
    return sheet(rows, "One expression, and closer")


def _slug(name: str) -> str:
    return name.lower().replace(" ", "-")


if __name__ == "__main__":
    run(__doc__, expressions)
