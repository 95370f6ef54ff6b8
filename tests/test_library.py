"""The embedded library: valid meshes, shapes that do what their names say, and a take that repeats itself."""

from __future__ import annotations

import time
from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from mien.core import Rig
from mien.library import actor, character, performance

CAST = {"actor": actor, "character": character}


@cache
def played(name: str) -> Rig:
    return CAST[name]()


@pytest.fixture(params=list(CAST))
def rig(request: pytest.FixtureRequest) -> Rig:
    return played(request.param)


def point(rig: Rig, name: str, vertices: np.ndarray | None = None) -> np.ndarray:
    return rig.landmarks[name].of(rig.neutral.vertices if vertices is None else vertices)[0]


def posed(rig: Rig, **weights: float) -> np.ndarray:
    values = np.zeros(len(rig.blendshapes))
    for name, value in weights.items():
        values[rig.blendshapes.index(name)] = value
    return rig.pose(values)


def normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return np.cross(b - a, c - a) / 2


def mirror(rig: Rig) -> np.ndarray:
    where = {tuple(p): i for i, p in enumerate(rig.neutral.vertices + 0.0)}
    return np.array([where[tuple(p)] for p in rig.neutral.vertices * [-1, 1, 1] + 0.0])


def test_no_triangle_is_degenerate(rig: Rig) -> None:
    v, t = rig.neutral.vertices, rig.neutral.triangles
    edges = np.linalg.norm(v[t] - v[np.roll(t, 1, axis=1)], axis=2).max(axis=1)
    height = 2 * np.linalg.norm(normals(v, t), axis=1) / edges
    assert height.min() > 1e-5


def test_every_edge_has_two_sides_except_at_the_lids_and_the_neck(rig: Rig) -> None:
    t = rig.neutral.triangles
    directed = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed), "an edge is used twice in one direction"
    _, number, count = np.unique(np.sort(directed, axis=1), axis=0, return_index=True, return_counts=True)
    assert count.max() == 2
    rim = set(directed[number[count == 1]].ravel())
    groups = rig.neutral.groups
    lids = [i for name, ids in groups.items() if "lid" in name for i in ids]
    corners = 2 * 2
    assert set(groups["neck"]) <= rim
    assert set(lids) <= rim
    assert len(rim) == len(groups["neck"]) + len(lids) + corners


def test_every_vertex_is_used(rig: Rig) -> None:
    assert np.array_equal(np.unique(rig.neutral.triangles), np.arange(len(rig.neutral.vertices)))


def test_closed_parts_face_outwards(rig: Rig) -> None:
    v, t = rig.neutral.vertices, rig.neutral.triangles
    for name in ("eye_left", "eye_right", "brow_left", "teeth_upper", "teeth_lower"):
        part = t[np.isin(t, rig.neutral.groups[name]).all(axis=1)]
        corners = v[part] - v[rig.neutral.groups[name]].mean(axis=0)
        volume = np.linalg.det(corners).sum() / 6
        assert volume > 0, name


def test_the_skin_faces_outwards(rig: Rig) -> None:
    v, t = rig.neutral.vertices, rig.neutral.triangles
    skin = np.setdiff1d(rig.neutral.groups["face"], rig.neutral.groups["mouth"])
    t = t[np.isin(t, skin).all(axis=1)]
    normal, centre = normals(v, t), v[t].mean(axis=1)
    outward = (normal * (centre - [0, -0.01, -0.01])).sum(axis=1) > 0
    assert np.linalg.norm(normal[outward], axis=1).sum() > 0.99 * np.linalg.norm(normal, axis=1).sum()


def test_nothing_cuts_through_anything_at_rest_but_the_brows_that_grow_from_the_skin(rig: Rig) -> None:
    v, t = rig.neutral.vertices * 100, rig.neutral.triangles
    t = t[~np.isin(t, np.concatenate([rig.neutral.groups["brow_left"], rig.neutral.groups["brow_right"]])).any(axis=1)]
    t = t[(v[t][..., 0] > -1).all(axis=1)]
    edges = np.unique(np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1), axis=0)
    middle, centre = v[edges].mean(axis=1), v[t].mean(axis=1)
    reach = np.linalg.norm(v[edges[:, 0]] - middle, axis=1)
    width = np.linalg.norm(v[t] - centre[:, None], axis=2).max(axis=1)
    near = cKDTree(middle).sparse_distance_matrix(cKDTree(centre), reach.max() + width.max(), output_type="ndarray")
    near = near[near["v"] < reach[near["i"]] + width[near["j"]]]
    e, f = edges[near["i"]], t[near["j"]]
    apart = ~(e[:, :, None] == f[:, None, :]).any(axis=(1, 2))
    e, f = e[apart], f[apart]
    origin, along = v[e[:, 0]], v[e[:, 1]] - v[e[:, 0]]
    system = np.stack([-along, v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]], axis=2)
    solvable = np.abs(np.linalg.det(system)) > 1e-12
    where = np.linalg.solve(system[solvable], (origin - v[f[:, 0]])[solvable][..., None])[..., 0]
    inside = (where >= 0).all(axis=1) & (where[:, 0] <= 1) & (where[:, 1:].sum(axis=1) <= 1)
    assert not inside.any(), f[solvable][inside][:3]


