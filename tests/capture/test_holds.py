"""Where the face is held: small movements and large ones, but no blink and no noise."""

from __future__ import annotations

import numpy as np
import pytest

from mien.capture.holds import Hold, find_holds, movement

AWAY = 0.1
HELD = ((2.0, 3.5), (5.0, 6.0), (7.5, 8.5))


def take_of(fps: float, noise_cm: float = 0.02) -> np.ndarray:
    """Ten seconds of 60 points: a jaw by 3 cm, two lids by 1.5 mm, cheeks by 8 mm, and a blink by 1 cm."""
    rng = np.random.default_rng(2)
    t = np.arange(round(10 * fps)) / fps
    take = rng.normal(0, noise_cm, (len(t), 60, 3))
    moved = ((slice(20), -3.0), (slice(20, 22), 0.15), (slice(30, 40), 0.8))
    for (start, end), (points, far) in zip(HELD, moved, strict=True):
        take[(t >= start) & (t < end), points, 1] += far
    take[(t >= 4.2) & (t < 4.4), 20:24, 1] -= 1.0
    return take


@pytest.mark.parametrize("fps", [24.0, 60.0, 120.0])
def test_large_and_small_expressions_are_found_and_a_blink_is_not(fps: float) -> None:
    found = find_holds(movement(take_of(fps), fps), fps, AWAY)
    assert len(found) == len(HELD)
    for hold, (start, end) in zip(found, HELD, strict=True):
        assert hold.first / fps == pytest.approx(start, abs=0.1)
        assert hold.last / fps == pytest.approx(end, abs=0.1)
        assert start * fps < hold.plateau[0] <= hold.plateau[-1] < end * fps


def test_a_face_at_rest_holds_nothing() -> None:
    rest = np.random.default_rng(1).normal(0, 0.02, (300, 60, 3))
    assert find_holds(movement(rest, 30.0), 30.0, AWAY) == ()


def test_points_that_are_not_seen_hide_no_hold() -> None:
    take = take_of(30.0)
    whole = find_holds(movement(take, 30.0), 30.0, AWAY)
    lost = np.random.default_rng(3).random(take.shape[:2]) < 0.05
    take[lost] = np.nan
    take[:, 50:] = np.nan
    found = find_holds(movement(take, 30.0), 30.0, AWAY)
    ends = [np.array([(hold.first, hold.last) for hold in each]) for each in (found, whole)]
    assert ends[0] == pytest.approx(ends[1], abs=2)


def test_the_face_may_come_close_to_rest_within_a_hold() -> None:
    moved = np.repeat([0.0, 0.2, 0.08, 0.2, 0.0, 0.08, 0.0], 30)
    assert find_holds(moved, 30.0, AWAY) == (Hold(30, 119),)


def test_holds_overlap_and_contain_each_other() -> None:
    outer, inner, after = Hold(0, 9), Hold(3, 9), Hold(10, 12)
    assert outer.contains(inner)
    assert not inner.contains(outer)
    assert not outer.contains(outer)
    assert outer.overlaps(inner)
    assert not outer.overlaps(after)
