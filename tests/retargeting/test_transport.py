"""Learning by transport: what it must not depend on, what it falls back to, and its parts against references."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.optimize import approx_fprime, linear_sum_assignment, linprog
from scipy.spatial.distance import cdist

from mien.core import InputError, Note
from mien.retargeting.records import record, restored
from mien.retargeting.samples import Samples
from mien.retargeting.transport import LearntTransport, TransportModel
from mien.retargeting.transport.experts import LinearExpert, ProcessExpert, Seen, alone, stretch_of
from mien.retargeting.transport.hull import LocalHull
from mien.retargeting.transport.plan import transport_plan
from mien.retargeting.transport.posing import completed, weighted_median
from mien.retargeting.transport.principal import PrincipalSpace
from mien.retargeting.transport.process import PRIOR, LinearRadialKernel, Process, evidence
from mien.retargeting.transport.shares import Shares, shares


def performance(rng: np.random.Generator, frames: int, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Sparse non-negative controls, as faces have, and the markers they move."""
    fixed = np.random.default_rng(5)
    mixing = fixed.normal(size=(7, 40)) * np.geomspace(5, 0.3, 7)[:, None]
    y = np.maximum(rng.gamma(0.5, 0.5, (frames, 7)) - 0.1, 0)
    return y @ mixing + noise * rng.normal(size=(frames, 40)), y


def drawn(rng: np.random.Generator, labels: int = 8, only: int = 60, noise: float = 0.05) -> Samples:
    x, y = performance(rng, labels + 2 * only, noise)
    return Samples(x[:labels], y[:labels], x[labels : labels + only], y[labels + only :])


def rms(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.sqrt(((a - b) ** 2).mean()))


def test_the_plan_has_the_marginals_it_must_have(rng: np.random.Generator) -> None:
    plan = transport_plan(rng.random((12, 20)), 0.05, 2000)
    np.testing.assert_allclose(plan.sum(axis=1), 1 / 12, rtol=1e-9)
    np.testing.assert_allclose(plan.sum(axis=0), 1 / 20, rtol=1e-6)


def test_a_hard_plan_is_the_optimal_assignment(rng: np.random.Generator) -> None:
    cost = cdist(rng.normal(size=(15, 3)), rng.normal(size=(15, 3)), "sqeuclidean")
    rows, columns = linear_sum_assignment(cost)
    plan = transport_plan(cost, 0.01, 20000) * 15
    assert (plan * cost).sum() == pytest.approx(cost[rows, columns].sum(), rel=0.01)
    assert (plan.argmax(axis=1) == columns).mean() > 0.85


def test_a_soft_plan_costs_little_more_than_the_linear_programme(rng: np.random.Generator) -> None:
    cost = rng.random((8, 11))
    sums = np.vstack([np.kron(np.eye(8), np.ones(11)), np.kron(np.ones(8), np.eye(11))])
    best = linprog(cost.ravel(), A_eq=sums, b_eq=np.r_[np.full(8, 1 / 8), np.full(11, 1 / 11)]).fun
    softness = 0.01
    found = float((transport_plan(cost, softness, 20000) * cost).sum())
    assert best - 1e-6 < found < best + softness * np.log(8 * 11)


def test_the_gradient_of_the_evidence_is_that_of_differences(rng: np.random.Generator) -> None:
    x, y = rng.normal(size=(9, 4)), rng.normal(size=(9, 3))
    parts = x @ x.T / 4, cdist(x, x, "sqeuclidean") / 16, y @ y.T, 3
    for shift in (0.0, 0.7):
        at = np.log(PRIOR) + shift
        slope = approx_fprime(at, lambda logs: evidence(logs, *parts)[0], 1e-7)
        np.testing.assert_allclose(evidence(at, *parts)[1], slope, rtol=1e-4, atol=1e-4)


def test_a_missing_entry_is_found_from_the_others(rng: np.random.Generator) -> None:
    x, _ = performance(rng, 120)
    space = PrincipalSpace.of(x)
    holes = x[:5].copy()
    holes[:, ::4] = np.nan
    np.testing.assert_allclose(space.completed(holes), x[:5], atol=1e-3 * x.std())


def test_coordinates_of_a_whole_row_are_those_of_conditioning_on_all_its_entries(rng: np.random.Generator) -> None:
    x, _ = performance(rng, 120, 0.3)
    space = PrincipalSpace.of(x)
    system = space.axes @ space.axes.T + np.diag(space.noise / space.spread**2)
    expected = np.linalg.solve(system, space.axes @ (x - space.mean).T).T
    np.testing.assert_allclose(space.coordinates(x), expected, atol=1e-10 * x.std())


