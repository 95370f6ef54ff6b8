"""Whole clips: movements are matched, gaps are bridged, and the past alone comes close."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import lsq_linear
from scipy.sparse.linalg import spsolve

from mien.core import InputError
from mien.core.arrays import Floats
from mien.retargeting import make_method
from mien.retargeting.energy import FrameSolver, frame_solver
from mien.retargeting.movement import MovementSolver
from mien.retargeting.saved import packed, unpacked
from mien.retargeting.settings import SolveSettings
from mien.retargeting.spacetime import SpacetimeRetargeter
from tests.retargeting.actors import capture, face, pairs_of, points_on, weights

PLAIN = {"sparsity": 0.0, "damping": 0.0, "smooth": 0.0, "unseen": False, "off": ()}
FPS = 60.0


def solver(rng: np.random.Generator, count: int = 4, markers: int = 7, **settings: object) -> FrameSolver:
    """A solver of random shapes."""
    shapes = rng.normal(size=(count, markers, 3))
    names = [f"s{k}" for k in range(count)]
    chosen = SolveSettings(**{**PLAIN, **settings})  # type: ignore[arg-type]
    return frame_solver(shapes, names, np.zeros((count, count)), rng.uniform(0.5, 1, markers), chosen)


def stacked(frame: FrameSolver, take: Floats, velocity: float) -> tuple[Floats, Floats]:
    """The least squares that a clip with damping and smoothness is, row by row: an independent reference."""
    frames, markers, _ = take.shape
    count, settings = len(frame.shapes), frame.settings
    flat = frame.shapes.reshape(count, -1).T
    seen = ~np.isnan(take[..., 0])
    rows, data = [], []

    def add(row: Floats, values: Floats, weight: Floats) -> None:
        rows.append(row * np.sqrt(weight)[:, None])
        data.append(np.nan_to_num(values) * np.sqrt(weight))

    def repeated(use: np.ndarray) -> Floats:
        weight = np.where(use, frame.confidence, 0.0)
        return np.repeat(weight / max(weight.sum(), 1e-12), 3)

    movement = (frame.shapes**2).sum(axis=2) @ frame.confidence / frame.confidence.sum()
    rate = (FPS / 30) ** 2
    for f in range(frames):
        block = np.zeros((3 * markers, frames * count))
        block[:, f * count : (f + 1) * count] = flat
        add(block, take[f].ravel(), repeated(seen[f]))
        quiet = np.zeros((count, frames * count))
        quiet[:, f * count : (f + 1) * count] = np.eye(count)
        add(quiet, np.zeros(count), settings.damping * movement)
        if f + 1 < frames:
            step = np.zeros_like(block)
            step[:, f * count : (f + 1) * count] = -flat
            step[:, (f + 1) * count : (f + 2) * count] = flat
            add(step, (take[f + 1] - take[f]).ravel(), velocity * rate * repeated(seen[f] & seen[f + 1]))
            change = np.zeros_like(quiet)
            change[:, f * count : (f + 1) * count] = -np.eye(count)
            change[:, (f + 1) * count : (f + 2) * count] = np.eye(count)
            add(change, np.zeros(count), np.full(count, settings.smooth * rate))
    return np.concatenate(rows), np.concatenate(data)


@pytest.mark.parametrize("gaps", [False, True])
@pytest.mark.parametrize("extra", [{}, {"damping": 0.01, "smooth": 0.02}])
def test_unbounded_clips_are_scipys_sparse_least_squares(
    rng: np.random.Generator, gaps: bool, extra: dict[str, float]
) -> None:
    frame = solver(rng, bounds=None, **extra)
    take = rng.normal(size=(12, 7, 3))
    if gaps:
        take[3:5, 2] = np.nan
        take[7, :3] = np.nan
    found, kkt = MovementSolver(frame, 3.0).clip(take, FPS)
    root, data = stacked(frame, take, 3.0)
    system = sparse.csc_matrix(root)
    reference = spsolve(sparse.csc_matrix(system.T @ system), system.T @ data).reshape(found.shape)
    assert np.abs(found - reference).max() < 1e-8
    assert kkt < 1e-8


def test_bounded_clips_are_scipys_bounded_least_squares(rng: np.random.Generator) -> None:
    frame = solver(rng, bounds=(0.0, 0.2), damping=0.01, smooth=0.02)
    take = rng.normal(size=(12, 7, 3))
    take[3:5, 2] = np.nan
    found, kkt = MovementSolver(frame, 3.0).clip(take, FPS)
    root, data = stacked(frame, take, 3.0)
    reference = lsq_linear(root, data, bounds=(0.0, 0.2), tol=1e-14, max_iter=1000).x.reshape(found.shape)
    assert np.abs(found - reference).max() < 1e-6
    assert kkt < 1e-8
    assert 0.1 < (found == 0).mean() < 0.9


def test_without_movements_each_frame_is_solved_by_itself(rng: np.random.Generator) -> None:
    frame = solver(rng, bounds=(0.0, 1.0))
    take = rng.normal(size=(20, 7, 3))
    together, _ = MovementSolver(frame, 0.0).clip(take, FPS)
    alone, _ = frame.batch(take, FPS)
    assert np.abs(together - alone).max() < 1e-6


def test_strong_movements_follow_the_actor_through_a_constant_error(rng: np.random.Generator) -> None:
    """A marker stuck on in the wrong place pushes positions about, and movements not at all."""
    frame = solver(rng, bounds=None)
    truth = 0.5 + 0.4 * np.sin(np.linspace(0, 6, 80)[:, None] + np.arange(4))
    take = np.tensordot(truth, frame.shapes, axes=1)
    take[40:] += 0.5 * rng.normal(size=(7, 3))
    errors = []
    for velocity in (0.0, 10.0):
        found, _ = MovementSolver(frame, velocity).clip(take, FPS)
        moved = np.diff(found, axis=0) - np.diff(truth, axis=0)
        errors.append(np.abs(np.delete(moved, 39, axis=0)).max())
    assert errors[0] < 1e-9  # within a half nothing is off, whatever is done
    assert errors[1] < 0.05
    jumps = [np.abs(np.diff(MovementSolver(frame, v).clip(take, FPS)[0], axis=0)[39]).max() for v in (0.0, 10.0)]
    assert np.isfinite(jumps).all()


def test_a_gap_is_what_the_frames_in_it_would_come_to_if_they_moved_freely(rng: np.random.Generator) -> None:
    """A blind stretch has one movement across it: as many equal steps as it has frames, in the limit of smoothness."""
    frame = solver(rng, bounds=None, damping=1e-9)
    line = np.linspace(0, 1, 11)[:, None] * np.ones(4)
    take = np.tensordot(line, frame.shapes, axes=1)
    take[4:8] = np.nan
    found, _ = MovementSolver(frame, 1.0).clip(take, FPS)
    assert np.abs(found - line).max() < 1e-6
    ends = take.copy()
    ends[:2] = np.nan
    held, _ = MovementSolver(frame, 1.0).clip(ends, FPS)
    assert np.array_equal(held[0], held[2])


def test_a_take_that_sees_nothing_is_at_rest(rng: np.random.Generator) -> None:
    found, kkt = MovementSolver(solver(rng), 1.0).clip(np.full((5, 7, 3), np.nan), FPS)
    assert not found.any()
    assert kkt == 0


def test_a_step_minimises_the_clips_energy_with_the_past_held(rng: np.random.Generator) -> None:
    frame = solver(rng, bounds=None, damping=0.01, smooth=0.02)
    take = rng.normal(size=(2, 7, 3))
    take[0, 1] = np.nan
    movement = MovementSolver(frame, 2.0)
    first, left = movement.step(take[0], None, None, FPS)
    second, _ = movement.step(take[1], first, left, FPS)
    root, data = stacked(frame, take, 2.0)
    data = data - root[:, :4] @ first
    reference = np.linalg.lstsq(root[:, 4:], data, rcond=None)[0]
    assert np.abs(second - reference).max() < 1e-8


def fitted(**settings: object) -> SpacetimeRetargeter:
    rig = face()
    take = capture(rig, weights(), points_on(rig), head=True, noise=1e-4)
    return make_method("spacetime", settings).fit(rig, take, pairs_of(points_on(rig)))  # type: ignore[return-value]


def test_a_saved_model_gives_the_same_weights_whole_and_step_by_step() -> None:
    before = fitted(velocity=2.5)
    after = unpacked(*packed(before))
    performance = capture(face(), weights(60), points_on(face()), head=True)
    assert isinstance(after, SpacetimeRetargeter)
    assert np.array_equal(before.retarget(performance)[0].values, after.retarget(performance)[0].values)
    one, other = (r.step(r.start(), performance.points[20])[1] for r in (before, after))
    assert np.array_equal(one, other)


def test_frames_that_see_nothing_are_said_to_be_interpolated() -> None:
    performance = capture(face(), weights(60), points_on(face()))
    points = performance.points.copy()
    points[20:24] = np.nan
    clip, report = fitted().retarget(replace(performance, points=points))
    assert any(note.code == "frames-held" and "interpolated" in note.message for note in report.notes)
    assert np.abs(np.diff(clip.values[19:25], 2, axis=0)).max() < 1e-12


def test_shapes_can_be_the_warps_or_the_alignments() -> None:
    kinds = [fitted(shapes=kind).shapes for kind in ("range-of-motion", "alignment", "rbf")]
    assert all(np.abs(a - b).max() > 1e-3 for a, b in ((kinds[0], kinds[1]), (kinds[0], kinds[2])))
    with pytest.raises(InputError, match="range-of-motion"):
        make_method("spacetime", {"shapes": "sculpted"})


def test_shapes_that_exclude_each_other_are_refused_in_words() -> None:
    with pytest.raises(InputError, match="all frames at once"):
        make_method("spacetime", {"exclusive": "smile_L:smile_R"})
    with pytest.raises(InputError, match="velocity"):
        make_method("spacetime", {"velocity": "-1"})


def test_a_long_take_solved_in_spans_is_the_take_solved_at_once(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    frame = solver(rng, smooth=0.01, bounds=(0.0, 1.0))
    times = np.linspace(0, 20, 400)[:, None]
    curves = np.clip(np.sin(times + np.arange(len(frame.shapes))), 0, 1)
    take = np.tensordot(curves, frame.shapes, axes=1) + rng.normal(0, 0.05, (400, *frame.shapes.shape[1:]))
    take[130:150] = np.nan
    at_once, _ = MovementSolver(frame, 0.0).clip(take, FPS)
    monkeypatch.setattr("mien.retargeting.movement.SPAN", 90)
    monkeypatch.setattr("mien.retargeting.movement.SHARED", 30)
    in_spans, residual = MovementSolver(frame, 0.0).clip(take, FPS)
    assert residual <= 1e-8
    assert 0 < np.abs(in_spans - at_once).max() < 1e-3
