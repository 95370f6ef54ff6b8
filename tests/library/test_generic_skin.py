"""The generic head: a clean symmetric mesh whose slits open, with joints, landmarks and regions."""

from __future__ import annotations

import json
from collections import defaultdict
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mien.core import Rig
from mien.library.generic.head import build
from mien.library.generic.proportions import GENERIC
from mien.library.generic.regions import REGIONS, generic_regions
from mien.library.generic.skin import JOINTS, generic_skin
from mien.library.modelling.half import Head
from mien.vocabularies.anthropometry import LANDMARKS, MIDLINE, PAIRED, same_landmarks

Array = np.ndarray


@cache
def head() -> Head:
    return build(GENERIC)


@cache
def rig() -> Rig:
    return generic_skin(head(), GENERIC)


def group(name: str) -> Array:
    return rig().neutral.groups[name]


def skin_triangles() -> Array:
    t = rig().neutral.triangles
    return t[np.isin(t, group("face")).all(axis=1)]


def normals(vertices: Array, triangles: Array) -> Array:
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def boundary_loops(triangles: Array) -> list[set[int]]:
    """Follow the edges that one triangle alone uses."""
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, first, count = np.unique(np.sort(directed, axis=1), axis=0, return_index=True, return_counts=True)
    following = dict(directed[first[count == 1]].tolist())
    assert len(following) == (count == 1).sum(), "two boundaries meet in a vertex"
    loops = []
    while following:
        start, at = next(iter(following.items()))
        del following[start]
        loop = {start}
        while at != start:
            loop.add(at)
            at = following.pop(at)
        loops.append(loop)
    return loops


def opened(degrees: float) -> Array:
    joints = rig().skeleton.rest.copy()
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    joints[1, :3, :3] = [[1, 0, 0], [0, c, -s], [0, s, c]]
    return rig().pose(np.zeros(0), joints)


def test_the_skin_has_about_1800_vertices() -> None:
    assert 1700 <= len(group("face")) <= 1900


def test_every_vertex_is_used_and_no_triangle_is_degenerate() -> None:
    v, t = rig().neutral.vertices, rig().neutral.triangles
    assert np.array_equal(np.unique(t), np.arange(len(v)))
    edges = np.linalg.norm(v[t] - v[np.roll(t, 1, axis=1)], axis=2).max(axis=1)
    assert (np.linalg.norm(normals(v, t), axis=1) / edges).min() > 1e-5


def test_the_mesh_is_its_own_mirror_image_exactly() -> None:
    v, t, image = rig().neutral.vertices, rig().neutral.triangles, head().mirror
    assert np.array_equal(v[image] * [-1, 1, 1], v)
    assert np.array_equal(image[image], np.arange(len(v)))
    turned = {tuple(np.roll(row, -int(np.argmin(row)))) for row in image[t][:, ::-1]}
    assert turned == {tuple(np.roll(row, -int(np.argmin(row)))) for row in t}


def test_the_skin_is_manifold_and_open_only_at_the_lids_and_the_neck() -> None:
    t = skin_triangles()
    directed = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed), "an edge is used twice in one direction"
    loops = boundary_loops(t)
    assert len(loops) == 3
    assert set(group("neck").tolist()) in loops
    for side in ("left", "right"):
        edge = set(np.concatenate([group(f"upper_lid_{side}"), group(f"lower_lid_{side}")]).tolist())
        (loop,) = (loop for loop in loops if edge <= loop)
        assert len(loop) == len(edge) + 2


def test_the_skin_around_every_vertex_is_one_fan() -> None:
    around = defaultdict(list)
    for row in skin_triangles().tolist():
        for i in range(3):
            around[row[i]].append((row[i - 2], row[i - 1]))
    for vertex, links in around.items():
        following = dict(links)
        assert len(following) == len(links), vertex
        starts = set(following) - set(following.values())
        assert len(starts) <= 1, vertex
        at, steps = next(iter(starts or following)), 0
        while at in following and steps < len(links):
            at, steps = following[at], steps + 1
        assert steps == len(links), vertex


@pytest.mark.parametrize(
    "part", ["eye_left", "eye_right", "brow_left", "brow_right", "teeth_upper", "teeth_lower", "tongue"]
)
def test_a_separate_part_is_closed_and_faces_outwards(part: str) -> None:
    v, t = rig().neutral.vertices, rig().neutral.triangles
    mine = t[np.isin(t, group(part)).all(axis=1)]
    assert np.array_equal(np.unique(mine), group(part))
    assert boundary_loops(mine) == []
    assert np.linalg.det(v[mine] - v[group(part)].mean(axis=0)).sum() > 0


