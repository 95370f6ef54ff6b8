"""The method piece by piece, against the paper's equations read literally."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from mien.core import Examples, InputError
from mien.geometry.laplacian import cotangent_laplacian
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.range_of_motion.alignment import (
    Balance,
    alignment_problem,
    cross_expression_laplacian,
    local_support,
)
from mien.retargeting.range_of_motion.keys import key_expressions
from mien.retargeting.range_of_motion.method import marker_laplacian
from mien.retargeting.range_of_motion.similarity import contrast, similarity, trust_of
from mien.solve import solve_sylvester
from tests.retargeting.actors import at_rest, capture, face, pairs_of, points_on, weights
from tests.retargeting.literal import energies


def test_similarity_is_the_cosine_of_displacements(rng: np.random.Generator) -> None:
    actor, shapes = rng.normal(size=(7, 5, 3)), rng.normal(size=(4, 5, 3))
    found = similarity(actor, shapes)
    for k in range(4):
        for f in range(7):
            a, s = actor[f].ravel(), shapes[k].ravel()
            assert found.correlation[k, f] == pytest.approx(a @ s / np.linalg.norm(a) / np.linalg.norm(s))


def test_what_does_not_move_is_like_nothing(rng: np.random.Generator) -> None:
    actor, shapes = rng.normal(size=(3, 5, 3)), rng.normal(size=(4, 5, 3))
    actor[1], shapes[2] = 0, 0
    found = similarity(actor, shapes)
    assert not found.correlation[:, 1].any()
    assert not found.correlation[2].any()


def test_contrast_is_equation_7() -> None:
    c = np.linspace(0, 1, 9)
    assert np.allclose(contrast(c, 15), np.exp(15 * c) / (np.exp(7.5) + np.exp(15 * c)))
    assert contrast(np.array(0.5), 15) == 0.5


def test_trust_follows_equation_6_written_as_loops(rng: np.random.Generator) -> None:
    shapes = rng.normal(size=(6, 8, 3)) * rng.uniform(0.2, 2, (6, 1, 1))
    size = np.linalg.norm(shapes, axis=(1, 2))
    unit = shapes.reshape(6, -1) / size[:, None]
    between = unit @ unit.T
    order = sorted(range(6), key=lambda k: -size[k])
    sums = [sum(max(0.0, between[order[k], order[j]]) for j in range(k)) for k in range(6)]
    expected = {order[k]: 1 - sums[k] / max(sums) for k in range(6)}
    assert np.allclose(trust_of(between, size), [expected[k] for k in range(6)])
    assert trust_of(between, size)[order[0]] == 1


def test_enhanced_similarity_is_equation_8(rng: np.random.Generator) -> None:
    found = similarity(rng.normal(size=(9, 5, 3)), rng.normal(size=(4, 5, 3)))
    positive = np.maximum(found.correlation, 0)
    t = found.trust[:, None]
    assert np.allclose(
        found.enhanced, (1 - t) * positive + t * np.exp(15 * positive) / (np.exp(7.5) + np.exp(15 * positive))
    )


def test_key_expressions_are_the_peaks_of_the_sum() -> None:
    t = np.arange(200.0)
    rows = np.stack([np.exp(-(((t - c) / 8) ** 2)) for c in (30, 90, 160)])
    assert key_expressions(rows).frames.tolist() == [30, 90, 160]


def test_flickering_peaks_can_be_left_out(rng: np.random.Generator) -> None:
    t = np.arange(400.0)
    rows = np.stack([np.exp(-(((t - c) / 20) ** 2)) for c in (100, 300)]) + rng.uniform(0, 0.01, (2, 400))
    assert len(key_expressions(rows).frames) > 20
    assert np.abs(key_expressions(rows, prominence=0.3).frames - [100, 300]).max() < 5


def test_a_constant_take_still_has_one_key() -> None:
    assert len(key_expressions(np.ones((3, 10))).frames) == 1


def problem_of(rng: np.random.Generator) -> tuple:
    k, e, m = 4, 6, 12
    neutral = rng.normal(size=(m, 3)) + [0, 0, 3]
    shapes, guess = rng.normal(size=(2, k, m, 3))
    keys, alike = rng.normal(size=(e, m, 3)), rng.uniform(0, 1, (k, e))
    between = similarity(keys, shapes).between
    return alike, keys, shapes, guess, between, marker_laplacian(neutral)


def test_the_aligned_shapes_minimise_the_energy_as_printed(rng: np.random.Generator) -> None:
    alike, keys, shapes, guess, between, laplacian = problem_of(rng)
    balance = Balance(mesh=0.3, cross=0.7)

    def energy(flat: np.ndarray) -> float:
        parts = energies(flat.reshape(shapes.shape), alike, keys, shapes, guess, between, laplacian)
        return parts["match"] + balance.mesh * parts["mesh"] + balance.cross * parts["cross"]

    problem = alignment_problem(alike, keys, shapes, guess, between, laplacian, balance)
    best = solve_sylvester(problem.left, problem.right, problem.load, problem.guess).P.ravel()
    assert np.abs(approx_fprime(best, energy, 1e-6)).max() < 1e-4
    for _ in range(20):
        assert energy(best + 0.01 * rng.normal(size=best.shape)) > energy(best)


def test_the_normal_equations_are_half_the_gradient_everywhere(rng: np.random.Generator) -> None:
    alike, keys, shapes, guess, between, laplacian = problem_of(rng)
    balance, point = Balance(0.2, 0.5), rng.normal(size=shapes.shape)
    problem = alignment_problem(alike, keys, shapes, guess, between, laplacian, balance)

    def energy(flat: np.ndarray) -> float:
        parts = energies(flat.reshape(shapes.shape), alike, keys, shapes, guess, between, laplacian)
        return parts["match"] + balance.mesh * parts["mesh"] + balance.cross * parts["cross"]

    expected = approx_fprime(point.ravel(), energy, 1e-6).reshape(shapes.shape) / 2
    mine = np.einsum("kl,lmc->kmc", problem.left, point) + np.einsum("kmc,mn->knc", point, problem.right) - problem.load
    assert np.abs(mine - expected).max() < 1e-4


def test_the_cross_expression_laplacian_is_equation_12(rng: np.random.Generator) -> None:
    shapes = rng.normal(size=(5, 7, 3))
    between = similarity(shapes, shapes).between
    for k in range(5):
        others = [j for j in range(5) if j != k]
        total = sum(abs(between[k, j]) for j in others)
        expected = sum(between[k, j] * (shapes[j] - shapes[k]) for j in others) / total
        assert np.allclose(np.einsum("l,lmc->mc", cross_expression_laplacian(between)[k], shapes), expected)


def test_local_support_is_one_where_a_shape_moves_most(rng: np.random.Generator) -> None:
    shapes = rng.normal(size=(3, 9, 3))
    shapes[1] = 0
    support = local_support(shapes)
    assert support[0].max() == support[2].max() == 1
    assert not support[1].any()


def test_a_shape_without_any_similar_frame_keeps_the_guess(rng: np.random.Generator) -> None:
    alike, keys, shapes, guess, between, laplacian = problem_of(rng)
    alike[2] = 0
    problem = alignment_problem(alike, keys, shapes, guess, between, laplacian, Balance(0.3, 0.0))
    solution = solve_sylvester(problem.left, problem.right, problem.load, problem.guess)
    assert solution.null_rank > 0
    assert np.allclose(solution.P[2], guess[2], atol=1e-8)


def test_an_actor_with_a_larger_range_gets_larger_shapes() -> None:
    """The paper's point: the actor's own shapes grow with the actor's movements."""
    rig = face()
    points = points_on(rig)
    small, large = (
        RangeOfMotion(mesh=0.01, cross=0.1, keep=0.0).fit(
            rig,
            capture(rig, weights() * strength, points),
            pairs_of(points),
            neutral=at_rest(rig, points),
            head_moves=False,
        )
        for strength in (0.7, 1.4)
    )
    growth = ((large.shapes - small.shapes) * small.alignment.original).sum(axis=(1, 2))
    assert (growth > 0).all()