def test_the_noise_of_the_markers_is_found(rng: np.random.Generator) -> None:
    x, _ = performance(rng, 150, 0.3)
    assert PrincipalSpace.of(x).noise == pytest.approx(0.09, rel=0.15)


def test_unlabelled_rows_of_both_sides_make_it_better(rng: np.random.Generator) -> None:
    ratios = []
    for _ in range(2):
        given = drawn(rng)
        x, y = performance(rng, 200, 0.05)
        ratios.append(
            rms(TransportModel().learn(given).map(x), y) / rms(TransportModel(rounds=0).learn(given).map(x), y)
        )
    assert np.mean(ratios) < 0.9


def test_without_target_only_rows_it_is_the_process_and_a_linear_map(rng: np.random.Generator) -> None:
    given = drawn(rng)
    given = Samples(given.X_labelled, given.Y_labelled, given.X_only, given.Y_only[:0])
    learnt = TransportModel().learn(given)
    space = PrincipalSpace.of(given.X)
    process = alone(stretch_of(space, 0.5), space.coordinates(given.X_labelled), given.Y_labelled)
    line = LinearExpert.told(given.X_labelled, given.Y_labelled)
    seen = Seen.of(space, given.X_only)
    say = learnt.shares.at(process.doubt(seen))
    expected = say[:, :1] * process.expected(seen) + say[:, 1:] * line.expected(seen)
    np.testing.assert_allclose(learnt.map(given.X_only), expected, atol=1e-12)


def test_target_rows_of_another_kind_do_no_harm(rng: np.random.Generator) -> None:
    given = drawn(rng, labels=12)
    foreign = Samples(given.X_labelled, given.Y_labelled, given.X_only, 3 + 5 * rng.normal(size=(60, 7)))
    x, y = performance(rng, 200, 0.05)
    learnt = TransportModel().learn(foreign)
    assert learnt.shares.doubtful[:2].sum() > 0.5
    assert rms(learnt.map(x), y) < 1.05 * rms(TransportModel(rounds=0).learn(foreign).map(x), y)


def test_the_order_of_unlabelled_rows_does_not_matter(rng: np.random.Generator) -> None:
    given = drawn(rng)
    mixed = Samples(
        given.X_labelled, given.Y_labelled, given.X_only[rng.permutation(60)], given.Y_only[rng.permutation(60)]
    )
    x, _ = performance(rng, 30)
    np.testing.assert_allclose(TransportModel().learn(mixed).map(x), TransportModel().learn(given).map(x), atol=1e-5)


def test_units_do_not_matter(rng: np.random.Generator) -> None:
    given = drawn(rng)
    other = Samples(given.X_labelled * 1000, given.Y_labelled / 7, given.X_only * 1000, given.Y_only / 7)
    x, _ = performance(rng, 30)
    expected = TransportModel().learn(given).map(x)
    np.testing.assert_allclose(TransportModel().learn(other).map(1000 * x) * 7, expected, atol=1e-5)


def test_steps_are_the_map_and_learning_is_deterministic(rng: np.random.Generator) -> None:
    given = drawn(rng)
    x, _ = performance(rng, 12)
    x[3:6, 4:9] = np.nan
    x[7] = np.nan
    learnt, again = TransportModel().learn(given), TransportModel().learn(given)
    state, rows = learnt.start(), []
    for row in x:
        state, y = learnt.step(state, row)
        rows.append(y)
    np.testing.assert_allclose(rows, learnt.map(x), atol=1e-12)
    np.testing.assert_array_equal(learnt.map(x), again.map(x))


def test_doubt_grows_away_from_the_labels(rng: np.random.Generator) -> None:
    given = drawn(rng)
    learnt = TransportModel().learn(given)
    near, far = learnt.variance(given.X_labelled).mean(), learnt.variance(4 * given.X_only).mean()
    assert 0 <= near < far


@pytest.mark.parametrize("labels", [1, 2, 3])
def test_very_few_labels_are_enough_to_learn_something_finite(rng: np.random.Generator, labels: int) -> None:
    given = drawn(rng, labels=labels)
    learnt = TransportModel().learn(given)
    assert np.isfinite(learnt.map(given.X_only)).all()
    assert np.isfinite(learnt.variance(given.X_only)).all()


def test_constant_columns_and_labels_with_gaps_are_learned_from(rng: np.random.Generator) -> None:
    given = drawn(rng, labels=12)
    y, x = given.Y_labelled.copy(), given.X_labelled.copy()
    x[:, 3], y[:, 2], y[1, 4] = 1.0, 0.25, np.nan
    only_x, only_y = given.X_only.copy(), given.Y_only.copy()
    only_x[:, 3], only_y[:, 2] = 1.0, 0.25
    learnt = TransportModel().learn(Samples(x, y, only_x, only_y))
    np.testing.assert_allclose(learnt.map(only_x)[:, 2], 0.25, atol=1e-3)
    assert [note.code for note in learnt.notes] == ["targets-completed"]


