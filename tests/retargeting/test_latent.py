"""The shared latent space against its own equations, and what it promises of bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.sparse import csr_array, eye_array
from scipy.stats import multivariate_normal

from mien.core import InputError
from mien.retargeting.latent import LatentModel
from mien.retargeting.latent.neighbours import affine_weights, joint_operator, residual_operator
from mien.retargeting.latent.places import aligned
from mien.retargeting.latent.posterior import Posterior, Unknowns
from mien.retargeting.latent.search import energy
from mien.retargeting.latent.sparse import SparseLikelihood
from mien.retargeting.samples import Samples, samples
from mien.solve.gaussian_kernel import Kernel
from mien.solve.process_likelihood import DenseLikelihood


def curve(count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of a curved sheet in 12 source dimensions and 5 target ones."""
    rng = np.random.default_rng(seed)
    t = rng.uniform(-1, 1, (count, 2))
    maps = np.random.default_rng(0)
    lift, fall = maps.normal(size=(4, 12)), maps.normal(size=(4, 5))
    features = np.column_stack([t, np.sin(2 * t[:, 0]), t[:, 0] * t[:, 1]])
    return features @ lift, features @ fall, t


def given(labels: int = 12, source: int = 14, target: int = 10) -> Samples:
    x, y, _ = curve(labels + source + target, 1)
    return samples(x[:labels], y[:labels], x[labels : labels + source], y[labels + source :])


@pytest.fixture(scope="module")
def learnt():
    return LatentModel(dimensions=3, floor=1e-3, change=0.5).learn(given())


@pytest.mark.parametrize("inducing", [0, 6])
@pytest.mark.parametrize("floor", [0.0, 1e-2])
def test_the_gradient_is_that_of_the_differences(inducing: int, floor: float) -> None:
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=(9, 4)), rng.normal(size=(8, 3))
    y[2, 1] = y[5, 1] = y[4, 0] = np.nan
    operator = joint_operator(residual_operator(x, 3), residual_operator(y, 3), 5)
    none = np.zeros((0, 2))
    start = [rng.normal(size=(12, 2)), *(rng.normal(0, 0.3, 3) + [0, 0, 2] for _ in range(2))]
    points = [rng.normal(size=(inducing, 2)) if inducing else none for _ in range(2)]
    kind = SparseLikelihood if inducing else DenseLikelihood
    precision = csr_array(operator.T @ operator + eye_array(12))
    rows_y = np.r_[0:5, 9:12]
    posterior = Posterior(
        kind.of(x, floor), kind.of(y, floor), np.arange(9), rows_y, precision, Unknowns(*start, *points)
    )
    at = posterior.shape.flat()
    exact = posterior(at)[1]
    step = 1e-5
    central = [(posterior(at + step * e)[0] - posterior(at - step * e)[0]) / (2 * step) for e in np.eye(len(at))]
    assert np.abs(exact - central).max() < 1e-6 * max(1.0, np.abs(exact).max())


def test_the_likelihood_is_the_density_of_a_normal_distribution() -> None:
    rng = np.random.default_rng(3)
    z, y = rng.normal(size=(6, 2)), rng.normal(size=(6, 3))
    y[4, 2] = np.nan
    kernel = Kernel.of(np.log([1.5, 0.7, 30.0]))
    covariance = kernel(z, z) + kernel.noise * np.eye(6)
    wanted = -sum(
        multivariate_normal(np.zeros(len(k)), covariance[np.ix_(k, k)]).logpdf(y[k, c]) + len(k) / 2 * np.log(2 * np.pi)
        for c, k in ((c, np.flatnonzero(~np.isnan(y[:, c]))) for c in range(3))
    )
    assert DenseLikelihood.of(y)(z, np.log([1.5, 0.7, 30.0]))[0] == pytest.approx(wanted, rel=1e-10)


def test_inducing_points_at_the_latent_points_change_nothing() -> None:
    rng = np.random.default_rng(4)
    z, y, logs = rng.normal(size=(10, 2)), rng.normal(size=(10, 3)), np.log([1.5, 0.7, 30.0])
    exact, sparse = DenseLikelihood.of(y)(z, logs)[0], SparseLikelihood.of(y)(z, z, logs)[0]
    assert sparse == pytest.approx(exact, rel=1e-4)


def test_neighbours_weigh_one_in_all_and_rebuild_a_plane() -> None:
    rng = np.random.default_rng(5)
    rows = rng.normal(size=(30, 2)) @ rng.normal(size=(2, 7)) + rng.normal(size=7)
    operator = residual_operator(rows, 8)
    assert np.abs(operator @ np.ones(30)).max() < 1e-12
    assert np.abs(operator @ rows).max() < 0.05 * rows.std()
    best = minimize(lambda w: ((rows[0] - np.append(w, 1 - w.sum()) @ rows[1:4]) ** 2).sum(), np.zeros(2), tol=1e-14).x
    weights = affine_weights(rows[0], rows[1:4])
    assert ((rows[0] - weights @ rows[1:4]) ** 2).sum() >= (
        (rows[0] - np.append(best, 1 - best.sum()) @ rows[1:4]) ** 2
    ).sum()