def test_examples_replace_the_similarities_of_their_shapes() -> None:
    rig, points = face(), points_on(face())
    take = capture(rig, weights(), points)
    examples = Examples(np.array([33, 34]), ("jawOpen",), np.array([[1.0], [0.5]]))
    alignment = RangeOfMotion().fit(rig, take, pairs_of(points), examples=examples).alignment
    row = alignment.similarity.enhanced[0]
    assert np.flatnonzero(row).tolist() == [33, 34]
    assert row[34] == 0.5
    assert {33, 34} <= set(alignment.keys.frames)


def test_examples_of_unknown_shapes_or_frames_are_refused() -> None:
    rig, points = face(), points_on(face())
    take = capture(rig, weights(), points)
    for frame, name, why in ((10, "jawOpne", "jawOpen"), (9999, "jawOpen", "frame 9999")):
        with pytest.raises(InputError, match=why):
            RangeOfMotion().fit(
                rig, take, pairs_of(points), examples=Examples(np.array([frame]), (name,), np.array([[1.0]]))
            )


def test_the_marker_laplacian_knows_constants_only(rng: np.random.Generator) -> None:
    neutral = points_on(face()).of(face().neutral.vertices)
    laplacian = marker_laplacian(neutral)
    assert np.abs(laplacian @ np.ones(len(neutral))).max() < 1e-12
    assert cotangent_laplacian(neutral, np.empty((0, 3), np.int64)).nnz == 0
