"""Lids and lips that touch in the actor touch in the character."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mien.core import Blendshapes, InputError, Markers, Rig, SurfacePoints
from mien.retargeting import make_method
from mien.retargeting.contact import Contacts, find_contacts
from mien.retargeting.prepare import prepare
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
    plain, closing = (fitted(rig, take, contact=s, ahead=False).retarget(take)[0].values for s in (0.0, 1.0))
    before, after = (abs(gap(rig, found[[blink]], "right lids")[0]) for found in (plain, closing))
    assert before > 0.1 * rest
    assert after < 0.5 * before
    apart = values[:, 3:5].max(axis=1) < 0.3 * values[:, 3:5].max()
    np.testing.assert_allclose(closing[apart][:, 3:5], plain[apart][:, 3:5], atol=0.05)


def test_closed_is_0_at_rest_and_1_at_the_end_of_a_blink_and_unseen_lids_are_open() -> None:
    rig = lidded()
    take = captured(rig, weights())
    solver = fitted(rig, take, contact=1.0).solver
    contacts: Contacts = solver.contacts
    right = contacts.names.index("right lids")
    shown = weights()[:, 4]
    moved = (take.points - take.points[0]) @ np.eye(3)
    displaced = fitted(rig, take, contact=1.0).displacements(take.points)[0]
    closed = contacts.closed(displaced)
    assert closed.shape == (len(moved), len(contacts.names))
    assert closed[shown.argmax(), right] == 1
    assert (closed[shown < 0.5 * shown.max(), right] == 0).all()
    hidden = displaced.copy()
    hidden[:, contacts.reading[right].any(axis=1)] = np.nan
    assert not contacts.closed(hidden)[:, right].any()
    np.testing.assert_array_equal(contacts.closed(displaced[7]), closed[7])


def test_the_cost_is_the_mean_squared_gap() -> None:
    rig = lidded()
    take = captured(rig, weights())
    points = points_on(rig, 144)
    prepared = prepare(rig, take, pairs_of(points), neutral=at_rest(rig, points), head_moves=False)
    contacts, _ = find_contacts(rig, prepared, 0.7)
    assert contacts is not None
    centimetre = prepared.terms.character_centimetre
    for name, form, pull in zip(contacts.names, contacts.forms, contacts.pulls, strict=True):
        pairs = {**LIDS, **LIPS}[name]
        w = np.random.default_rng(1).uniform(size=(2, 6))
        costs = []
        for one in w:
            posed = [rig.landmarks[f"ibug_{n}"].of(rig.pose(one))[0] for pair in pairs for n in pair]
            rest = [rig.landmarks[f"ibug_{n}"].of(rig.neutral.vertices)[0] for pair in pairs for n in pair]
            start = rest if name in LIPS else np.zeros_like(rest)
            up = contacts.reading[contacts.names.index(name)].sum(axis=0)
            apart = np.array(posed) - start
            apart = (apart[::2] - apart[1::2])[:, 1] / centimetre
            costs.append(0.7 * (apart**2).mean() - 0.5 * one @ form @ one + pull @ one)
            assert np.linalg.norm(up) < 1e-9
        assert costs[0] == pytest.approx(costs[1], rel=0.05, abs=2e-3)


def test_without_landmarks_or_a_blink_there_is_no_contact_and_a_note_says_so() -> None:
    rig = lidded()
    take = captured(rig, weights())
    bare = fitted(replace(rig, landmarks={}), take, contact=1.0)
    assert bare.solver.contacts is None
    assert "contact-unknown" in [note.code for note in bare.notes]
    still = weights()
    still[:, 3:5] *= 0.1
    awake = fitted(rig, captured(rig, still), contact=1.0)
    assert awake.solver.contacts is None or set(awake.solver.contacts.names) == {"lips"}
    plain = fitted(rig, take)
    assert plain.solver.contacts is None
    assert "contact" not in [note.code for note in plain.notes]


def test_frame_by_frame_and_a_kept_model_give_what_the_whole_take_gives() -> None:
    rig = lidded()
    take = captured(rig, weights())
    points = take.points.copy()
    points[90:95, 30:60] = np.nan
    take = replace(take, points=points)
    made = fitted(rig, take, contact=0.5)
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
        unpacked(header, {**arrays, "contact_forms": arrays["contact_forms"][:, :3]})


@pytest.mark.parametrize("strength", [-1.0, float("nan"), float("inf")])
def test_a_strength_that_is_none_is_refused(strength: float) -> None:
    with pytest.raises(InputError, match="contact must be"):
        SolveSettings(contact=strength)