def test_no_triangle_of_the_skin_folds_over_its_neighbours() -> None:
    v, t = rig().neutral.vertices, skin_triangles()
    folding = ("mouth", "ear_left", "ear_right", "lip_corner_left", "lip_corner_right")
    t = t[~np.isin(t, np.concatenate([group(name) for name in folding])).any(axis=1)]
    normal = normals(v, t)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    outward = (normal * (v[t].mean(axis=1) - 0.01 * np.array(GENERIC.centre))).sum(axis=1)
    owner = defaultdict(list)
    for i, row in enumerate(t.tolist()):
        for a, b in ((0, 1), (1, 2), (2, 0)):
            owner[frozenset((row[a], row[b]))].append(i)
    pairs = np.array([both for both in owner.values() if len(both) == 2])
    bend = (normal[pairs[:, 0]] * normal[pairs[:, 1]]).sum(axis=1)
    assert bend.min() > np.cos(np.radians(115))
    area = np.linalg.norm(normals(v, t), axis=1)
    assert area[outward < 0].sum() < 0.004 * area.sum()


def test_the_lips_are_separate_edges_that_all_but_touch() -> None:
    v = rig().neutral.vertices
    upper, lower = group("upper_lip"), group("lower_lip")
    assert not set(upper) & set(lower)
    gap = np.linalg.norm(v[upper][:, None] - v[lower], axis=2)
    edge = np.argsort(gap.min(axis=1))[: GENERIC.mouth.points - 2]
    assert 0 < gap.min(axis=1)[edge].max() < 1.2e-4
    top, bottom = (rig().landmarks[f"stomion_{end}"].of(v)[0] for end in ("superius", "inferius"))
    assert 0 < top[1] - bottom[1] < 1.1e-4


def test_no_skin_enters_an_eyeball() -> None:
    v = rig().neutral.vertices[group("face")]
    for side in (1, -1):
        centre = 0.01 * np.multiply(GENERIC.eye.centre, [side, 1, 1])
        assert np.linalg.norm(v - centre, axis=1).min() > 0.01 * GENERIC.eye.radius


def test_the_face_follows_the_canons() -> None:
    at = {name: point.of(rig().neutral.vertices)[0] for name, point in rig().landmarks.items()}
    top = rig().neutral.vertices[:, 1].max()
    eyes = (at["endocanthion_left"] + at["exocanthion_left"])[1] / 2
    assert abs((top - eyes) / (top - at["gnathion"][1]) - 0.5) < 0.03
    middle, lower = at["glabella"][1] - at["subnasale"][1], at["subnasale"][1] - at["gnathion"][1]
    assert abs(middle / lower - 1) < 0.1
    fissure = at["exocanthion_left"][0] - at["endocanthion_left"][0]
    assert abs(2 * at["endocanthion_left"][0] / fissure - 1) < 0.2
    assert at["alare_left"][0] < at["cheilion_left"][0] < GENERIC.eye.centre[0] * 0.01


def test_the_skeleton_is_head_jaw_and_eyes() -> None:
    skeleton = rig().skeleton
    assert skeleton.names == JOINTS == ("head", "jaw", "eye_left", "eye_right")
    assert skeleton.parents.tolist() == [-1, 0, 0, 0]
    assert np.allclose(skeleton.rest[2, :3, 3], 0.01 * np.array(GENERIC.eye.centre))
    assert np.allclose(rig().pose(np.zeros(0), skeleton.rest), rig().neutral.vertices, atol=1e-15)


def test_skin_weights_are_shares_that_sum_to_one_and_mirror() -> None:
    weights = rig().skin.weights
    assert weights.shape[1] == 4
    assert weights.min() >= 0
    assert np.abs(weights.sum(axis=1) - 1).max() < 1e-12
    assert np.array_equal(weights[head().mirror][:, [0, 1, 3, 2]], weights)


def test_each_part_follows_its_own_joint() -> None:
    weights = rig().skin.weights
    for part, joint in {
        "teeth_upper": 0,
        "neck": 0,
        "teeth_lower": 1,
        "tongue": 1,
        "eye_left": 2,
        "eye_right": 3,
    }.items():
        assert np.array_equal(weights[group(part), joint], np.ones(len(group(part)))), part
    jaw = {name: weights[point.corners[0, 0], 1] for name, point in rig().landmarks.items()}
    for name in ("stomion_inferius", "labiale_inferius", "pogonion", "gnathion"):
        assert jaw[name] > 0.999, name
    for name in ("stomion_superius", "labiale_superius", "pronasale", "glabella", "zygion_left", "endocanthion_left"):
        assert jaw[name] < 0.05, name
    assert 0.35 < jaw["cheilion_left"] < 0.65