def test_a_pose_is_completed_better_than_by_the_mean_and_keeps_what_was_given(rng: np.random.Generator) -> None:
    given = drawn(rng)
    mixing = np.random.default_rng(2).normal(size=(7, 25))
    wide = Samples(given.X_labelled, given.Y_labelled @ mixing, given.X_only, given.Y_only @ mixing)
    learnt = TransportModel(rounds=0).learn(wide)
    poses = performance(rng, 50)[1] @ mixing
    asked = poses.copy()
    asked[:, 3:] = np.nan
    found = np.array([learnt.complete(row) for row in asked])
    np.testing.assert_array_equal(found[:, :3], poses[:, :3])
    assert rms(found[:, 3:], poses[:, 3:]) < 0.9 * rms(wide.Y.mean(axis=0)[3:], poses[:, 3:])


def test_what_is_learned_survives_as_plain_values_and_arrays(rng: np.random.Generator) -> None:
    given = drawn(rng)
    learnt, arrays = TransportModel().learn(given), {}
    written = json.loads(json.dumps(record(learnt, arrays)))
    classes = (LearntTransport, PrincipalSpace, ProcessExpert, LinearExpert, Shares, Process, LinearRadialKernel)
    classes = (*classes, LocalHull, Note)
    again = restored(written, arrays, {kind.__name__: kind for kind in classes})
    np.testing.assert_array_equal(again.map(given.X_only), learnt.map(given.X_only))
    np.testing.assert_array_equal(again.variance(given.X_only), learnt.variance(given.X_only))


def test_a_pose_of_nothing_is_refused(rng: np.random.Generator) -> None:
    with pytest.raises(InputError, match="no entry"):
        TransportModel(rounds=0).learn(drawn(rng)).complete(np.full(7, np.nan))


def test_where_labels_solve_a_clean_linear_rig_the_weak_ones_do_not_spoil_it(rng: np.random.Generator) -> None:
    acts = np.abs(rng.normal(size=(300, 12))) * 0.8 ** np.arange(12)
    x, y = acts @ rng.normal(size=(12, 60)), acts @ rng.normal(size=(12, 8))
    given = Samples(x[:14], y[:14], x[16:116], y[116:216])
    learnt = TransportModel().learn(given)
    exact = LinearExpert.told(x[:14], y[:14])
    rest = Seen(x[216:], x[216:])
    assert rms(exact.expected(rest), y[216:]) < 1e-5
    assert rms(learnt.map(x[216:]), y[216:]) < 0.01 * y.std()


def test_shares_are_shares_and_go_to_the_expert_that_is_right(rng: np.random.Generator) -> None:
    given = drawn(rng, labels=20)
    space = PrincipalSpace.of(given.X)
    seen, stretch = Seen.of(space, given.X_labelled), stretch_of(space, 0.5)

    def learn(used: np.ndarray) -> list[object]:
        good = alone(stretch, seen.coordinates[used], given.Y_labelled[used])
        return [good, LinearExpert(np.zeros((given.X.shape[1], 7)), np.full(7, 50.0), np.ones(7))]

    found = shares(learn, seen, given.Y_labelled, 2)
    say = found.at(np.geomspace(1e-6, 1, 9))
    assert (say >= 0).all()
    np.testing.assert_allclose(say.sum(axis=1), 1, atol=1e-12)
    assert (say[:, 0] > 0.95).all()


def test_a_completed_pose_stays_in_range_and_leaves_most_entries_at_rest(rng: np.random.Generator) -> None:
    poses = np.where(rng.random((400, 30)) < 0.15, rng.random((400, 30)), 0.0)
    poses[:, 1] = 0.5 * poses[:, 0]
    asked = np.full(30, np.nan)
    asked[0] = 0.9
    found = completed(asked, PrincipalSpace.of(poses), poses)
    assert found[0] == 0.9
    assert 0.2 < found[1] <= 0.5
    assert ((found >= 0) & (found <= 1)).all()
    assert (np.abs(found[2:]) > 0.02).sum() <= 3


def test_a_weighted_median_counts_rows_as_often_as_they_weigh(rng: np.random.Generator) -> None:
    rows, often = rng.normal(size=(15, 4)), rng.integers(1, 5, 15)
    often[0] += 1 - often.sum() % 2
    np.testing.assert_array_equal(
        weighted_median(rows, often.astype(float)), np.median(np.repeat(rows, often, axis=0), axis=0)
    )