def test_rows_in_time_have_those_beside_them_as_neighbours() -> None:
    rows = np.random.default_rng(6).normal(size=(40, 5))
    operator = residual_operator(rows, 3, in_time_from=10).toarray()
    assert all(operator[i, i - 1] != 0 and operator[i, i + 1] != 0 for i in range(11, 39))


def test_alignment_puts_a_label_at_one_place_and_keeps_to_neighbours() -> None:
    s = given()
    operator = joint_operator(residual_operator(s.X, 8), residual_operator(s.Y, 8), len(s))
    z = aligned(operator, 2)
    assert np.abs(z.mean(axis=0)).max() < 1e-10
    assert np.abs(z.std(axis=0) - 1).max() < 1e-10
    noise = np.random.default_rng(0).normal(size=z.shape)
    assert ((operator @ z) ** 2).sum() < 0.01 * ((operator @ noise) ** 2).sum()


def test_the_search_has_the_gradient_of_its_energy(learnt) -> None:
    source = learnt.source
    centres, kernel, coefficients, _, _, reduction = source._compiled
    d, q = coefficients.shape[1], centres.shape[1]
    rng = np.random.default_rng(7)
    wanted, weight, rest = rng.normal(size=d), rng.uniform(0, 50, d), np.array([0.3, 20.0])
    gradient, work, at = np.empty(q), np.empty((3, max(d, len(centres)))), rng.normal(0, 0.5, q)

    def value(z: np.ndarray) -> float:
        return energy(z, centres, kernel, coefficients, reduction, wanted, weight, rest, np.empty(q), work)

    energy(at, centres, kernel, coefficients, reduction, wanted, weight, rest, gradient, work)
    central = [(value(at + 1e-5 * e) - value(at - 1e-5 * e)) / 2e-5 for e in np.eye(q)]
    assert np.abs(gradient - central).max() < 1e-6 * max(1, np.abs(gradient).max())


def test_a_frame_is_the_minimum_over_observation_and_latent_point_together(learnt) -> None:
    """Eq. 12 written out, minimised over both by another optimiser."""
    source, r = learnt.source, learnt.source.regressor
    x = learnt.source_scaling(curve(1, 9)[0][0])
    x[3] = np.nan
    before = source.step(source.start(), x + 0.1)
    found = source.step(before, x)
    seen = ~np.isnan(x)

    def literal(both: np.ndarray) -> float:
        meant, z = both[: len(x)], both[len(x) :]
        mean, k = r.mean(z[None])[0], r.kernel(z[None], r.centres)[0]
        variance = r.kernel.height + r.kernel.noise - k @ r.reductions[0] @ k
        value = ((x - meant)[seen] ** 2).sum() / (2 * source.noise) + ((before.x - meant) ** 2).sum() / (
            2 * source.change
        )
        return value + ((meant - mean) ** 2).sum() / (2 * variance) + len(x) / 2 * np.log(variance) + z @ z / 2

    other = minimize(literal, np.concatenate([found.x, found.z]), method="BFGS", options={"gtol": 1e-6})
    assert literal(np.concatenate([found.x, found.z])) - other.fun < 1e-4
    assert np.abs(other.x[: len(x)] - found.x).max() < 0.01


def test_frame_by_frame_gives_what_the_whole_take_gives(learnt) -> None:
    x = curve(40, 11)[0].copy()
    x[5, 2:7] = np.nan
    x[9] = np.nan
    state, folded = learnt.start(), []
    for row in x:
        state, y = learnt.step(state, row)
        folded.append(y)
    assert np.abs(np.array(folded) - learnt.map(x)).max() < 1e-9
    assert np.abs(folded[9] - folded[8]).max() < 1e-12


def test_unseen_frames_are_mapped_and_missing_markers_come_back(learnt) -> None:
    x, y, _ = curve(60, 12)
    alone = LatentModel(dimensions=3, floor=1e-3).learn(given())
    assert np.sqrt(((alone.map(x) - y) ** 2).mean()) < 0.15 * y.std()
    holes = x.copy()
    holes[:, ::4] = np.nan
    found = alone.trace(holes)
    assert np.sqrt(((found.recovered - x)[:, ::4] ** 2).mean()) < 0.25 * x.std()
    assert np.sqrt(((found.values - y) ** 2).mean()) < 0.3 * y.std()


def test_noise_is_taken_out_of_the_observation() -> None:
    x, _, _ = curve(60, 13)
    noisy = x + np.random.default_rng(0).normal(0, 0.3, x.shape)
    found = LatentModel(dimensions=3, floor=1e-3, noise=0.3 / x.std()).learn(given()).trace(noisy)
    assert ((found.recovered - x) ** 2).mean() < 0.5 * ((noisy - x) ** 2).mean()


