"""The generic rig's word on the character's shapes, and how far it is listened to."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mien.capture import Neutral, trace
from mien.core import Clip, Correspondence, Rig
from mien.evaluate.cases import across
from mien.geometry.templates import template_shapes
from mien.library.generic import generic_rig
from mien.retargeting.prepare import Prepared, prepare
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.range_of_motion.refit import Refit, Take
from mien.retargeting.range_of_motion.second_opinion import (
    heard,
    mixed,
    same_shapes,
    second_opinion,
)
from tests.retargeting.actors import at_rest, capture, face, pairs_of, points_on, weights
from tests.retargeting.test_refit import acting, alike, distorted

NAMES = ("jawOpen", "mouthSmileLeft", "mouthSmileRight", "browInnerUp", "eyeBlinkLeft", "cheekPuff")


@cache
def shaped() -> Rig:
    """The generic rig with some of its own templates as shapes."""
    generic = generic_rig()
    return replace(generic, blendshapes=template_shapes(generic, NAMES))


@cache
def beside(character: Rig) -> Prepared:
    """The rig acting for itself, or for a character on its mesh."""
    actor = shaped()
    pairs: Correspondence = across(actor, actor, 60)
    assert pairs.source is not None
    values = np.random.default_rng(2).uniform(0, 1, (80, len(NAMES)))
    take = trace(actor, Clip(NAMES, values, 60.0), pairs.source, pairs.names)
    rest = Neutral(pairs.source.of(actor.neutral.vertices), None, float("nan"))
    return prepare(character, take, pairs, neutral=rest, head_moves=False)


def test_a_shape_has_the_word_of_its_namesake_in_any_spelling_or_of_its_two_halves() -> None:
    same = same_shapes(["Jaw_Open", "mouthSmile", "browInnerUpLeft", "gill"], NAMES)
    assert [list(np.flatnonzero(row)) for row in same] == [[0], [1, 2], [], []]


def test_a_blink_stays_the_character_s_own() -> None:
    assert not same_shapes(["Eye_Blink.L", "blink_R"], NAMES).any()


def test_the_generic_rig_is_of_its_own_opinion() -> None:
    prepared = beside(shaped())
    opinion, _ = second_opinion(shaped(), prepared)
    assert opinion is not None
    assert (alike(opinion, prepared.terms.deltas) > 0.99).all()


def test_an_opinion_has_the_size_of_the_character_s_shape() -> None:
    strong = replace(shaped(), blendshapes=replace(shaped().blendshapes, deltas=3 * shaped().blendshapes.deltas))
    prepared = beside(strong)
    opinion, _ = second_opinion(strong, prepared)
    assert opinion is not None
    sizes = [np.linalg.norm(each, axis=(1, 2)) for each in (opinion, prepared.terms.deltas)]
    assert sizes[0] == pytest.approx(sizes[1])


def test_shapes_the_generic_rig_does_not_know_are_left_as_they_are() -> None:
    names = (*NAMES[:3], "gill", "antenna", "cheekPuff")
    other = replace(shaped(), blendshapes=replace(shaped().blendshapes, names=names))
    prepared = beside(other)
    opinion, _ = second_opinion(other, prepared)
    assert opinion is not None
    assert np.array_equal(opinion[3:5], prepared.terms.deltas[3:5])


def test_there_is_no_opinion_without_landmarks_or_without_a_name_in_common() -> None:
    bare = replace(shaped(), landmarks={})
    strange = replace(shaped(), blendshapes=replace(shaped().blendshapes, names=tuple("abcdef")))
    opinion, notes = second_opinion(bare, beside(bare))
    assert opinion is None
    assert [note.code for note in notes] == ["no-second-opinion"]
    assert "landmarks" in notes[0].message
    assert second_opinion(strange, beside(strange)) == (None, ())


def test_half_and_half_lies_between_and_keeps_the_size() -> None:
    own = face().blendshapes.deltas[:, ::7]
    other = distorted(own, np.random.default_rng(4))
    half = mixed(own, other, np.full(len(own), 0.5))
    assert (alike(half, own) > alike(other, own)).all()
    assert np.linalg.norm(half, axis=(1, 2)) == pytest.approx(np.linalg.norm(own, axis=(1, 2)))


def listened(own_is_right: bool) -> tuple[Take, np.ndarray, np.ndarray, np.ndarray, dict[str, float]]:
    """A take, the true shapes, wrong ones, and what is made of both."""
    take, true = acting(weights(), noise=1e-5)
    wrong = distorted(true, np.random.default_rng(7))
    own, opinion = (true, wrong) if own_is_right else (wrong, true)
    found, shares = heard(own, opinion, take, Refit(), full_range=False)
    return take, true, wrong, found, shares


def test_a_character_that_has_it_right_is_left_alone() -> None:
    _, true, _, found, shares = listened(own_is_right=True)
    assert set(shares.values()) == {0.0}
    assert np.array_equal(found, mixed(true, true, np.zeros(len(true))))


def test_an_opinion_that_explains_the_take_better_is_followed() -> None:
    _, true, wrong, found, shares = listened(own_is_right=False)
    assert min(shares.values()) >= 0.5
    assert (alike(found, true) > alike(wrong, true)).all()


def test_the_report_says_how_much_was_heard_and_the_setting_turns_it_off() -> None:
    rig, points = face(), points_on(face())
    known = {"neutral": at_rest(rig, points), "head_moves": False}
    without = RangeOfMotion(second_opinion=False).fit(rig, capture(rig, weights(), points), pairs_of(points), **known)
    assert without.alignment.opinion == {}
    prepared = beside(shaped())
    asked = RangeOfMotion().align(prepared, shaped())
    assert set(asked.opinion) == {"brows", "cheeks", "eyes", "mouth"}
    assert RangeOfMotion(second_opinion=False).align(prepared, shaped()).opinion == {}
