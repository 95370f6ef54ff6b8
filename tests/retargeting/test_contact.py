"""Lids and lips that touch in the actor touch in the character."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from mien.core import Blendshapes, InputError, Markers, Rig, SurfacePoints
from mien.retargeting import make_method
from mien.retargeting.contact import Contacts
from mien.retargeting.saved import packed, unpacked
from mien.retargeting.settings import SolveSettings
from mien.vocabularies.openings import LIDS, LIPS
from tests.retargeting.actors import CENTRES, at_rest, capture, face, pairs_of, points_on, weights

WEAK = 0.8
"""The actor's lids come this share of the way that the character's shapes would need to close."""


def lidded() -> Rig:
    """The small face with landmarks above and below its eyes and its mouth; a blink closes a gap of 9 mm."""
    rig = face()
    flat = rig.neutral.vertices[:, :2]
    landmarks = {}
    rows = [(pair, CENTRES[4] + [0.003 * i, 0]) for i, pair in enumerate(LIDS["right lids"])]
    rows += [(pair, CENTRES[3] + [0.003 * i, 0]) for i, pair in enumerate(LIDS["left lids"])]
    rows += [(pair, CENTRES[0] + [0.004 * (i - 1), 0.012]) for i, pair in enumerate(LIPS["lips"])]
    for (above, below), centre in rows:
        for number, rise in ((above, 0.002), (below, -0.010)):
            vertex = int(np.linalg.norm(flat - centre - [0, rise], axis=1).argmin())
            landmarks[f"ibug_{number}"] = SurfacePoints.at_vertices(np.array([vertex]))
    deltas = rig.blendshapes.deltas.copy()
    for k in (3, 4):
        deltas[k, flat[:, 1] < CENTRES[k, 1] - 0.004] = 0
    return replace(rig, landmarks=landmarks, blendshapes=Blendshapes(rig.blendshapes.names, deltas))


def captured(rig: Rig, values: np.ndarray) -> Markers:
    return capture(rig, values, points_on(rig, 144))


def fitted(rig: Rig, take: Markers, **settings: object) -> object:
    points = points_on(rig, 144)
    given = {"bounds": (0.0, 1.5), **settings}
    return make_method("rbf", given).fit(rig, take, pairs_of(points), neutral=at_rest(rig, points), head_moves=False)


def gap(rig: Rig, values: np.ndarray, name: str) -> np.ndarray:
    """How far apart the landmarks of an opening are, `(F,)` [cm]."""
    pairs = {**LIDS, **LIPS}[name]
    posed = rig.pose(values)
    apart = [rig.landmarks[f"ibug_{a}"].of(posed) - rig.landmarks[f"ibug_{b}"].of(posed) for a, b in pairs]
    return np.asarray(100 * np.concatenate(apart, axis=1)[..., 1].mean(axis=1))


def test_an_eye_that_closes_in_the_actor_closes_in_the_character() -> None:
    rig, values = lidded(), weights()
    values[:, 3:5] *= WEAK
    take = captured(rig, values)
    blink = values[:, 4].argmax()
    rest = gap(rig, np.zeros((1, 6)), "right lids")[0]
    plain, closing = (fitted(rig, take, contact=s).retarget(take)[0].values for s in (0.0, 1.0))
    before, after = (abs(gap(rig, found[[blink]], "right lids")[0]) for found in (plain, closing))
    assert before > 0.1 * rest
    assert after < 0.5 * before
    apart = values[:, 3:5].max(axis=1) < 0.3 * values[:, 3:5].max()
    np.testing.assert_array_equal(closing[apart][:, 3:5], plain[apart][:, 3:5])


def test_closed_is_0_at_rest_and_1_at_the_end_of_a_blink_and_unseen_lids_are_open() -> None:
    rig = lidded()
    take = captured(rig, weights())
    made = fitted(rig, take, contact=1.0)
    contacts: Contacts = made.contacts
    right = contacts.names.index("right lids")
    shown = weights()[:, 4]
    displaced = made.displacements(take.points)[0]
    closed, wanted = contacts.read(displaced)
    assert closed.shape == wanted.shape == (len(shown), len(contacts.names))
    assert closed[shown.argmax(), right] == 1
    assert wanted[shown.argmax(), right] < 0.01 * contacts.rest[right]
    assert (closed[shown < 0.4 * shown.max(), right] == 0).all()
    hidden = displaced.copy()
    hidden[:, contacts.reading[right].any(axis=1)] = np.nan
    assert not contacts.read(hidden)[0][:, right].any()


def opened(parts: bool, rng: np.random.Generator) -> Contacts:
    """One opening of eight shapes, read straight from one marker: 0.9 cm at rest."""
    opening = rng.normal(size=8)
    ease = rng.uniform(0.1, 2, 8)
    reading = np.zeros((1, 1, 3))
    reading[0, 0, 1] = 1
    begin, full, shut, follow, rest = (np.array([value]) for value in (-0.3, -0.5, -0.8, 0.9 / 0.8, 0.9))
    shares = (opening[None], (ease * opening)[None])
    return Contacts(("it",), reading, begin, full, shut, follow, np.array([parts]), rest, *shares)


def read_as(read: np.ndarray) -> np.ndarray:
    """A take `(F, 1, 3)` in which this is read."""
    take = np.zeros((len(read), 1, 3))
    take[:, 0, 1] = read
    return take


LIMITS = (np.zeros(8), np.ones(8))


@pytest.mark.parametrize("parts", [False, True])
def test_a_gap_comes_to_what_is_read_and_lids_are_only_closed_further(rng: np.random.Generator, parts: bool) -> None:
    contacts, solved = opened(parts, rng), rng.normal(size=(40, 8))
    read, wide = rng.uniform(-0.79, -0.5, 40), (np.full(8, -9.0), np.full(8, 9.0))
    gaps = [0.9 + w @ contacts.opening[0] for w in (solved, contacts.touching(solved, read_as(read), wide, 1.0))]
    wanted = 0.9 + 0.9 / 0.8 * read
    assert (gaps[0] < wanted).any()
    assert (gaps[0] > wanted).any()
    np.testing.assert_allclose(gaps[1], wanted if parts else np.minimum(wanted, gaps[0]), atol=1e-5)
    half = 0.9 + contacts.touching(solved, read_as(read), wide, 0.5) @ contacts.opening[0]
    np.testing.assert_allclose(half, (gaps[0] + gaps[1]) / 2, atol=1e-5)
    apart = read_as(np.full(40, -0.3))
    np.testing.assert_array_equal(contacts.touching(solved, apart, wide, 1.0), solved)


def test_the_skin_moves_as_little_as_the_gap_and_the_limits_allow(rng: np.random.Generator) -> None:
    contacts, solved = opened(True, rng), rng.uniform(0, 1, (6, 8))
    found = contacts.touching(solved, read_as(np.full(6, -0.6)), LIMITS, 1.0)
    opening, ease = contacts.opening[0], contacts.ways[0] / contacts.opening[0]
    assert (found.min(), found.max()) == (0, 1)
    for before, after in zip(solved, found, strict=True):
        same = {"type": "eq", "fun": lambda w, after=after: (w - after) @ opening}
        best = minimize(
            lambda w, before=before: ((w - before) ** 2 / ease).sum(),
            before,
            constraints=same,
            bounds=[(0, 1)] * 8,
            tol=1e-12,
        )
        np.testing.assert_allclose(after, best.x, atol=1e-4)


def test_a_gap_beyond_the_limits_goes_as_far_as_they_let_it(rng: np.random.Generator) -> None:
    contacts = opened(True, rng)
    rest = np.array([100.0])
    found = replace(contacts, rest=rest).touching(np.full((1, 8), 0.5), read_as(np.array([-0.6])), LIMITS, 1.0)
    np.testing.assert_array_equal(found[0], contacts.opening[0] < 0)


def test_shapes_that_exclude_each_other_are_left_alone() -> None:
    rig = lidded()
    take = captured(rig, weights())
    names = rig.blendshapes.names
    plain, closing = (fitted(rig, take, contact=s, exclusive=[names[3:5]]).retarget(take)[0].values for s in (0, 1.0))
    np.testing.assert_array_equal(closing[:, 3:5], plain[:, 3:5])
    assert not np.array_equal(closing, plain)


def test_without_landmarks_or_a_blink_there_is_no_contact_and_a_note_says_so() -> None:
    rig = lidded()
    take = captured(rig, weights())
    bare = fitted(replace(rig, landmarks={}), take, contact=1.0)
    assert bare.contacts is None
    assert "contact-unknown" in [note.code for note in bare.notes]
    still = weights()
    still[:, 3:5] *= 0.1
    awake = fitted(rig, captured(rig, still), contact=1.0)
    assert awake.contacts is None or set(awake.contacts.names) == {"lips"}
    plain = fitted(rig, take)
    assert plain.contacts is None
    assert "contact" not in [note.code for note in plain.notes]


def test_frame_by_frame_and_a_kept_model_give_what_the_whole_take_gives() -> None:
    rig = lidded()
    take = captured(rig, weights())
    points = take.points.copy()
    points[90:95, 30:60] = np.nan
    take = replace(take, points=points)
    made = fitted(rig, take, contact=0.5, ahead=False)
    whole = made.retarget(take)[0].values
    state, rows = made.start(), []
    for frame in points:
        state, row = made.step(state, frame)
        rows.append(row)
    np.testing.assert_allclose(rows, whole, atol=1e-9)
    header, arrays = packed(made)
    again = unpacked(json.loads(json.dumps(header)), arrays)
    np.testing.assert_array_equal(again.retarget(take)[0].values, whole)
    with pytest.raises(InputError, match="garbles"):
        unpacked(header, {**arrays, "contact_ways": arrays["contact_ways"][:, :3]})


@pytest.mark.parametrize("strength", [-1.0, 1.1, float("nan"), float("inf")])
def test_a_strength_that_is_none_is_refused(strength: float) -> None:
    with pytest.raises(InputError, match="contact must be"):
        SolveSettings(contact=strength)