def test_the_neutral_is_its_own_mirror_image(rig: Rig) -> None:
    image = mirror(rig)
    assert np.array_equal(np.sort(image), np.arange(len(image)))
    flipped = {tuple(np.roll(t, -int(np.argmin(t)))) for t in image[rig.neutral.triangles][:, ::-1]}
    assert flipped == {tuple(np.roll(t, -int(np.argmin(t)))) for t in rig.neutral.triangles}


def test_left_and_right_shapes_mirror_each_other_exactly(rig: Rig) -> None:
    image, shapes, pairs = mirror(rig), rig.blendshapes, 0
    for name in shapes.names:
        for left, right in (("Left", "Right"), ("_L", "_R")):
            other = name[: -len(left)] + right
            if name.endswith(left) and other in shapes.names:
                d = shapes.deltas[shapes.index(name)]
                assert np.array_equal(d[image] * [-1, 1, 1], shapes.deltas[shapes.index(other)]), name
                pairs += 1
    assert pairs >= 8


def test_every_shape_moves_something_and_leaves_the_neck(rig: Rig) -> None:
    assert rig.blendshapes.empty == ()
    reach = np.linalg.norm(rig.blendshapes.deltas, axis=2)
    assert (reach.max(axis=1) > 0.001).all()
    assert reach[:, rig.neutral.groups["neck"]].max() < 1e-4


@pytest.mark.parametrize(("name", "blink"), [("actor", "eyeBlink{}"), ("character", "Blink_{}")])
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_blink_closes_the_lids_to_less_than_a_third_of_a_millimetre(name: str, blink: str, side: str) -> None:
    rig = played(name)
    label = blink.format(side.title() if name == "actor" else side[0].upper())
    upper, lower = rig.neutral.groups[f"upper_lid_{side}"], rig.neutral.groups[f"lower_lid_{side}"]

    def gap(v: np.ndarray) -> float:
        return float(np.linalg.norm(v[upper][:, None] - v[lower], axis=2).min(axis=1).max())

    assert gap(rig.neutral.vertices) > 0.008
    assert gap(posed(rig, **{label: 1.0})) < 0.0003


@pytest.mark.parametrize(("name", "blink"), [("actor", "eyeBlinkLeft"), ("character", "Blink_L")])
def test_lids_never_enter_the_eyeball_while_they_close(name: str, blink: str) -> None:
    rig = played(name)
    ball = rig.neutral.vertices[rig.neutral.groups["eye_left"]]
    centre = 0.5 * (ball.min(axis=0) + ball.max(axis=0))
    centre[2] = ball[:, 2].min() + (np.ptp(ball[:, 0])) / 2
    radius = np.linalg.norm(ball - centre, axis=1).max()
    skin = np.setdiff1d(rig.neutral.groups["face"], rig.neutral.groups["mouth"])
    for weight in np.linspace(0, 1, 9):
        v = posed(rig, **{blink: weight})[skin]
        assert np.linalg.norm(v - centre, axis=1).min() > radius - 1e-4, weight


@pytest.mark.parametrize(("name", "opened"), [("actor", "jawOpen"), ("character", "Jaw_Open")])
def test_the_jaw_opens_the_lips_and_takes_the_lower_teeth_along(name: str, opened: str) -> None:
    rig = played(name)
    v = posed(rig, **{opened: 1.0})
    assert 0 < point(rig, "ibug_62")[1] - point(rig, "ibug_66")[1] < 0.0005
    assert point(rig, "ibug_62", v)[1] - point(rig, "ibug_66", v)[1] > 0.02
    drop = rig.neutral.vertices - v
    assert drop[rig.neutral.groups["teeth_lower"], 1].min() > 0.01
    assert not drop[rig.neutral.groups["teeth_upper"]].any()
    assert abs(drop[rig.landmarks["ibug_33"].corners[0, 0]]).max() < 0.001


