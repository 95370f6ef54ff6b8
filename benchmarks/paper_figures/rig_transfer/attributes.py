"""Figure 11: the weight of the jaw and the labels of the regions, on the generic rig and on other faces.

    python -m benchmarks.paper_figures.rig_transfer.attributes

Red is weight 0 and blue 1, as in the paper.  The table checks what must hold: skin weights sum to 1,
every label is one of the generic rig's and that of its nearest vertex there, and the mean weight over
the skin near the face is that of the generic rig.
"""

from __future__ import annotations

import numpy as np

from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.drawing import camera, distinct, heat, sitter
from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import Row, publish
from mien.core import Rig
from mien.core.arrays import Floats
from mien.library.generic import generic_rig
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Pictures
from mien.rigging.dense import DenseFit

SHOWN = ("actor", "cartoon", "goat", "ICT", "MakeHuman adult")


def attributes(settings: Settings) -> None:
    """Write the sheet and the table."""
    generic = generic_rig()
    faces = {name: settings.transfer(name) for name in SHOWN if name in settings.faces}
    rigs = {"generic": (generic, generic)} | {name: (t.rig, settings.bare(name)) for name, t in faces.items()}
    names = _labels(generic)[0]
    hues = distinct(len(names))
    jaw, regions = [], []
    for name, (rig, framed) in rigs.items():
        seen = sitter(rig, "three-quarter", settings.tile, camera(framed, "three-quarter"))
        jaw.append(Labelled(seen.picture(colours=heat(jaw_weight(rig))), name))
        regions.append(Labelled(seen.picture(colours=hues[_labels(rig)[1]]), name))
    rows = [Pictures("weight of the jaw", tuple(jaw)), Pictures("regions", tuple(regions))]
    save_png(settings.out / "attributes.png", sheet(rows, "Attributes carried by the correspondence"))
    table = [_row(name, t.rig, t.fit) for name, t in faces.items()]
    about = "Attributes: sums of weights, labels, and how the carried weight of the jaw differs where it came from"
    publish("rig_transfer_attributes", about, table, ["numpy"], settings.results)


def jaw_weight(rig: Rig) -> Floats:
    """Return the weight of the jaw per vertex `(N,)`."""
    assert rig.skin is not None
    assert rig.skeleton is not None
    return np.asarray((rig.skin.weights * (rig.skin.joints == rig.skeleton.names.index("jaw"))).sum(axis=1))


def _labels(rig: Rig) -> tuple[tuple[str, ...], np.ndarray]:
    assert rig.anatomy is not None
    regions = rig.anatomy.labels["region"]
    return regions.names, regions.of


def _row(name: str, rig: Rig, fit: DenseFit) -> Row:
    """Check one face's attributes: carried there, and back to the generic vertices stuck to it."""
    assert rig.skin is not None
    skin = np.flatnonzero(fit.paired)
    there, here = jaw_weight(rig), jaw_weight(generic_rig())
    back = fit.points.take(skin).of(there[:, None])[:, 0]
    nearest = fit.points.corners[skin, fit.points.weights[skin].argmax(axis=1)]
    same = _labels(rig)[1][nearest] == _labels(generic_rig())[1][skin]
    return {
        "face": name,
        "sums off by": float(np.abs(rig.skin.weights.sum(axis=1) - 1).max()),
        "lowest weight": float(rig.skin.weights.min()),
        "influences": rig.skin.weights.shape[1],
        "labels": len(np.unique(_labels(rig)[1])),
        "of": len(_labels(generic_rig())[0]),
        "jaw there and back": float(np.abs(back - here[skin]).mean()),
        "95 %": float(np.percentile(np.abs(back - here[skin]), 95)),
        "labels there and back": float(same.mean()),
    }


if __name__ == "__main__":
    run(__doc__, attributes)
