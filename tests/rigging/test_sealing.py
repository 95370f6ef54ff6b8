"""An eye that is shut shows nothing of its ball."""

from __future__ import annotations

import numpy as np
import pytest

from mien.library.generic import generic_rig
from mien.library.heads import cartoon_head
from mien.rigging.baking import SHUT, baked
from mien.rigging.sealing import ON_BALL, Eye, sealed
from mien.rigging.transfer import Transfer, transfer_rig


@pytest.fixture(scope="module")
def on_cartoon() -> Transfer:
    return transfer_rig(generic_rig(), cartoon_head())


def eye_of(transfer: Transfer, lid: str) -> Eye:
    rig, fit = transfer.rig, transfer.fit
    assert rig.anatomy is not None
    muscle = next(one for one in rig.anatomy.muscles if one.name == lid)
    own = np.pad(fit.target_skin, (0, len(rig.neutral.vertices) - len(fit.target_skin)))[rig.neutral.triangles]
    triangles = rig.neutral.triangles
    return Eye.under(muscle, rig.neutral.vertices, triangles[own.all(axis=1)], triangles[~own.any(axis=1)])


def test_a_blink_shuts_both_eyes_to_their_corners(on_cartoon: Transfer) -> None:
    rest = on_cartoon.rig.neutral.vertices
    shapes, notes = baked(on_cartoon, generic_rig(), ("blink_closed", "blink_half"))
    for upper, _ in SHUT:
        eye = eye_of(on_cartoon, upper)
        assert eye.widest(rest) > 0.01
        assert eye.widest(rest + shapes.deltas[1]) > 0.005
        assert eye.widest(rest + shapes.deltas[0]) < 3e-4
    assert {note.where for note in notes if note.code == "lids-sealed"} == {"blink_closed"}


def test_what_is_far_open_or_shut_is_left_alone(on_cartoon: Transfer) -> None:
    eye = eye_of(on_cartoon, SHUT[0][0])
    rest = on_cartoon.rig.neutral.vertices
    shut = rest + baked(on_cartoon, generic_rig(), ("blink_closed",))[0].deltas[0]
    again, before, after = sealed(shut, eye, on_cartoon.fit)
    assert before == after
    assert np.abs(again - shut).max() < 1e-3


def test_an_eyeball_is_seen_at_its_own_distance(on_cartoon: Transfer) -> None:
    eye = eye_of(on_cartoon, SHUT[0][0])
    seen = eye.look(on_cartoon.rig.neutral.vertices, eye.ball, ON_BALL[1] * eye.radius)
    middle = seen.distance[100:141, 100:141]
    corners = np.linalg.norm(on_cartoon.rig.neutral.vertices[eye.ball] - eye.centre, axis=2)
    assert middle.max() <= corners.max()
    assert middle.min() > 0.8 * eye.radius
