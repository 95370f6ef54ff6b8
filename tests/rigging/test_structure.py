"""What lies under the skin goes with it: by a smooth warp, with frames that stay frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from mien.core import Rig
from mien.core.arrays import Floats
from mien.core.units import human_centimetre
from mien.library.generic import generic_rig
from mien.library.heads import cartoon_head, goat_head
from mien.rigging.dense import DenseFit, lay
from mien.rigging.landmarks import paired_landmarks
from mien.rigging.structure import STEEPEST, STIFF_CM, Structure
from tests.rigging.moved import SCALE, TURN, similar, similar_face


def laid(face: Rig) -> DenseFit:
    generic = generic_rig()
    pairs = paired_landmarks(generic, face)
    return lay(generic.neutral, pairs.source, face.neutral, pairs.target)


@pytest.fixture(scope="module")
def cartoon() -> DenseFit:
    return laid(cartoon_head())


@pytest.fixture(scope="module")
def goat() -> DenseFit:
    return laid(goat_head())


def fibres() -> dict[str, Floats]:
    anatomy = generic_rig().anatomy
    assert anatomy is not None
    return {muscle.name: muscle.fibre for muscle in anatomy.muscles}


def sharpest(line: Floats) -> float:
    """The sharpest bend of a line [degrees]."""
    steps = np.diff(line, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    return float(np.degrees(np.arccos(np.clip((steps[1:] * steps[:-1]).sum(axis=1), -1, 1))).max())


def test_the_warp_is_scipy_s_with_the_same_smoothing(cartoon: DenseFit, rng: np.random.Generator) -> None:
    structure = Structure.of(cartoon, most=300)
    chosen = [int(np.flatnonzero((structure.sources == c).all(axis=1))[0]) for c in structure.warp.centres]
    smoothing = STIFF_CM * human_centimetre(cartoon.warp.centres) * len(chosen) / len(structure.sources)
    reference = RBFInterpolator(
        structure.warp.centres, structure.targets[chosen], kernel="linear", degree=1, smoothing=smoothing
    )
    inside = 0.9 * structure.sources[rng.integers(0, len(structure.sources), 200)]
    assert len(chosen) <= 300
    assert np.abs(structure.warp(inside) - reference(inside)).max() < 1e-9


def test_fewer_centres_change_little(cartoon: DenseFit) -> None:
    whole, part = Structure.of(cartoon, most=10_000), Structure.of(cartoon, most=1000)
    centimetre = human_centimetre(cartoon.warp(cartoon.warp.centres))
    assert len(part.warp.centres) <= 1000 < len(whole.warp.centres)
    for fibre in fibres().values():
        assert np.abs(whole.lines([fibre])[0] - part.lines([fibre])[0]).max() < 0.25 * centimetre


def test_skin_that_nobody_sees_has_no_say(cartoon: DenseFit) -> None:
    groups = generic_rig().neutral.groups
    seen = Structure.of(cartoon).vertices
    assert not np.isin(seen, groups["pocket"]).any()
    assert np.isin(groups["brow_left"], seen).sum() == 0
    assert np.isin(groups["lips"], seen).mean() > 0.8


def test_a_similarity_is_carried_exactly() -> None:
    structure = Structure.of(laid(similar_face()))
    frame = np.eye(4)
    frame[:3, 3] = [0.01, -0.05, 0.04]
    carried = structure.frame(frame)
    assert np.allclose(carried[:3, :3], TURN)
    assert np.allclose(carried[:3, 3], similar(frame[:3, 3]))
    for line in fibres().values():
        assert np.allclose(structure.lines([line])[0], similar(line))
    assert structure.growth(np.ones(len(structure.vertices) * 3)) == pytest.approx(SCALE)


def test_frames_stay_orthonormal(cartoon: DenseFit, goat: DenseFit) -> None:
    anatomy = generic_rig().anatomy
    assert anatomy is not None
    for fit in (cartoon, goat):
        structure = Structure.of(fit)
        for part in (*anatomy.muscles, *anatomy.clusters):
            turn = structure.frame(part.frame)[:3, :3]
            assert np.abs(turn.T @ turn - np.eye(3)).max() < 1e-12
            assert np.linalg.det(turn) == pytest.approx(1)


def test_fibres_do_not_kink(cartoon: DenseFit, goat: DenseFit) -> None:
    """An interpolating warp bends them by up to 178 degrees on the goat."""
    for fit in (cartoon, goat):
        structure = Structure.of(fit)
        for name, fibre in fibres().items():
            assert sharpest(structure.lines([fibre])[0]) < sharpest(fibre) + 60, name


def test_the_growth_of_a_region_is_its_own() -> None:
    """Twice as wide a lower half: what follows there has grown, what follows above has not."""
    generic = generic_rig()
    fit = laid(generic)
    below = generic.neutral.vertices[:, 1] < -0.05
    wider = replace(fit, stuck=np.where(below[:, None], fit.stuck * 2, fit.stuck))
    structure = Structure.of(wider)
    assert structure.growth(below.astype(np.float64)) == pytest.approx(2)
    assert structure.growth((~below).astype(np.float64)) == pytest.approx(1)


def test_a_movement_may_grow_as_the_way_over_which_it_falls_off() -> None:
    """Lips three times as wide, and as high as they were, bear hardly more than they did."""
    generic = generic_rig()
    assert generic.anatomy is not None
    lip = next(part.weights for part in generic.anatomy.clusters if part.name == "lip_lower_left")
    fit = laid(generic)
    assert Structure.of(replace(fit, stuck=3 * fit.stuck)).bearable(lip) == pytest.approx(3 * STEEPEST)
    wide = Structure.of(replace(fit, stuck=fit.stuck * [3.0, 1, 1]))
    assert STEEPEST < wide.bearable(lip) < 2 * STEEPEST < STEEPEST * wide.growth(lip)
    assert wide.bearable(np.ones(len(lip))) == np.inf
