"""Lids on another face meet over its eyeball, and all of them follows."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import Muscle, Rig
from mien.core.arrays import Floats
from mien.library.generic import generic_rig
from mien.library.heads import goat_head
from mien.rigging.transfer import Transfer, transfer_rig
from tests.rigging.moved import bare

LID = "orbicularis_oculi_upper_left"


@pytest.fixture(scope="module")
def on_goat() -> Transfer:
    return transfer_rig(generic_rig(), goat_head())


def muscle(rig: Rig, name: str = LID) -> Muscle:
    assert rig.anatomy is not None
    return next(one for one in rig.anatomy.muscles if one.name == name)


def height(points: Floats, pivot: Floats | None) -> Floats:
    assert pivot is not None
    return np.asarray(np.linalg.norm(points - pivot, axis=1))


def test_on_its_own_face_a_seam_stays() -> None:
    generic = generic_rig()
    own, moved = muscle(generic), muscle(transfer_rig(generic, bare(generic)).rig)
    assert own.seam is not None
    assert moved.seam is not None
    assert np.abs(moved.seam - own.seam).max() < 1e-9
    assert np.abs(moved.weights - own.weights).max() < 1e-9


def test_both_lids_close_on_one_seam_outside_of_the_eyeball(on_goat: Transfer) -> None:
    upper, lower = muscle(on_goat.rig), muscle(on_goat.rig, LID.replace("upper", "lower"))
    assert upper.seam is not None
    assert lower.seam is not None
    assert np.abs(upper.seam - lower.seam).max() < 1e-9
    eye = on_goat.rig.neutral.vertices[on_goat.rig.neutral.groups["eye_left"]]
    top = height(eye, upper.pivot).max()
    assert height(upper.seam, upper.pivot)[4:-4].min() > top
    assert height(upper.seam, upper.pivot).max() < 1.1 * top


def test_the_pivot_is_the_middle_of_the_face_s_own_eye(on_goat: Transfer) -> None:
    eye = on_goat.rig.neutral.vertices[on_goat.rig.neutral.groups["sclera_left"]]
    apart = height(eye, muscle(on_goat.rig).pivot)
    assert np.ptp(apart) < 0.06 * apart.mean()


def test_the_edges_of_the_face_s_own_lids_follow(on_goat: Transfer) -> None:
    for lid in ("upper", "lower"):
        edge = on_goat.rig.neutral.groups[f"{lid}_lid_left"]
        weights = muscle(on_goat.rig, LID.replace("upper", lid)).weights[edge]
        assert np.median(weights) > 0.95
