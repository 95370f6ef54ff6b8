"""What an expression does to the skin of a face unlike the rig's own: it may be strong, but nothing turns over."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import Mesh
from mien.core.arrays import Floats
from mien.geometry.templates import template_shapes
from mien.library.cast import rigged
from mien.library.generic import generic_rig
from mien.rigging.baking import LID, LIDS, baked
from mien.rigging.membrane import Membrane
from mien.rigging.transfer import Transfer
from tests.rigging.faces import exact_fit, sheet

ROUNDED = ("viseme_U", "viseme_O", "mouthPucker", "mouthFunnel")


def membrane_of(transfer: Transfer) -> Membrane:
    assert transfer.rig.anatomy is not None
    lids = [
        m.weights[: len(transfer.fit.target.vertices)] > LID for m in transfer.rig.anatomy.muscles if m.name in LIDS
    ]
    return Membrane.of(transfer.fit, np.any(lids, axis=0))


def flat() -> tuple[Membrane, Mesh]:
    line = np.linspace(-0.05, 0.05, 21)
    vertices, triangles = sheet(line, line, bulge=1e-3)
    mesh = Mesh(vertices, triangles)
    return Membrane.of(exact_fit(mesh, mesh), np.zeros(len(vertices), np.bool_)), mesh


def pushed(mesh: Mesh, far: float) -> Floats:
    """The middle of the sheet pushed sideways, over its neighbours if far enough."""
    deltas = np.zeros_like(mesh.vertices)
    deltas[np.linalg.norm(mesh.vertices[:, :2], axis=1) < 0.012, 0] = far
    return deltas


def test_skin_that_was_turned_over_lies_right_again_and_the_rest_stays() -> None:
    membrane, mesh = flat()
    deltas = pushed(mesh, 0.009)
    relaxed, before, after = membrane.relaxed(deltas)
    assert before > 0
    assert after == 0 == membrane.turned(relaxed).sum()
    far = np.linalg.norm(mesh.vertices[:, :2], axis=1) > 0.045
    assert not relaxed[far].any()
    assert relaxed[:, 0].max() > 0.4 * deltas[:, 0].max()


def test_what_turns_nothing_over_is_left_alone() -> None:
    membrane, mesh = flat()
    deltas = pushed(mesh, 0.003)
    relaxed, before, after = membrane.relaxed(deltas)
    assert before == after == 0
    assert relaxed is deltas


def test_a_whole_turn_of_the_face_turns_nothing_over() -> None:
    membrane, mesh = flat()
    assert not membrane.turned(mesh.vertices * [-1.0, 1, -1] - mesh.vertices).any()


@pytest.mark.parametrize("name", ["tortoise", "goat", "cartoon", "actor"])
def test_rounded_lips_do_not_tear(name: str) -> None:
    transfer = rigged(name)
    membrane, shapes = membrane_of(transfer), baked(transfer, generic_rig(), ROUNDED)[0]
    own = len(transfer.fit.target.vertices)
    for deltas in shapes.deltas:
        assert membrane.turned(deltas[:own]).sum() <= 1


def test_lips_closed_over_an_open_jaw_do_not_tear_where_the_jaw_alone_was_relaxed() -> None:
    transfer = rigged("cartoon")
    membrane, own = membrane_of(transfer), len(transfer.fit.target.vertices)
    shapes, notes = baked(transfer, generic_rig(), ("mouthClose", "jawOpen"))
    assert [note.where for note in notes if note.code == "skin-relaxed"] == ["jawOpen"]
    assert not membrane.turned(shapes.deltas.sum(axis=0)[:own]).any()
    raw = template_shapes(transfer.rig, shapes.names).deltas
    assert shapes.deltas.sum(axis=0) == pytest.approx(raw.sum(axis=0), abs=1e-9)


def test_what_is_meant_on_top_of_a_template_that_is_not_asked_for_stays_as_it_is() -> None:
    transfer = rigged("cartoon")
    alone = baked(transfer, generic_rig(), ("mouthClose",))[0].deltas
    assert alone == pytest.approx(template_shapes(transfer.rig, ("mouthClose",)).deltas, abs=1e-9)