def test_the_jaw_opens_the_mouth_wide_without_turning_skin_inside_out() -> None:
    v, posed = rig().neutral.vertices, opened(25)
    top, bottom = (rig().landmarks[f"stomion_{end}"].of(posed)[0] for end in ("superius", "inferius"))
    assert 0.035 < np.linalg.norm(top - bottom) < 0.06
    t = skin_triangles()
    t = t[~np.isin(t, np.concatenate([group("mouth"), group("lips")])).any(axis=1)]
    before, after = normals(v, t), normals(posed, t)
    turned = (before * after).sum(axis=1) / np.linalg.norm(before, axis=1) / np.linalg.norm(after, axis=1)
    assert turned.min() > np.cos(np.radians(80))


def test_there_are_44_landmarks_at_distinct_mirrored_vertices_off_any_plane() -> None:
    found = rig().landmarks
    assert set(found) == set(LANDMARKS)
    assert len(found) == 44
    vertex = {name: int(point.corners[0, 0]) for name, point in found.items()}
    assert len(set(vertex.values())) == 44
    assert set(vertex.values()) <= set(group("face").tolist()) - set(group("mouth").tolist())
    for name in PAIRED:
        assert vertex[f"{name}_right"] == head().mirror[vertex[f"{name}_left"]], name
    v = rig().neutral.vertices
    assert all(v[vertex[name], 0] == 0 for name in MIDLINE)
    assert all(v[vertex[f"{name}_left"], 0] > 0 for name in PAIRED)
    points = v[list(vertex.values())]
    assert np.linalg.svd(points - points.mean(axis=0))[1][2] > 0.05


def test_landmarks_of_both_vocabularies_pair_in_either_direction() -> None:
    others = [point.other for point in LANDMARKS.values()]
    assert len(set(others)) == 44
    assert same_landmarks(LANDMARKS, others) == tuple(zip(LANDMARKS, others, strict=True))
    assert same_landmarks(others, LANDMARKS) == tuple(zip(others, LANDMARKS, strict=True))
    assert same_landmarks(LANDMARKS, LANDMARKS) == tuple((name, name) for name in LANDMARKS)


def test_an_exact_name_wins_and_no_name_is_paired_twice() -> None:
    pairs = same_landmarks(["ibug_30", "pronasale", "wart"], ["pronasale", "wart", "nasion"])
    assert pairs == (("pronasale", "pronasale"), ("wart", "wart"))
    assert same_landmarks(["ibug_30", "pronasale"], ["ibug_30"]) == (("ibug_30", "ibug_30"),)


@pytest.mark.real
def test_a_real_heads_landmark_file_has_43_of_the_44(data: Path) -> None:
    file = json.loads((data / "rigs" / "makehuman_adult.landmarks.json").read_text())["landmarks"]
    assert len(same_landmarks(LANDMARKS, file)) == 43


def test_every_vertex_has_one_region_and_every_region_its_mirror_image() -> None:
    labels = generic_regions(head(), GENERIC)
    assert len(labels.of) == len(rig().neutral.vertices)
    assert set(labels.of.tolist()) == set(range(len(REGIONS)))
    x = rig().neutral.vertices[:, 0]
    swapped = {"left": "right", "right": "left"}
    for mine, other in zip(labels.of[x > 0], labels.of[head().mirror[x > 0]], strict=True):
        name, _, side = labels.names[mine].rpartition("_")
        expected = f"{name}_{swapped[side]}" if side in swapped else labels.names[mine]
        assert labels.names[other] == expected


@pytest.mark.parametrize(
    ("landmark", "region"),
    {
        "metopion": "forehead",
        "pronasale": "nose",
        "alare_left": "nose",
        "labiale_superius": "upper_lip",
        "stomion_inferius": "lower_lip",
        "pogonion": "chin",
        "cheek_right": "cheek_right",
        "palpebrale_superius_medial_left": "upper_lid_left",
        "palpebrale_inferius_lateral_left": "lower_lid_left",
        "superciliare_right": "brow_right",
    }.items(),
)
def test_landmarks_lie_in_the_regions_they_belong_to(landmark: str, region: str) -> None:
    labels = generic_regions(head(), GENERIC)
    assert labels.names[labels.of[rig().landmarks[landmark].corners[0, 0]]] == region
