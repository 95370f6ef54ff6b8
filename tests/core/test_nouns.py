"""The nouns check themselves when they are made, and cannot be changed afterwards."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mien.core import (
    Blendshapes,
    Clip,
    Correspondence,
    Examples,
    InputError,
    Markers,
    Mesh,
    MissingPackage,
    Note,
    Report,
    Rig,
    Skeleton,
    Skin,
    SurfacePoints,
)
from mien.core.errors import unknown
from mien.core.units import HUMAN_FACE_RADIUS_CM, face_radius, human_centimetre
from tests.conftest import grid_rig

NAN, INF = float("nan"), float("inf")
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
EYE = np.eye(4)
MESH = Mesh(CORNERS, [[0, 1, 2], [0, 2, 3]])
AT = SurfacePoints.at_vertices(np.array([0, 1]))
NO_SHAPES = Blendshapes((), np.zeros((0, 4, 3)))
SKELETON = Skeleton(("head",), np.array([-1]), EYE[None])
SKIN = Skin(np.zeros((4, 1), int), np.ones((4, 1)), EYE[None])

WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "a mesh in the plane": (lambda: Mesh(np.zeros((4, 2)), [[0, 1, 2]]), r"vertices must have shape \(any, 3\)"),
    "a mesh without vertices": (lambda: Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), "no vertices"),
    "a vertex at NaN": (lambda: Mesh(np.full((4, 3), NAN), [[0, 1, 2]]), "12 NaN or infinite"),
    "a vertex at infinity": (lambda: Mesh(np.array([[0, INF, 0]]), np.zeros((0, 3), int)), r"first at index \(0, 1\)"),
    "a triangle beyond the mesh": (lambda: Mesh(CORNERS, [[0, 1, 4]]), "index 4, but only 0 … 3"),
    "a negative corner": (lambda: Mesh(CORNERS, [[0, 1, -1]]), "index -1"),
    "quads for triangles": (lambda: Mesh(CORNERS, [[0, 1, 2, 3]]), "triangles must have shape"),
    "texture of another mesh": (lambda: Mesh(CORNERS, [[0, 1, 2]], uv=np.zeros((2, 3, 2))), "texture"),
    "a group beyond the mesh": (lambda: Mesh(CORNERS, [[0, 1, 2]], groups={"lid": np.array([9])}), "'lid'"),
    "weights that sum to 2": (lambda: SurfacePoints([[0, 1, 2]], [[1, 1, 0.0]]), "sum to 1; point 0"),
    "weights of NaN": (lambda: SurfacePoints([[0, 1, 2]], [[NAN, 1, 0.0]]), "barycentric"),
    "corners of other points": (lambda: SurfacePoints([[0, 1, 2]], np.zeros((0, 3))), "corners"),
    "a negative surface corner": (lambda: SurfacePoints([[0, 1, -2]], [[1, 0, 0.0]]), "index -2"),
    "two shapes of one name": (lambda: Blendshapes(("a", "a"), np.zeros((2, 4, 3))), "'a' occurs more than once"),
    "fewer deltas than names": (lambda: Blendshapes(("a", "b"), np.zeros((1, 4, 3))), "deltas must have shape"),
    "a delta of NaN": (lambda: Blendshapes(("a",), np.full((1, 4, 3), NAN)), "NaN"),
    "a parent beyond the skeleton": (lambda: Skeleton(("a",), np.array([1]), EYE[None]), "parents"),
    "a parent below the root": (lambda: Skeleton(("a",), np.array([-2]), EYE[None]), "parents"),
    "rest matrices of 3 × 3": (lambda: Skeleton(("a",), np.array([-1]), np.eye(3)[None]), "rest"),
    "an influence beyond the joints": (lambda: Skin(np.ones((4, 1), int), np.ones((4, 1)), EYE[None]), "skin joints"),
    "influences of another shape": (lambda: Skin(np.zeros((4, 2), int), np.ones((4, 1)), EYE[None]), "skin joints"),
    "shapes of another mesh": (
        lambda: Rig(MESH, Blendshapes(("a",), np.zeros((1, 5, 3)))),
        "5 vertices, its neutral 4",
    ),
    "a skeleton without skin": (lambda: Rig(MESH, NO_SHAPES, skeleton=SKELETON), "or neither"),
    "a skin without skeleton": (lambda: Rig(MESH, NO_SHAPES, skin=SKIN), "or neither"),
    "a skin of another mesh": (
        lambda: Rig(MESH, NO_SHAPES, SKELETON, Skin(np.zeros((3, 1), int), np.ones((3, 1)), EYE[None])),
        "covers 3 of 4",
    ),
    "two channels of one name": (lambda: Clip(("a", "a"), np.zeros((3, 2)), 30), "channels"),
    "values of other channels": (lambda: Clip(("a",), np.zeros((3, 2)), 30), "channel values"),
    "an infinite weight": (lambda: Clip(("a",), np.array([[INF]]), 30), "1 infinite"),
    "no frame rate": (lambda: Clip(("a",), np.zeros((3, 1)), 0), "frame rate .* 0"),
    "a frame rate of NaN": (lambda: Clip(("a",), np.zeros((3, 1)), NAN), "frame rate"),
    "a frame rate of infinity": (lambda: Markers(("a",), np.zeros((3, 1, 3)), INF), "frame rate"),
    "a negative frame rate": (lambda: Markers(("a",), np.zeros((3, 1, 3)), -60), "frame rate"),
    "head motion of other frames": (lambda: Clip(("a",), np.zeros((3, 1)), 30, head=EYE[None]), "head motion"),
    "head motion of NaN": (lambda: Clip(("a",), np.zeros((1, 1)), 30, head=EYE[None] * NAN), "head motion"),
    "one eye": (lambda: Clip(("a",), np.zeros((1, 1)), 30, eyes=np.zeros((1, 1, 3))), "eye rotations"),
    "joints of other frames": (lambda: Clip(("a",), np.zeros((3, 1)), 30, joints=np.zeros((2, 1, 4, 4))), "joint"),
    "two markers of one name": (lambda: Markers(("a", "a"), np.zeros((3, 2, 3)), 60), "markers"),
    "positions of other markers": (lambda: Markers(("a",), np.zeros((3, 2, 3)), 60), "marker positions"),
    "a marker at infinity": (lambda: Markers(("a",), np.full((1, 1, 3), INF), 60), "3 infinite"),
    "two pairs of one name": (lambda: Correspondence(("a", "a"), AT), "pairs"),
    "more names than points": (lambda: Correspondence(("a", "b", "c"), AT), "3 pair names do not match 2"),
    "source of other pairs": (
        lambda: Correspondence(("a", "b"), AT, AT.take(np.array([0]))),
        "2 pair names do not match 1",
    ),
    "confidence of other pairs": (lambda: Correspondence(("a", "b"), AT, confidence=np.ones(3)), "confidences"),
    "a confidence of NaN": (lambda: Correspondence(("a", "b"), AT, confidence=np.array([1, NAN])), "confidences"),
    "a negative confidence": (
        lambda: Correspondence(("a", "b"), AT, confidence=np.array([1, -1.0])),
        "between 0 and 1",
    ),
    "a confidence above 1": (lambda: Correspondence(("a", "b"), AT, confidence=np.array([1, 2.0])), "between 0 and 1"),
    "two examples of one name": (lambda: Examples(np.array([1]), ("a", "a"), np.zeros((1, 2))), "example parameters"),
    "a negative example frame": (lambda: Examples(np.array([-1]), ("a",), np.zeros((1, 1))), "example frames"),
    "examples of other frames": (lambda: Examples(np.array([1, 2]), ("a",), np.zeros((1, 1))), "example frames"),
    "an infinite label": (lambda: Examples(np.array([1]), ("a",), np.array([[INF]])), "example values"),
    "an unknown shape": (lambda: grid_rig().blendshapes.index("JawOpen"), "Did you mean 'jawOpen'"),
    "an unknown marker": (lambda: Markers(("Chin",), np.zeros((1, 1, 3)), 60).only(["chin"]), "Did you mean 'Chin'"),
    "a name of half a character": (lambda: Clip(("\ud800a",), np.zeros((1, 1)), 30), "half a character"),
    "a face in one point": (lambda: face_radius(np.ones((5, 3))), "coincide"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_noun_refuses_what_it_cannot_be(name: str) -> None:
    make, said = WRONG[name]
    with pytest.raises(InputError, match=said):
        make()


FROZEN: dict[str, object] = {
    "mesh": Mesh(CORNERS, [[0, 1, 2]], uv=np.zeros((1, 3, 2)), groups={"lid": np.array([1])}),
    "points": AT,
    "shapes": grid_rig().blendshapes,
    "skeleton": SKELETON,
    "skin": SKIN,
    "clip": Clip(("a",), np.zeros((1, 1)), 30, EYE[None], np.zeros((1, 2, 3)), EYE[None, None]),
    "markers": Markers(("a",), np.zeros((1, 1, 3)), 60),
    "pairs": Correspondence(("a", "b"), AT),
    "examples": Examples(np.array([1]), ("a",), np.zeros((1, 1))),
}


@pytest.mark.parametrize("name", FROZEN)
def test_the_arrays_and_fields_of_a_noun_cannot_be_changed(name: str) -> None:
    noun: Any = FROZEN[name]
    values = [*vars(noun).values(), *(ids for v in vars(noun).values() if isinstance(v, dict) for ids in v.values())]
    arrays = [value for value in values if isinstance(value, np.ndarray)]
    assert arrays
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    with pytest.raises(AttributeError):
        setattr(noun, next(iter(vars(noun))), None)


def test_a_half_seen_marker_is_not_seen() -> None:
    points = np.zeros((2, 2, 3))
    points[1, 0, 2] = np.nan
    markers = Markers(("a", "b"), points, 60)
    np.testing.assert_array_equal(markers.seen, [[True, True], [False, True]])
    assert np.isnan(markers.points[1, 0]).all()


def test_markers_are_picked_by_name_in_the_wanted_order(rng: np.random.Generator) -> None:
    points = rng.normal(size=(4, 3, 3))
    picked = Markers(("a", "b", "c"), points, 60).only(["c", "a"])
    assert picked.names == ("c", "a")
    np.testing.assert_array_equal(picked.points, points[:, [2, 0]])


def test_absent_channels_rest() -> None:
    clip = Clip(("a", "b"), np.array([[1, 2.0], [3, np.nan]]), 30)
    np.testing.assert_array_equal(clip.channels(["b", "x", "a"]), [[2, 0, 1], [np.nan, 0, 3]])
    np.testing.assert_array_equal(Clip((), np.zeros((2, 0)), 30).channels(["x"]), np.zeros((2, 1)))


def test_surface_points_interpolate_whatever_is_per_vertex(rng: np.random.Generator) -> None:
    rig = grid_rig()
    points = SurfacePoints(rig.neutral.triangles[[3, 8]], rng.dirichlet([1, 1, 1], 2))
    found = points.of(rig.blendshapes.deltas)
    for k in range(3):
        for m in range(2):
            corners = rig.blendshapes.deltas[k, points.corners[m]]
            np.testing.assert_allclose(found[k, m], points.weights[m] @ corners, atol=1e-15)


def test_only_the_shapes_that_move_nothing_are_empty() -> None:
    deltas = np.zeros((3, 4, 3))
    deltas[1, 2, 0] = -1e-9
    assert Blendshapes(("a", "b", "c"), deltas).empty == ("a", "c")
    assert NO_SHAPES.empty == ()


def skinned(rng: np.random.Generator) -> Rig:
    rig = grid_rig()
    n, j = len(rig.neutral.vertices), 3
    rest = np.tile(EYE, (j, 1, 1))
    rest[:, :3, :3] += rng.normal(0, 0.2, (j, 3, 3))
    rest[:, :3, 3] = rng.normal(0, 0.1, (j, 3))
    bind = np.linalg.inv(rest) @ (EYE + np.pad(rng.normal(0, 0.05, (j, 3, 4)), ((0, 0), (0, 1), (0, 0))))
    skin = Skin(rng.integers(0, j, (n, 2)), rng.dirichlet([1, 1], n), bind)
    return Rig(rig.neutral, rig.blendshapes, Skeleton(("a", "b", "c"), np.array([-1, 0, 1]), rest), skin)


def test_a_skinned_pose_is_the_blend_of_its_joints_vertex_by_vertex(rng: np.random.Generator) -> None:
    rig = skinned(rng)
    assert rig.skin is not None
    assert rig.skeleton is not None
    weights = rng.uniform(0, 1, (4, 3))
    joints = rig.skeleton.rest @ (EYE + rng.normal(0, 0.1, (4, 3, 4, 4)) * np.array([1, 1, 1, 0])[:, None])
    posed = rig.pose(weights, joints)
    for frame in range(4):
        for v in range(0, len(rig.neutral.vertices), 5):
            local = rig.neutral.vertices[v] + sum(
                w * d[v] for w, d in zip(weights[frame], rig.blendshapes.deltas, strict=True)
            )
            now, rest = np.zeros((4, 4)), np.zeros((4, 4))
            for joint, share in zip(rig.skin.joints[v], rig.skin.weights[v], strict=True):
                now += share * joints[frame, joint] @ rig.skin.inverse_bind[joint]
                rest += share * rig.skeleton.rest[joint] @ rig.skin.inverse_bind[joint]
            expected = now @ np.linalg.solve(rest, [*local, 1])
            np.testing.assert_allclose(posed[frame, v], expected[:3], atol=1e-12)


def test_joints_at_rest_change_nothing(rng: np.random.Generator) -> None:
    rig = skinned(rng)
    assert rig.skeleton is not None
    weights = rng.uniform(0, 1, 3)
    np.testing.assert_allclose(rig.pose(weights, rig.skeleton.rest), rig.pose(weights), atol=1e-12)


def test_a_few_vertices_pose_as_they_do_in_the_whole(rng: np.random.Generator) -> None:
    rig, ids = skinned(rng), np.array([30, 4, 11])
    assert rig.skeleton is not None
    weights = rng.uniform(0, 1, (2, 3))
    joints = rig.skeleton.rest + rng.normal(0, 0.1, (2, 3, 4, 4))
    np.testing.assert_allclose(rig.only(ids).pose(weights, joints), rig.pose(weights, joints)[:, ids], atol=1e-14)
    np.testing.assert_allclose(rig.only(ids).pose(weights), rig.pose(weights)[:, ids], atol=1e-14)


def test_a_human_centimetre_follows_the_unit_and_nothing_else(rng: np.random.Generator) -> None:
    points = rng.normal(size=(40, 3))
    points *= HUMAN_FACE_RADIUS_CM / face_radius(points)
    assert human_centimetre(points) == pytest.approx(1)
    for unit in (1e-3, 1.0, 1e3):
        assert human_centimetre(unit * points + 5 * unit) == pytest.approx(unit)


def test_a_report_is_strict_json_whatever_it_holds() -> None:
    notes = (Note("gaps-filled", "3 samples", "take.trc"),)
    report = Report(
        "m", np.array([3, NAN, 4.0]), INF, {"a": 0.5}, {"bounds": (0.0, INF)}, {"kkt": NAN}, notes, {"fit": 0.1}
    )
    document = json.loads(json.dumps(report.as_json(), allow_nan=False))
    assert document["fit"] == {"rms_mm": pytest.approx(np.sqrt(12.5)), "max_mm": 4.0, "per_frame_mm": [3.0, None, 4.0]}
    assert document["gain"] is None
    assert document["settings"]["bounds"] == [0.0, None]
    assert document["kkt"] is None
    assert document["warnings"] == [{"code": "gaps-filled", "message": "3 samples", "where": "take.trc"}]


def test_a_report_without_a_fit_has_no_numbers_for_it() -> None:
    document = Report("copy").as_json()
    assert document["fit"] == {"rms_mm": None, "max_mm": None, "per_frame_mm": []}
    assert (document["format"], document["version"], document["gain"]) == ("mien-report", 1, None)


def test_an_unknown_name_is_met_with_the_closest_known_ones() -> None:
    assert "Did you mean 'jawOpen'?" in unknown("shape", "JAWOPEN", ["jawOpen", "smile"])
    assert "Did you mean" not in unknown("shape", "zzz", ["jawOpen"])
    assert "Known: none." in unknown("shape", "zzz", [])
    assert "(100 in all)" in unknown("shape", "zzz", [f"s{i}" for i in range(100)])


def test_a_missing_package_says_how_to_get_it() -> None:
    assert 'pip install "mien[look]"' in str(MissingPackage("a film", "imageio-ffmpeg", "look"))
