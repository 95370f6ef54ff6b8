"""Every prior is what it says, and the same exact solve serves all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

from mien.core import Blendshapes, InputError, Rig
from mien.retargeting.energy import frame_solver
from mien.retargeting.prior import PRIORS, bending
from mien.retargeting.settings import SolveSettings
from tests.retargeting.actors import face

CENTIMETRE = 0.01
MU = 0.2


def problem(kind: str, rng: np.random.Generator, **changes: object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A frame of the small face, its matrix, and the weights found with a prior."""
    rig = face()
    shapes = rig.blendshapes.deltas[:, ::7] / CENTIMETRE
    settings = SolveSettings(prior=MU, prior_kind=kind, sparsity=0.0, damping=0.0, smooth=0.0, **changes)
    unlikely = PRIORS[kind].quadratic(rig, CENTIMETRE)
    names = rig.blendshapes.names
    frame = np.tensordot([0.9, -0.3, 0.5, 0.7, 0.0, 0.2], shapes, 1) + 0.05 * rng.normal(size=shapes[0].shape)
    solver = frame_solver(shapes, names, unlikely, np.ones(shapes.shape[1]), settings)
    return shapes.reshape(len(names), -1), frame.ravel(), solver.step(frame, None)


@pytest.mark.parametrize("kind", ["geometric", "l2", "pca", "none"])
@pytest.mark.parametrize("bounds", [(0.0, 1.0), (-np.inf, np.inf)])
def test_a_quadratic_prior_is_a_bounded_least_squares(
    kind: str, bounds: tuple[float, float], rng: np.random.Generator
) -> None:
    shapes, frame, found = problem(kind, rng, bounds=None if np.isinf(bounds[1]) else bounds)
    values, vectors = np.linalg.eigh(PRIORS[kind].quadratic(face(), CENTIMETRE))
    root = np.sqrt(MU * np.maximum(values, 0))[:, None] * vectors.T
    points = shapes.shape[1] / 3
    rows = np.concatenate([shapes.T / np.sqrt(points), root])
    known = lsq_linear(rows, np.concatenate([frame / np.sqrt(points), np.zeros(len(root))]), bounds, tol=1e-13)
    np.testing.assert_allclose(found, known.x, atol=2e-6)


def test_the_elastic_net_is_what_a_general_minimiser_finds(rng: np.random.Generator) -> None:
    shapes, frame, found = problem("elastic-net", rng, bounds=None)

    def energy(split: np.ndarray) -> float:
        w = split[: len(shapes)] - split[len(shapes) :]
        fit = ((frame - w @ shapes) ** 2).sum() / (shapes.shape[1] / 3)
        return float(fit + MU * ((w**2).sum() + split.sum()))

    start = np.zeros(2 * len(shapes))
    known = minimize(energy, start, bounds=[(0, None)] * len(start), options={"ftol": 1e-15, "gtol": 1e-10}).x
    np.testing.assert_allclose(found, known[: len(shapes)] - known[len(shapes) :], atol=1e-4)
    assert (found == 0).any()


def test_the_default_is_the_geometric_prior_switched_off() -> None:
    assert (SolveSettings().prior, SolveSettings().prior_kind) == (0.0, "geometric")
    np.testing.assert_array_equal(PRIORS["geometric"].quadratic(face(), 0.01), bending(face(), 0.01))


@pytest.mark.parametrize("kind", PRIORS)
def test_a_prior_is_a_semidefinite_form_that_does_not_depend_on_the_unit(kind: str) -> None:
    rig = face()
    form = PRIORS[kind].quadratic(rig, 0.01)
    assert np.linalg.eigvalsh(form).min() >= -1e-12
    larger = Rig(
        replace(rig.neutral, vertices=100 * rig.neutral.vertices),
        Blendshapes(rig.blendshapes.names, 100 * rig.blendshapes.deltas),
    )
    np.testing.assert_allclose(PRIORS[kind].quadratic(larger, 1.0), form, rtol=1e-9, atol=1e-12)


def test_the_distance_of_components_that_are_all_kept_is_that_of_the_weights() -> None:
    rig = face()
    apart = np.zeros((3, len(rig.neutral.vertices), 3))
    for k in range(3):
        apart[k, 20 * k : 20 * k + 20, k] = 1.0
    equal = replace(rig, blendshapes=Blendshapes(("a", "b", "c"), apart))
    np.testing.assert_allclose(PRIORS["pca"].quadratic(equal, 0.01), np.eye(3), atol=1e-9)


def test_what_the_principal_components_do_not_show_is_less_likely_than_they_are() -> None:
    rig = face()
    big, rest = rig.blendshapes.deltas[0], 1e-3 * rig.blendshapes.deltas[1:4] * np.array([1.0, 0.1, 3.0])[:, None, None]
    shapes = Blendshapes(("big", "a", "b", "c"), np.stack([big, *rest]))
    form = PRIORS["pca"].quadratic(replace(rig, blendshapes=shapes), 0.01)
    np.testing.assert_allclose(form[0, 0], 1.0, rtol=1e-3)
    assert form.diagonal()[3] > form.diagonal()[2]


def test_an_empty_shape_breaks_no_prior() -> None:
    rig = face()
    deltas = rig.blendshapes.deltas.copy()
    deltas[2] = 0
    for prior in PRIORS.values():
        form = prior.quadratic(replace(rig, blendshapes=Blendshapes(rig.blendshapes.names, deltas)), 0.01)
        assert np.isfinite(form).all()


def test_an_unknown_prior_is_refused_with_the_known_ones() -> None:
    with pytest.raises(InputError, match="elastic-net"):
        SolveSettings(prior_kind="bayes")