def test_left_is_the_subjects_left_and_the_landmarks_lie_as_ibug_numbers_them(rig: Rig) -> None:
    at = {name: point(rig, name) for name in rig.landmarks}
    assert len(at) == 60
    assert len({int(p.corners[0, 0]) for p in rig.landmarks.values()}) == 60
    for n, m in ((17, 26), (21, 22), (31, 35), (36, 45), (37, 44), (41, 46), (48, 54), (49, 53), (59, 55), (60, 64)):
        assert np.array_equal(at[f"ibug_{n}"] * [-1, 1, 1], at[f"ibug_{m}"])
        assert at[f"ibug_{m}"][0] > 0
    x = [at[f"ibug_{n}"][0] for n in (48, 49, 50, 51, 52, 53, 54)]
    assert (np.diff(x) > 0).all()
    y = [at[n][1] for n in ("forehead_centre", "glabella", "ibug_27", "ibug_28", "ibug_29", "ibug_30", "ibug_33")]
    y += [at[n][1] for n in ("ibug_51", "ibug_62", "ibug_66", "ibug_57", "chin_tip")]
    assert (np.diff(y) < 0).all()
    assert at["ibug_30"][2] == max(p[2] for p in at.values())
    assert at["ibug_43"][1] > at["ibug_42"][1] > at["ibug_47"][1]
    assert at["ibug_42"][0] < at["ibug_43"][0] < at["ibug_44"][0] < at["ibug_45"][0]
    assert at["gonion_left"][0] > 0.04


def test_the_actor_is_human_sized_and_the_character_is_not_like_them() -> None:
    a, c = played("actor"), played("character")
    height = a.neutral.vertices[:, 1].max() - point(a, "chin_tip")[1]
    assert 0.21 < height < 0.24
    assert len(a.neutral.vertices) != len(c.neutral.vertices)
    assert not set(a.blendshapes.names) & set(c.blendshapes.names)
    assert len(c.blendshapes) < len(a.blendshapes)

    def eye(rig: Rig) -> float:
        return float(np.linalg.norm(point(rig, "ibug_45") - point(rig, "ibug_42")))

    assert eye(c) > 1.4 * eye(a)


def test_building_takes_less_than_half_a_second_and_repeats_itself(rig: Rig) -> None:
    elapsed = []
    for _ in range(3):
        start = time.process_time()
        again = CAST[rig.name]()
        elapsed.append(time.process_time() - start)
    assert min(elapsed) < 0.5
    assert np.array_equal(again.neutral.vertices, rig.neutral.vertices)
    assert np.array_equal(again.neutral.triangles, rig.neutral.triangles)
    assert np.array_equal(again.blendshapes.deltas, rig.blendshapes.deltas)


def test_the_take_shows_every_shape_at_its_extreme() -> None:
    clip, _ = performance(played("actor"))
    assert clip.values.min() >= 0
    assert clip.values.max(axis=0) == pytest.approx(1, abs=1e-9)
    assert not clip.values[0].any()
    assert np.abs(np.diff(clip.values, axis=0)).max() < 0.3


def test_the_markers_ride_on_the_posed_face_with_a_little_noise() -> None:
    rig = played("actor")
    clip, markers = performance(rig)
    assert markers.names == tuple(rig.landmarks)
    assert clip.head is not None
    for frame in (0, 200, 700):
        v = rig.pose(clip.values[frame])
        truth = np.stack([point(rig, name, v) for name in rig.landmarks])
        truth = truth @ clip.head[frame, :3, :3].T + clip.head[frame, :3, 3]
        off = (markers.points[frame] - truth)[markers.seen[frame]]
        assert 0.0001 < off.std() < 0.0002


def test_the_markers_have_short_gaps_and_a_long_one() -> None:
    _, markers = performance(played("actor"))
    lost = ~markers.seen
    assert 90 <= lost.sum(axis=0).max() < 150
    assert (lost.any(axis=0)).sum() > 4
    assert lost.mean() < 0.01


def test_the_head_turns_and_stays_rigid() -> None:
    clip, _ = performance(played("actor"))
    assert clip.head is not None
    turn = clip.head[:, :3, :3]
    assert np.allclose(turn @ turn.transpose(0, 2, 1), np.eye(3))
    assert np.array_equal(clip.head[0], np.eye(4))
    assert np.degrees(np.arccos((np.trace(turn, axis1=1, axis2=2).min() - 1) / 2)) > 10


def test_the_take_repeats_itself_and_another_generator_gives_other_noise(rng: np.random.Generator) -> None:
    rig = played("actor")
    first, second = performance(rig)[1], performance(rig)[1]
    assert np.array_equal(first.points, second.points, equal_nan=True)
    assert not np.array_equal(first.points, performance(rig, rng)[1].points, equal_nan=True)
