"""Shapes from examples: each step against a reference, the energy never rises, and labels are heard."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import lsqr

from mien.core import Examples, InputError
from mien.core.arrays import Floats
from mien.retargeting import make_method
from mien.retargeting.example_based.choose import distinct_frames
from mien.retargeting.example_based.edges import Edges, marker_edges
from mien.retargeting.example_based.rigging import Rigging, Schedule, rig_by_example
from tests.retargeting.actors import SHAPES, at_rest, capture, face, pairs_of, points_on, weights


def stretched(rng: np.random.Generator, count: int = 4, side: int = 4) -> tuple[Edges, Floats, Floats]:
    """A few markers, local shapes of a generic rig, and an actor's, each shape of another strength."""
    u, v = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    neutral = np.stack([u, v, -0.1 * (u - 1.5) ** 2 - 0.1 * (v - 1.5) ** 2], axis=1).astype(float)
    near = np.exp(-((neutral[:, :2] - rng.uniform(0, side - 1, (count, 1, 2))) ** 2).sum(axis=2))
    generic = near[..., None] * rng.normal(size=(count, 1, 3))
    return marker_edges(neutral), generic, generic * rng.uniform(0.5, 1.8, (count, 1, 1))


def problem(rng: np.random.Generator, bound: float = np.inf) -> tuple[Rigging, Floats, Floats]:
    edges, generic, actor = stretched(rng)
    played = rng.uniform(0, 1, (8, 4)) * (rng.random((8, 4)) < 0.7)
    guess = np.clip(played + rng.normal(0, 0.05, played.shape), 0, None)
    limits = np.full(4, 0.0 if np.isfinite(bound) else -np.inf), np.full(4, bound)
    return Rigging(edges, np.tensordot(played, actor, axes=1), generic, guess, *limits), actor, played


def test_the_shapes_are_scipys_least_squares(rng: np.random.Generator) -> None:
    posed, _, _ = problem(rng)
    found = posed.shapes(posed.generic, posed.guess, 0.3)
    dense = posed.edges.differences.toarray()
    fit = np.kron(posed.guess, dense)
    hold = np.sqrt(0.3 * posed.resistance).ravel()[:, None] * np.kron(np.eye(4), dense)
    for axis in range(3):
        wanted = np.concatenate(
            [
                (posed.examples[..., axis] @ dense.T).ravel(),
                np.sqrt(0.3 * posed.resistance).ravel() * (posed.generic[..., axis] @ dense.T).ravel(),
            ]
        )
        reference = lsqr(np.concatenate([fit, hold]), wanted, atol=1e-14, btol=1e-14, iter_lim=5000)[0]
        assert np.abs(found[..., axis].ravel() - reference).max() < 1e-6


def test_the_weights_are_the_dense_least_squares(rng: np.random.Generator) -> None:
    posed, _, _ = problem(rng)
    along = posed.edges.of(posed.generic).reshape(4, -1).T
    pull = np.sqrt(0.2 * posed.size)
    system = np.concatenate([along, pull * np.eye(4)])
    wanted = np.concatenate([posed.edges.of(posed.examples).reshape(8, -1).T, pull * posed.guess.T])
    reference = np.linalg.lstsq(system, wanted, rcond=None)[0].T
    assert np.abs(posed.weights(posed.generic, 0.2) - reference).max() < 1e-8


@pytest.mark.parametrize("bound", [np.inf, 1.0])
def test_no_step_raises_the_energy(rng: np.random.Generator, bound: float) -> None:
    posed, _, _ = problem(rng, bound)
    found = rig_by_example(posed, Schedule())
    energies = np.array(found.energies)
    assert len(energies) == 21
    assert (np.diff(energies) <= 1e-9 * energies[0]).all()
    assert energies[-1] < 0.2 * energies[0]
    if np.isfinite(bound):
        assert found.weights.min() >= 0
        assert found.weights.max() <= bound


def test_the_energy_is_what_its_formula_says(rng: np.random.Generator) -> None:
    posed, actor, played = problem(rng)
    dense = posed.edges.differences.toarray()
    total = 0.0
    for j in range(8):
        total += ((dense @ (posed.examples[j] - sum(played[j, i] * actor[i] for i in range(4)))) ** 2).sum()
    for i in range(4):
        change = dense @ (actor[i] - posed.generic[i])
        size = np.linalg.norm(dense @ posed.generic[i], axis=1)
        total += 0.3 * (((1 + size) / (0.1 + size)) ** 2 * (change**2).sum(axis=1)).sum()
    size = np.mean([((dense @ posed.generic[i]) ** 2).sum() for i in range(4)])
    total += 0.2 * size * ((played - posed.guess) ** 2).sum()
    assert posed.energy(actor, played, 0.3, 0.2) == pytest.approx(total)


