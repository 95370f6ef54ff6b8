from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import minimize

from mien.core import InputError
from mien.solve.layered import Bias, LayeredProblem, descend_from, first_starts, layer_weights, solve_layered

SIZES = (9, 5, 3)
REGIONS = 3


@dataclass(frozen=True)
class Take:
    """Bases, regions of points, displacements, and the small problem made of them."""

    basis: np.ndarray
    region: np.ndarray
    moved: np.ndarray
    problem: LayeredProblem
    data: np.ndarray
    energy: np.ndarray


def reduced(basis: np.ndarray, region: np.ndarray, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    masks = [np.repeat(region == r, 3) for r in range(REGIONS)]
    flat, seen = basis.reshape(len(basis), -1), moved.reshape(len(moved), -1)
    gram = np.stack([flat[:, m] @ flat[:, m].T for m in masks]) / len(region)
    data = np.stack([seen[:, m] @ flat[:, m].T for m in masks], axis=1) / len(region)
    return gram, data, (seen**2).sum(axis=1) / len(region)


def take(frames: int = 40, smooth: float = 1e-3, gamma: bool = True, noise: float = 0.05, points: int = 30) -> Take:
    """A performance made by the model itself, with noise, its shares wandering."""
    rng = np.random.default_rng(5)
    region = np.arange(points) % REGIONS
    basis = rng.normal(0, 0.4, (sum(SIZES), points, 3))
    t = np.linspace(0, 3, frames)[:, None]

    def wandering(n: int) -> np.ndarray:
        raw = np.exp(4 * np.sin(t * rng.uniform(1, 3, n) + rng.uniform(0, 6, n)))
        return raw / raw.sum(axis=1, keepdims=True)

    shares = np.concatenate([wandering(n) for n in SIZES], axis=1)
    weights = np.stack([wandering(len(SIZES)) for _ in range(REGIONS)], axis=1)
    y = layer_weights(np.cumsum((0, *SIZES)), weights, shares)
    moved = np.einsum("fpn,npx->fpx", y[:, region], basis) + rng.normal(0, noise, (frames, points, 3))
    gram, data, energy = reduced(basis, region, moved)
    bias = Bias(1, 1, np.eye(SIZES[1])[2]) if gamma else None
    return Take(basis, region, moved, LayeredProblem(gram, SIZES, smooth, bias), data, energy)


def literal(t: Take, z: np.ndarray, f: int, gamma: float, before: np.ndarray | None) -> float:
    """The objective as it is written, from the points themselves."""
    weights, alpha = z[:9].reshape(3, 3), z[9:]
    layers = np.split(alpha, np.cumsum(SIZES)[:-1])
    bases = np.split(t.basis, np.cumsum(SIZES)[:-1])
    face = sum(
        weights[r, j] * (t.region == r)[:, None] * np.tensordot(layers[j], bases[j], axes=1)
        for r in range(REGIONS)
        for j in range(len(SIZES))
    )
    value = (1 - gamma) * ((t.moved[f] - face) ** 2).sum() / len(t.region)
    value += gamma * (((weights[1] - [0, 1, 0]) ** 2).sum() + ((layers[1] - np.eye(5)[2]) ** 2).sum())
    return value + (0 if before is None else t.problem.smooth * ((z - before) ** 2).sum())


def unknowns(rng: np.random.Generator) -> np.ndarray:
    return np.concatenate([rng.dirichlet(np.ones(n)) for n in (3, 3, 3, *SIZES)])


def test_the_small_objective_is_the_written_one_and_its_gradient_is_its_slope(rng: np.random.Generator) -> None:
    t = take()
    for gamma, before in ((0.0, None), (0.3, unknowns(rng)), (1.0, unknowns(rng))):
        z = unknowns(rng)
        value, gradient, _ = t.problem.evaluate(z[:9].reshape(3, 3), z[9:], t.data[7], t.energy[7], gamma, before)
        assert value == pytest.approx(literal(t, z, 7, gamma, before), abs=1e-12)
        for i in range(len(z)):
            step = 1e-5 * np.eye(len(z))[i]
            slope = (literal(t, z + step, 7, gamma, before) - literal(t, z - step, 7, gamma, before)) / 2e-5
            assert gradient[i] == pytest.approx(slope, abs=1e-7)


def test_shares_are_exact_and_no_first_order_move_improves() -> None:
    t = take(frames=60)
    gamma = np.linspace(0, 1, 60) ** 4
    found = solve_layered(t.problem, t.data, t.energy, gamma)
    assert found.converged
    assert found.kkt.max() <= 1e-10
    assert np.abs(found.weights.sum(axis=2) - 1).max() < 1e-14
    assert np.abs(np.add.reduceat(found.coefficients, [0, 9, 14], axis=1) - 1).max() < 1e-14
    assert min(found.weights.min(), found.coefficients.min()) >= 0
    for f in (0, 20, 59):
        before = None if f == 0 else np.concatenate([found.weights[f - 1].ravel(), found.coefficients[f - 1]])
        value, _, kkt = t.problem.evaluate(
            found.weights[f], found.coefficients[f], t.data[f], t.energy[f], gamma[f], before
        )
        assert value == pytest.approx(found.objective[f], abs=1e-12)
        assert kkt <= 1e-9


@pytest.mark.parametrize("smooth", [0.0, 1e-3, 0.1])
def test_every_half_step_lowers_the_objective(smooth: float, rng: np.random.Generator) -> None:
    t = take(smooth=smooth)
    for f in range(0, 40, 4):
        for gamma in (0.0, 0.5):
            before = unknowns(rng)
            *_, history = descend_from(t.problem, unknowns(rng), t.data[f], t.energy[f], gamma, before)
            assert len(history) > 2
            assert np.diff(history).max() <= 1e-13 * t.energy[f]
            assert history[-1] < history[0]


def test_frame_by_frame_gives_the_offline_result_to_the_bit() -> None:
    t = take()
    whole = solve_layered(t.problem, t.data, t.energy)
    before = None
    for f in range(40):
        one = solve_layered(t.problem, t.data[f : f + 1], t.energy[f : f + 1], before=before)
        before = one.last
        assert np.array_equal(one.weights[0], whole.weights[f])
        assert np.array_equal(one.coefficients[0], whole.coefficients[f])


def test_slsqp_on_the_whole_points_finds_no_lower_objective_from_the_same_start() -> None:
    t = take(frames=5)
    gamma = 0.2
    found = solve_layered(t.problem, t.data, t.energy, np.full(5, gamma))
    z = np.concatenate([found.weights.reshape(5, -1), found.coefficients], axis=1)
    rows = np.repeat(np.eye(6), (3, 3, 3, *SIZES), axis=1)
    excess = []
    for f in range(1, 5):
        peer = minimize(
            lambda x, f=f: literal(t, x, f, gamma, z[f - 1]),
            z[f - 1],
            jac=lambda x, f=f: t.problem.evaluate(x[:9].reshape(3, 3), x[9:], t.data[f], t.energy[f], gamma, z[f - 1])[
                1
            ],
            method="SLSQP",
            bounds=[(0, 1)] * len(z[0]),
            constraints=[{"type": "eq", "fun": lambda x: rows @ x - 1, "jac": lambda x: rows}],
            options={"ftol": 1e-12, "maxiter": 300},
        )
        excess.append(found.objective[f] / peer.fun - 1)
    assert np.mean(excess) < 1e-6


def test_closed_lips_are_the_bias_itself_and_nothing_is_singular() -> None:
    t = take(smooth=1e-9)
    found = solve_layered(t.problem, t.data[:5], t.energy[:5], np.ones(5))
    assert found.converged
    assert np.abs(found.weights[1:, 1] - [0, 1, 0]).max() < 1e-6
    assert np.abs(found.coefficients[1:, 9:14] - np.eye(5)[2]).max() < 1e-6


def test_doubling_every_point_changes_nothing() -> None:
    t = take()
    twice = reduced(np.repeat(t.basis, 2, axis=1), np.repeat(t.region, 2), np.repeat(t.moved, 2, axis=1))
    once = solve_layered(t.problem, t.data, t.energy)
    again = solve_layered(LayeredProblem(twice[0], SIZES, t.problem.smooth, t.problem.bias), *twice[1:])
    assert np.abs(once.objective / again.objective - 1).max() < 1e-10
    assert np.abs(once.coefficients - again.coefficients).max() < 1e-10
    assert np.abs(once.weights - again.weights).max() < 1e-10


def test_the_order_of_extremes_does_not_matter(rng: np.random.Generator) -> None:
    t = take(gamma=False)
    order = np.concatenate([rng.permutation(9), 9 + rng.permutation(5), 14 + rng.permutation(3)])
    shuffled = LayeredProblem(t.problem.gram[:, order][:, :, order], SIZES, t.problem.smooth)
    one, other = solve_layered(t.problem, t.data, t.energy), solve_layered(shuffled, t.data[:, :, order], t.energy)
    plain = solve_layered(LayeredProblem(t.problem.gram, SIZES, t.problem.smooth), t.data, t.energy)
    assert np.array_equal(one.weights, plain.weights)
    assert np.abs(plain.weights - other.weights).max() < 1e-6
    assert np.abs(plain.coefficients[:, order] - other.coefficients).max() < 1e-6


def test_a_performance_inside_the_model_is_found_again() -> None:
    t = take(noise=0.0, smooth=0.0, gamma=False)
    found = solve_layered(t.problem, t.data, t.energy)
    assert found.objective.max() < 1e-6 * t.energy.mean()


def test_a_layer_asleep_wakes_when_it_is_needed() -> None:
    """Blinking after a long time of no blink: no slope tells that another coefficient would earn the layer weight."""
    rng = np.random.default_rng(0)
    eyes = np.zeros((8, 10, 3))
    eyes[1:3, :5] = rng.normal(size=(2, 5, 3))
    eyes[3:6, 3:8] = rng.normal(size=(3, 5, 3))
    eyes[7, 8:] = -1.0
    region = np.repeat([0, 1, 2], [4, 4, 2])
    gram, data, energy = reduced(eyes, region, np.stack([eyes[0], eyes[7]]))
    problem = LayeredProblem(gram, (3, 3, 2), 1e-4)
    asleep = np.concatenate([[1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0]])
    found = solve_layered(problem, data[1:], energy[1:], before=asleep)
    assert found.weights[0, 2, 2] > 0.9
    assert found.coefficients[0, 7] > 0.9


def test_many_starts_reach_what_random_ones_reach(rng: np.random.Generator) -> None:
    t = take(gamma=False)
    assert len(first_starts(t.problem, t.data[0])) == 28
    worse = 0
    for f in range(0, 40, 8):
        mine = solve_layered(t.problem, t.data[f : f + 1], t.energy[f : f + 1]).objective[0]
        best = min(descend_from(t.problem, unknowns(rng), t.data[f], t.energy[f])[1] for _ in range(20))
        worse += mine > best * (1 + 1e-6)
    assert worse <= 1


@pytest.mark.parametrize("sizes", [(1, 1), (4,), (2, 1, 3, 2, 2)])
def test_any_number_of_layers_and_extremes_works(sizes: tuple[int, ...], rng: np.random.Generator) -> None:
    basis, region = rng.normal(size=(sum(sizes), 12, 3)), np.arange(12) % REGIONS
    gram, data, energy = reduced(basis, region, rng.normal(size=(4, 12, 3)))
    found = solve_layered(LayeredProblem(gram, sizes, 1e-3), data, energy)
    assert found.converged
    assert found.weights.shape == (4, 3, len(sizes))


def test_bad_input_is_refused_in_words() -> None:
    t = take(frames=3)
    gram = t.problem.gram
    for call, why in (
        (lambda: LayeredProblem(gram, (9, 5, 4)), "shape"),
        (lambda: LayeredProblem(gram, (9, 8, 0)), "at least one extreme"),
        (lambda: LayeredProblem(-gram, SIZES), "semi-definite"),
        (lambda: LayeredProblem(gram, SIZES, -1.0), "smoothness"),
        (lambda: LayeredProblem(gram, SIZES, 0.0, Bias(3, 1, np.zeros(5))), "region"),
        (lambda: LayeredProblem(gram, SIZES, 0.0, Bias(1, 1, np.zeros(4))), "coefficients of the bias"),
        (lambda: solve_layered(t.problem, t.data, t.energy, np.full(3, 1.5)), "between 0 and 1"),
        (lambda: solve_layered(t.problem, np.full_like(t.data, np.nan), t.energy), "NaN"),
    ):
        with pytest.raises(InputError, match=why):
            call()
