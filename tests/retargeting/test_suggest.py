"""Suggestions: what a label would gain is what it does gain."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import InputError
from mien.retargeting.samples import Samples
from mien.retargeting.suggest import suggest


def made(rng: np.random.Generator, unlabelled: int = 60) -> Samples:
    basis = rng.normal(size=(6, 30)) * np.array([4, 2, 1, 0.5, 0.3, 0.2])[:, None]
    z = rng.normal(size=(5 + unlabelled, 6))
    y = z @ rng.normal(size=(6, 4))
    x = z @ basis
    return Samples(x[:5], y[:5], x[5:], np.zeros((0, 4)))


def test_gains_fall_and_frames_differ(rng: np.random.Generator) -> None:
    found = suggest(made(rng), 20)
    assert len(set(found.frames.tolist())) == 20
    assert (np.diff(found.gain) <= 1e-12).all()
    assert found.gain.sum() <= 1 + 1e-12


def test_the_values_of_the_labels_do_not_matter_only_where_they_are(rng: np.random.Generator) -> None:
    given = made(rng)
    other = Samples(given.X_labelled, given.Y_labelled[::-1] * 7, given.X_only, given.Y_only)
    assert (suggest(given, 8).frames == suggest(other, 8).frames).all()


def test_units_of_the_source_do_not_matter(rng: np.random.Generator) -> None:
    given = made(rng)
    small = Samples(given.X_labelled / 1000, given.Y_labelled, given.X_only / 1000, given.Y_only)
    assert (suggest(given, 8).frames == suggest(small, 8).frames).all()


def test_suggested_labels_leave_less_doubt_than_random_ones(rng: np.random.Generator) -> None:
    given = made(rng)
    mine = suggest(given, 6)
    doubts = []
    for _ in range(20):
        drawn = rng.permutation(60)[:6]
        x = np.concatenate([given.X_labelled, given.X_only[drawn]])
        rest = np.setdiff1d(np.arange(60), drawn)
        doubts.append(suggest(Samples(x, np.zeros((11, 1)), given.X_only[rest], np.zeros((0, 1))), 1).doubt)
    assert mine.doubt < min(doubts) * 60 / 53


def test_more_frames_than_there_are_is_refused(rng: np.random.Generator) -> None:
    with pytest.raises(InputError, match=r"ask for 1 … 60"):
        suggest(made(rng), 61)