def test_shapes_move_towards_the_actors_where_examples_show_them(rng: np.random.Generator) -> None:
    posed, actor, _ = problem(rng)
    found = rig_by_example(posed, Schedule()).shapes
    off = [np.linalg.norm(shapes - actor) for shapes in (found, posed.generic)]
    assert off[0] < 0.8 * off[1]


def test_with_the_true_weights_and_no_regularisation_the_shapes_are_the_actors(rng: np.random.Generator) -> None:
    posed, actor, played = problem(rng)
    assert np.abs(posed.shapes(posed.generic, played, 1e-7) - actor).max() < 1e-3


def test_a_shape_that_no_example_shows_stays_the_generic_one(rng: np.random.Generator) -> None:
    posed, _, played = problem(rng, 1.0)
    played[:, 2] = 0
    quiet = Rigging(
        posed.edges,
        np.tensordot(played, posed.generic * 1.3, axes=1),
        posed.generic,
        played,
        np.zeros(4),
        np.array([1, 1, 0, 1.0]),
    )
    found = rig_by_example(quiet, Schedule())
    assert np.abs(found.shapes[2] - posed.generic[2]).max() < 1e-6
    assert np.abs(found.shapes[0] - posed.generic[0]).max() > 0.01


def test_every_marker_has_an_edge_to_the_skull_and_edges_have_one_transpose(rng: np.random.Generator) -> None:
    edges, generic, _ = stretched(rng)
    ones = edges.of(np.ones((1, 16, 3)))[0]
    assert (ones[-16:] == 1).all()
    assert not ones[:-16].any()
    other = rng.normal(size=edges.of(generic).shape)
    assert (edges.of(generic) * other).sum() == pytest.approx((generic * edges.back(other)).sum())


def test_examples_are_distinct_whole_frames_and_always_the_same() -> None:
    take = np.tensordot(weights(), face().blendshapes.deltas[:, ::12], axes=1) * 100
    take[:40, 3] = np.nan
    frames = distinct_frames(take, 7)
    assert np.array_equal(frames, distinct_frames(take, 7))
    assert len(frames) == 7
    assert (np.diff(frames) > 0).all()
    assert frames.min() >= 40
    shown = take[frames].reshape(7, -1)
    apart = np.linalg.norm(shown[:, None] - shown[None], axis=2) + 100 * np.eye(7)
    assert apart.min() > 0.05
    assert np.array_equal(distinct_frames(take[38:43], 7), [2, 3, 4])


def test_labels_are_the_examples_and_their_first_weights() -> None:
    rig, points = face(), points_on(face())
    take = capture(rig, weights(), points)
    known = {"neutral": at_rest(rig, points), "head_moves": False}
    frame = int(np.argmax(weights()[:, 5]))
    label = Examples(np.array([frame]), ("browUp",), np.array([[0.5]]))
    firmly = make_method("example-based", {"beta": 0.01, "gamma": 1000.0})
    told = firmly.fit(rig, take, pairs_of(points), examples=label, **known)
    brow = SHAPES.index("browUp")
    true = rig.blendshapes.deltas[brow][np.asarray(points.corners)[:, 0]]
    strength = np.linalg.norm(told.shapes[brow]) * told.centimetre / np.linalg.norm(true)
    assert 1.7 < strength < 2.1
    assert any(f"1 frames of the training take are the examples: {frame}" in note.message for note in told.notes)
    blind = take.points.copy()
    blind[frame, 2] = np.nan
    for labels, points_seen, why in (
        (Examples(np.array([frame]), ("browup",), np.array([[1.0]])), take.points, "browUp"),
        (Examples(np.array([999]), ("browUp",), np.array([[1.0]])), take.points, "outside"),
    ):
        with pytest.raises(InputError, match=why):
            make_method("example-based", {"first_weights": "rbf"}).fit(
                rig, type(take)(take.names, points_seen, take.fps), pairs_of(points), examples=labels, **known
            )


def test_schedules_fall_and_their_limits_are_checked() -> None:
    assert Schedule().at(0) == (0.5, 10.0)
    assert Schedule().at(9) == pytest.approx((0.1, 1.0))
    assert Schedule(iterations=1).at(0) == (0.5, 10.0)
    for settings in ({"beta_left": 1.5}, {"iterations": 0}, {"gamma": -1.0}, {"count": 0}):
        with pytest.raises(InputError, match="must be"):
            make_method("example-based", settings)
