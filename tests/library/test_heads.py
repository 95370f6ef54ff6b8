"""The cast's bare heads: clean skins with real lids and lips, each its own, with landmarks where they belong."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from mien.core import Rig
from mien.library.heads import HEADS
from mien.library.heads.clay import rotation
from mien.library.heads.unfold import Core
from mien.vocabularies.anthropometry import LANDMARKS

ESSENTIAL = (
    *("ibug_36", "ibug_39", "ibug_42", "ibug_45", "ibug_30", "ibug_48", "ibug_54", "ibug_51", "ibug_57"),
    *("chin_tip", "glabella", "forehead_centre"),
)
OPPOSITE = {36: 45, 37: 44, 38: 43, 39: 42, 40: 47, 41: 46, 48: 54, 49: 53, 50: 52, 59: 55, 58: 56, 60: 64, 61: 63}


@cache
def made(name: str) -> Rig:
    return HEADS[name]()


@pytest.fixture(params=list(HEADS))
def head(request: pytest.FixtureRequest) -> Rig:
    return made(request.param)


def at(head: Rig, name: str) -> np.ndarray:
    return head.landmarks[name].of(head.neutral.vertices)[0]


def skin_triangles(head: Rig) -> np.ndarray:
    return head.neutral.triangles[np.isin(head.neutral.triangles, head.neutral.groups["face"]).all(axis=1)]


def borders(triangles: np.ndarray) -> list[set[int]]:
    """Return the vertices of each border loop, after checking that no edge is shared by more than two."""
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed), "an edge is used twice in one direction"
    _, first, count = np.unique(np.sort(directed, axis=1), axis=0, return_index=True, return_counts=True)
    assert count.max() == 2
    follow = dict(directed[first[count == 1]].tolist())
    assert len(follow) == (count == 1).sum(), "two borders touch"
    loops = []
    while follow:
        start, loop = next(iter(follow)), set[int]()
        while start in follow:
            loop.add(start)
            start = follow.pop(start)
        loops.append(loop)
    return loops


def test_the_skin_is_closed_but_for_the_lids_and_the_neck(head: Rig) -> None:
    loops = borders(skin_triangles(head))
    assert len(loops) == 3
    neck = [loop for loop in loops if loop == set(head.neutral.groups["neck"].tolist())]
    assert len(neck) == 1
    x = sorted(head.neutral.vertices[list(loop), 0].mean() for loop in loops if loop not in neck)
    assert x[0] == pytest.approx(-x[1])
    assert x[1] > 0.02


def test_every_other_part_is_closed_and_faces_outwards(head: Rig) -> None:
    v, t = head.neutral.vertices, head.neutral.triangles
    rest = t[~np.isin(t, head.neutral.groups["face"]).any(axis=1)]
    assert borders(rest) == [] or set().union(*borders(rest)) <= set(head.neutral.groups["teeth"].tolist())
    for name, ids in head.neutral.groups.items():
        if name.startswith(("eye_", "horn", "ear", "beard", "tongue", "hair", "brow")):
            corners = v[rest[np.isin(rest, ids).all(axis=1)]] - v[ids].mean(axis=0)
            assert np.linalg.det(corners).sum() > 0, name


def test_every_vertex_is_used_and_no_triangle_is_degenerate(head: Rig) -> None:
    v, t = head.neutral.vertices, head.neutral.triangles
    assert np.array_equal(np.unique(t), np.arange(len(v)))
    edge = np.linalg.norm(v[t] - v[np.roll(t, 1, axis=1)], axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1)
    assert (area / edge).min() > 1e-6


def test_the_skin_is_smooth_away_from_its_openings(head: Rig) -> None:
    v, t, groups = head.neutral.vertices, head.neutral.triangles, head.neutral.groups
    lids = np.concatenate([ids for name, ids in groups.items() if "lid" in name])
    openings = v[np.concatenate([lids, groups["mouth"], groups["lips"], groups.get("nostril", lids)])]
    t = skin_triangles(head)
    far = cKDTree(openings).query(v[t].mean(axis=1))[0] > 0.01
    normal = np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    edge = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(t)), 3)
    order = np.lexsort(edge.T)
    twice = np.flatnonzero((edge[order[1:]] == edge[order[:-1]]).all(axis=1))
    a, b = owner[order[twice]], owner[order[twice + 1]]
    inside = far[a] & far[b]
    bend = (normal[a] * normal[b]).sum(axis=1)[inside]
    assert (bend < 0).mean() < 0.001
    assert np.quantile(bend, 0.01) > 0.5


def test_the_head_is_its_own_mirror_image(head: Rig) -> None:
    where = {tuple(p): i for i, p in enumerate(head.neutral.vertices + 0.0)}
    image = np.array([where[tuple(p)] for p in head.neutral.vertices * [-1, 1, 1] + 0.0])
    assert np.array_equal(np.sort(image), np.arange(len(image)))
    flipped = {tuple(np.roll(t, -int(np.argmin(t)))) for t in image[head.neutral.triangles][:, ::-1]}
    assert flipped == {tuple(np.roll(t, -int(np.argmin(t)))) for t in head.neutral.triangles}


def test_no_two_heads_share_a_triangulation() -> None:
    counts = {name: (len(made(name).neutral.groups["face"]), len(skin_triangles(made(name)))) for name in HEADS}
    assert len(set(counts.values())) == len(HEADS)
    assert 3000 < counts["actor"][0] < 4000
    for name in ("cartoon", "tortoise", "goat"):
        assert 1500 < counts[name][0] < 2500, name


def test_landmarks_are_there_on_the_skin_and_on_the_right_side(head: Rig) -> None:
    assert set(ESSENTIAL) <= set(head.landmarks)
    corners = [int(point.corners[0, 0]) for point in head.landmarks.values()]
    assert len(set(corners)) == len(corners)
    assert set(corners) <= set(head.neutral.groups["face"].tolist())
    for right, left in OPPOSITE.items():
        assert np.array_equal(at(head, f"ibug_{right}") * [-1, 1, 1], at(head, f"ibug_{left}"))
        assert at(head, f"ibug_{left}")[0] > 0
    for name in head.landmarks:
        if name.endswith("_left"):
            assert at(head, name)[0] > 0
            assert np.array_equal(at(head, name) * [-1, 1, 1], at(head, name[:-4] + "right"))
    for name in ("forehead_centre", "glabella", "ibug_30", "ibug_51", "ibug_62", "ibug_66", "ibug_57", "chin_tip"):
        assert at(head, name)[0] == 0
    names = ("forehead_centre", "glabella", "ibug_27", "ibug_30", "ibug_33", "ibug_51", "ibug_57", "chin_tip", "ibug_8")
    assert (np.diff([at(head, name)[1] for name in names]) < 0).all()
    assert at(head, "ibug_43")[1] > at(head, "ibug_47")[1]
    assert at(head, "ibug_44")[1] > at(head, "ibug_46")[1]
    assert at(head, "ibug_42")[2] > at(head, "ibug_45")[2]


@pytest.mark.parametrize("name", ["actor", "cartoon"])
def test_the_human_heads_have_every_landmark_of_the_generic_rig(name: str) -> None:
    assert {point.other for point in LANDMARKS.values()} <= set(made(name).landmarks)


def test_upper_and_lower_lip_are_distinct_and_meet_at_rest(head: Rig) -> None:
    groups, v = head.neutral.groups, head.neutral.vertices
    assert not set(groups["upper_lip"]) & set(groups["lower_lip"])
    for upper, lower in ((62, 66), (63, 65), (61, 67)):
        gap = at(head, f"ibug_{upper}") - at(head, f"ibug_{lower}")
        assert 0 < np.linalg.norm(gap) < 2e-4
    apart = cKDTree(v[groups["lower_lip"]]).query(v[groups["upper_lip"]])[0]
    assert (apart < 2e-4).sum() >= 10


def test_the_lids_lie_over_the_eyeball_and_leave_it_to_be_seen(head: Rig) -> None:
    groups, v = head.neutral.groups, head.neutral.vertices
    for side in ("left", "right"):
        ball = v[groups[f"eye_{side}"]]
        sclera = v[groups[f"sclera_{side}"]]
        system = np.column_stack([2 * sclera, np.ones(len(sclera))])
        centre = np.linalg.lstsq(system, (sclera**2).sum(axis=1), rcond=None)[0][:3]
        radius = np.linalg.norm(sclera - centre, axis=1).max()
        assert np.linalg.norm(ball - centre, axis=1).max() < radius + 1e-9
        lids = v[np.concatenate([groups[f"upper_lid_{side}"], groups[f"lower_lid_{side}"]])]
        clear = np.linalg.norm(lids - centre, axis=1) - radius
        assert clear.min() > 0
        assert clear.max() < 0.002
        assert np.linalg.norm(v[groups["face"]] - centre, axis=1).min() > radius
        corners = [at(head, f"ibug_{n}") for n in ((42, 45) if side == "left" else (39, 36))]
        opening = at(head, "ibug_43" if side == "left" else "ibug_38") - at(
            head, "ibug_47" if side == "left" else "ibug_40"
        )
        assert np.linalg.norm(corners[0] - corners[1]) > radius
        assert np.linalg.norm(opening) > 0.25 * radius


def test_each_head_is_bare(head: Rig) -> None:
    assert len(head.blendshapes) == 0
    assert head.skeleton is None
    assert head.anatomy is None


def test_every_part_has_a_colour(head: Rig) -> None:
    coloured = np.unique(np.concatenate([head.neutral.groups[group] for group in head.colours]))
    assert len(coloured) == len(head.neutral.vertices)
    last = [name for name in head.colours if head.neutral.groups["pupil_left"][0] in head.neutral.groups[name]][-1]
    assert last == "pupil_left"


def test_building_repeats_itself(head: Rig) -> None:
    again = HEADS[head.name]()
    assert np.array_equal(again.neutral.vertices, head.neutral.vertices)
    assert np.array_equal(again.neutral.triangles, head.neutral.triangles)


def test_laying_flat_and_going_back_is_the_identity(rng: np.random.Generator) -> None:
    core = Core((-4.0, 11.0), (1.5, -2.0))
    flat = rng.uniform(-0.7, 0.7, (200, 2))
    origin, out = core.rays(flat)
    assert np.linalg.norm(out, axis=1) == pytest.approx(1)
    assert core.flat(origin + rng.uniform(1, 9, (200, 1)) * out) == pytest.approx(flat)


def test_turns_lower_the_front_and_turn_it_to_the_left() -> None:
    assert rotation(90, 0) @ [0, 0, 1] == pytest.approx([0, -1, 0])
    assert rotation(0, 90) @ [0, 0, 1] == pytest.approx([1, 0, 0])
