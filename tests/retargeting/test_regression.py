"""The comparators against independent references, and what they share."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.linear_model import Ridge as SklearnRidge
from sklearn.svm import SVR

from mien.retargeting.regression import CrossMappingModel, GprModel, RidgeModel, SvrModel
from mien.retargeting.regression.cross_mapping import fit_basis
from mien.retargeting.regression.gpr import fit_process
from mien.retargeting.regression.ridge import fit_ridge
from mien.retargeting.regression.svr import fit_support_vectors
from mien.retargeting.samples import samples
from mien.solve.ridge import PENALTIES, leave_one_out

MODELS = [RidgeModel(), GprModel(), SvrModel(), CrossMappingModel(share=0.999)]


def sheet(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    t = np.random.default_rng(seed).uniform(-1, 1, (count, 2))
    x = np.column_stack([t, t[:, :1] * t[:, 1:], np.sin(t)]) @ np.random.default_rng(0).normal(size=(5, 9))
    return x, np.column_stack([t[:, 0], t[:, 1], t[:, 0] * t[:, 1] + 2])


@pytest.mark.parametrize("model", MODELS, ids=lambda m: type(m).__name__)
def test_unseen_rows_are_mapped_with_variance_and_frame_by_frame(model) -> None:
    x, y = sheet(40, 1)
    learnt = model.learn(samples(x, y, sheet(30, 2)[0]))
    new, truth = sheet(50, 3)
    found = learnt.map(new)
    assert np.sqrt(((found - truth) ** 2).mean()) < 0.1 * truth.std(axis=0).mean()
    assert (learnt.variance(new) > 0).all()
    holes = new.copy()
    holes[3:9, ::3] = np.nan
    holes[7] = np.nan
    state, folded = learnt.start(), []
    for row in holes:
        state, values = learnt.step(state, row)
        folded.append(values)
    assert np.abs(np.array(folded) - learnt.map(holes)).max() < 1e-12
    assert np.array_equal(folded[7], folded[6])
    assert np.abs(np.array(folded)[3:7] - truth[3:7]).max() < 0.6


@pytest.mark.parametrize("model", MODELS, ids=lambda m: type(m).__name__)
def test_units_change_nothing_and_partial_labels_are_used(model) -> None:
    x, y = sheet(24, 4)
    y[15:, 1] = np.nan
    new, truth = sheet(20, 5)
    plain = model.learn(samples(x, y)).map(new)
    scaled = model.learn(samples(1000 * x + 7, 50 * y - 3)).map(1000 * new + 7)
    assert np.abs((scaled + 3) / 50 - plain).max() < 1e-3
    assert np.sqrt(((plain - truth) ** 2).mean()) < 0.6


@pytest.mark.parametrize("model", MODELS, ids=lambda m: type(m).__name__)
def test_one_label_and_constant_columns_give_that_pose(model) -> None:
    x, y = sheet(6, 6)
    one = model.learn(samples(x[:1], y[:1]))
    assert np.abs(one.map(x) - y[0]).max() < 1e-6
    x[:, 2], y[:, 1] = 3.0, 0.25
    learnt = model.learn(samples(x, y))
    assert np.abs(learnt.map(x)[:, 1] - 0.25).max() < 1e-6


def test_ridge_leaves_out_as_refitting_does() -> None:
    x, y = sheet(15, 7)
    y = y + np.random.default_rng(0).normal(0, 0.2, y.shape)
    at, centre = x.mean(axis=0), y.mean(axis=0)
    gram = (x - at) @ (x - at).T
    _, error = leave_one_out(gram, y - centre)
    size = np.maximum(np.linalg.eigvalsh(gram), 0).mean()

    def refitted(penalty: float) -> np.ndarray:
        out = []
        for i in range(len(x)):
            keep = np.arange(len(x)) != i
            model = SklearnRidge(alpha=penalty, solver="svd").fit(x[keep], y[keep])
            out.append((model.predict(x[i : i + 1])[0] - y[i]) ** 2)
        return np.mean(out, axis=0)

    every = [refitted(p * size) for p in PENALTIES[::4]]
    best = min(every, key=lambda e: e.sum())
    assert error.sum() <= best.sum() * (1 + 1e-6)
    assert any(np.allclose(refitted(p * size), error, rtol=1e-5) for p in PENALTIES)


def test_ridge_finds_a_linear_map_exactly() -> None:
    rng = np.random.default_rng(8)
    x = rng.normal(size=(30, 6))
    y = x @ rng.normal(size=(6, 3)) + 1
    assert np.abs(fit_ridge(x, y).mean(x) - y).max() < 1e-5


def test_gaussian_process_agrees_with_scikit_learn_at_its_own_parameters() -> None:
    x, y = sheet(20, 9)
    y = y + np.random.default_rng(0).normal(0, 0.1, y.shape)
    found = fit_process(x, y)
    # spread is θ1 + noise, and the reduction θ1² (K + noise)⁻¹ over it: both say what θ1 and the noise are.
    scaled = np.linalg.inv(found.reduction * found.spread[0])
    height = np.exp(-0.5 * found.steepness * ((x[0] - x[1]) ** 2).sum()) / scaled[0, 1]
    noise = found.spread[0] - height
    assert scaled[0, 0] == pytest.approx((height + noise) / height**2, rel=1e-6)
    kernel = ConstantKernel(height, "fixed") * RBF(found.steepness**-0.5, "fixed") + WhiteKernel(noise, "fixed")
    reference = GaussianProcessRegressor(kernel, alpha=0, optimizer=None).fit(x, y - y.mean(axis=0))
    new = sheet(10, 10)[0]
    assert np.abs(reference.predict(new) + y.mean(axis=0) - found.mean(new)).max() < 1e-4


def test_support_vectors_predict_as_scikit_learn_does() -> None:
    x, y = sheet(20, 11)
    found = fit_support_vectors(x, y)
    new = sheet(10, 12)[0]
    gammas = [(SVR(C=c, epsilon=0.02, gamma=found.steepness / 2).fit(x, y[:, 0]).predict(new)) for c in (1, 10, 100)]
    assert min(np.abs(g - found.mean(new)[:, 0]).max() for g in gammas) < 1e-3


def test_cross_mapping_is_a_ridge_regression_on_basis_functions() -> None:
    x, y = sheet(18, 8)
    found = fit_basis(x, y)
    features = np.exp(-0.5 * found.steepness * ((x[:, None] - x[None]) ** 2).sum(axis=2))
    size = float(np.linalg.eigvalsh(features @ features.T).mean())
    fits = [
        SklearnRidge(alpha=penalty * size, fit_intercept=False, solver="svd").fit(features, y - y.mean(axis=0)).coef_.T
        for penalty in PENALTIES
    ]
    assert min(np.abs(features @ (fit - found.coefficients)).max() for fit in fits) < 1e-6