def test_the_variance_grows_away_from_what_was_seen(learnt) -> None:
    x = curve(30, 14)[0]
    far = LatentModel(dimensions=3, floor=1e-3).learn(given())
    assert far.variance(6 * x).mean() > 2 * far.variance(x).mean()
    assert far.variance(x).min() > 0


def test_units_and_the_order_of_unlabelled_rows_change_nothing() -> None:
    s, x = given(), curve(10, 15)[0]
    model = LatentModel(dimensions=3, floor=1e-3, iterations=40)
    plain = model.learn(s).map(x)
    scaled = samples(1000 * s.X_labelled + 5, s.Y_labelled, 1000 * s.X_only + 5, s.Y_only)
    assert np.abs(model.learn(scaled).map(1000 * x + 5) - plain).max() < 1e-3
    turned = samples(s.X_labelled, 100 * s.Y_labelled - 3, s.X_only, 100 * s.Y_only - 3)
    assert np.abs((model.learn(turned).map(x) + 3) / 100 - plain).max() < 1e-3


def test_a_pose_is_completed_from_a_few_entries(learnt) -> None:
    _, y, _ = curve(30, 16)
    error, blind = [], []
    for pose in y:
        part = pose.copy()
        part[3:] = np.nan
        whole, variance = learnt.complete(part)
        assert variance.shape == whole.shape
        error.append(((whole - pose)[3:] ** 2).mean())
        blind.append((pose[3:] ** 2).mean())
    assert np.mean(error) < 0.1 * np.mean(blind)
    with pytest.raises(InputError, match="no entry"):
        learnt.complete(np.full(5, np.nan))


@pytest.mark.parametrize(
    "settings", [{"inducing": 15}, {"in_time": True}, {"dimensions": 0}, {"beginning": "principal"}]
)
def test_every_option_still_learns_the_map(settings: dict) -> None:
    x, y, _ = curve(60, 12)
    found = LatentModel(**{"dimensions": 3, "floor": 1e-3, **settings}).learn(given()).map(x)
    assert np.sqrt(((found - y) ** 2).mean()) < 0.3 * y.std()


def test_learning_says_how_far_it_got() -> None:
    short = LatentModel(iterations=3, gradient=1e-9).learn(given())
    assert not short.convergence.converged
    assert short.convergence.iterations <= 3
    assert "not-converged" in {note.code for note in short.notes}
    done = LatentModel(dimensions=3, floor=1e-2, iterations=2000).learn(given())
    assert done.convergence.converged
    assert done.convergence.gradient <= 1e-3
    assert not done.notes


def test_partly_labelled_rows_teach_what_they_give() -> None:
    s = given(labels=30)
    y = s.Y_labelled.copy()
    y[20:, 0] = np.nan
    y[25] = np.nan
    x, truth, _ = curve(40, 17)
    learnt = LatentModel(dimensions=3, floor=1e-3).learn(replace(s, Y_labelled=y))
    assert np.sqrt(((learnt.map(x) - truth) ** 2).mean()) < 0.25 * truth.std()
    assert "labels-empty" in {note.code for note in learnt.notes}


def test_degenerate_samples_are_learned_or_refused_in_words() -> None:
    s = given()
    one = LatentModel().learn(samples(s.X_labelled[:1], s.Y_labelled[:1]))
    assert np.abs(one.map(s.X_labelled) - s.Y_labelled[0]).max() < 1e-6
    assert "one-label" in {note.code for note in one.notes}
    constant = np.column_stack([s.X_labelled, np.ones(len(s))])
    still = LatentModel(iterations=20).learn(samples(constant, s.Y_labelled))
    assert np.isfinite(still.map(constant)).all()
    same = np.repeat(s.X_labelled[:1], 4, axis=0)
    y = s.Y_labelled
    never = s.X_labelled.copy()
    never[:, 2] = np.nan
    for wrong, why in (
        (lambda: samples(s.X_labelled[:0], y[:0]), "no labels"),
        (lambda: samples(s.X_labelled, np.full_like(y, np.nan)), "never given"),
        (lambda: samples(same, y[:4]), "contradict"),
        (lambda: samples(s.X_labelled, y[:3]), "one target row for each"),
        (lambda: samples(never, y), "never seen"),
        (lambda: samples(s.X_labelled * np.inf, y), "infinite"),
        (lambda: samples(s.X_labelled, y, s.X_only[:, :3]), "must agree"),
        (lambda: LatentModel().learn(samples(same, np.repeat(y[:1], 4, axis=0))), "varies"),
        (lambda: LatentModel(beginning="random"), "alignment"),
        (lambda: LatentModel(neighbours=0), "neighbours"),
    ):
        with pytest.raises(InputError, match=why):
            wrong()


def test_gaps_in_the_training_source_are_filled_and_counted() -> None:
    s = given()
    x = s.X_only.copy()
    x[::3, :4] = np.nan
    learnt = LatentModel(dimensions=3, floor=1e-3).learn(replace(s, X_only=x))
    assert any(note.code == "gaps-filled" and str(np.isnan(x).sum()) in note.message for note in learnt.notes)
