"""Landmarks, pairs and examples: what they say comes back, and nonsense is refused by name."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.core import Correspondence, FileError, InputError, Markers, Mesh, MienError, SurfacePoints
from mien.io.documents import (
    landmarks_on_markers,
    landmarks_on_mesh,
    read_landmarks,
    read_pairs,
    write_landmarks,
    write_pairs,
)
from mien.io.examples import read_examples
from tests.conftest import grid_rig
from tests.io.hostile import survives

MESH = replace(grid_rig().neutral, groups={"lid": np.array([7, 8, 9, 13, 14, 15])})
NAMES = ("Chin", "Nose", "Brow", "Lip")
NONSENSE: list[Any] = [
    None, True, False, "5", "", -1, 36, 10**400, 1.5, [], [1], {}, {"vertex": None}, {"vertex": "3"}, {"vertex": True},
    {"vertex": -1}, {"vertex": 36}, {"vertex": [1]}, {"vertex": {"vertex": 1}}, {"triangle": 1e9}, {"triangle": -1},
    {"triangle": 0, "barycentric": 1}, {"triangle": 0, "barycentric": [1, 0]}, {"triangle": 0, "barycentric": [1, 1, 1]},
    {"triangle": 0, "barycentric": [2, -1, 0]}, {"triangle": 0, "barycentric": ["1", 0, 0]},
    {"triangle": 0, "barycentric": [[1], 0, 0]}, {"triangle": 0, "barycentric": [10**400, 0, 0]},
    {"triangle": 0, "barycentric": [True, False, False]}, {"position": [1, 2]}, {"position": "here"},
    {"position": [0, 0, float("nan")]}, {"position": [0, float("inf"), 0]}, {"position": [0, {}, 0]},
    {"marker": "Chin"}, {"marker": 5}, {"marker": ["Chin"]}, {"vertex": 1, "mesh": "lids"}, {"vertex": 1, "mesh": ["lid"]},
    {"vertex": 6, "mesh": "lid"}, {"triangle": 4, "mesh": "lid"},
]  # fmt: skip


def written(path: Path, document: Any) -> Path:
    path.write_text(document if isinstance(document, str) else json.dumps(document), encoding="utf-8")
    return path


def landmarks(path: Path, spots: Any) -> Path:
    return written(path, {"format": "mien-landmarks", "version": 1, "landmarks": spots})


def pairs(path: Path, rows: Any, **more: Any) -> Path:
    return written(path, {"format": "mien-pairs", "version": 1, "pairs": rows, **more})


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "file.json"


def test_landmarks_written_read_back_the_same(path: Path) -> None:
    corners = MESH.triangles[5]
    points = {
        "chin_tip": SurfacePoints.at_vertices(np.array([7])),
        "cheek": SurfacePoints(corners[None], np.array([[0.2, 0.3, 0.5]])),
        "turned": SurfacePoints(corners[None, [2, 0, 1]], np.array([[0.1, 0.2, 0.7]])),
        "edge": SurfacePoints(corners[None, [0, 1, 1]], np.array([[0.25, 0.25, 0.5]])),
        "brôw": SurfacePoints(np.array([[35, 35, 0]]), np.array([[0.5, 0.5, 0]])),
    }
    write_landmarks(path, points, MESH)
    again = landmarks_on_mesh(read_landmarks(path), MESH, path)
    assert list(again) == list(points)
    for name, point in points.items():
        assert np.abs(again[name].of(MESH.vertices) - point.of(MESH.vertices)).max() < 1e-15
    assert read_landmarks(path)["chin_tip"] == {"vertex": 7}
    assert np.array_equal(again["cheek"].weights, points["cheek"].weights)


def test_a_landmark_off_the_surface_cannot_be_written(path: Path) -> None:
    with pytest.raises(InputError, match="no triangle"):
        write_landmarks(path, {"a": SurfacePoints(np.array([[0, 17, 35]]), np.full((1, 3), 1 / 3))}, MESH)
    assert not path.exists()


def test_a_landmark_is_a_vertex_a_place_in_a_triangle_or_the_nearest_point_to_a_position(path: Path) -> None:
    corners = MESH.triangles[5]
    inside = np.array([0.2, 0.5, 0.3]) @ MESH.vertices[corners]
    spots = {
        "v": {"vertex": 9},
        "t": {"triangle": 5, "barycentric": [0.2, 0.5, 0.3]},
        "m": {"triangle": 5},
        "p": {"position": inside.tolist()},
    }
    found = landmarks_on_mesh(read_landmarks(landmarks(path, spots)), MESH, path)
    at = {name: point.of(MESH.vertices)[0] for name, point in found.items()}
    np.testing.assert_array_equal(at["v"], MESH.vertices[9])
    np.testing.assert_allclose(at["t"], inside, atol=1e-15)
    np.testing.assert_allclose(at["m"], MESH.vertices[corners].mean(axis=0), atol=1e-15)
    np.testing.assert_allclose(at["p"], inside, atol=1e-9)


def test_a_landmark_may_be_a_marker_or_a_position_in_the_capture(path: Path) -> None:
    points = np.arange(12.0).reshape(1, 4, 3)
    spots = read_landmarks(landmarks(path, {"chin_tip": {"marker": "Chin"}, "ear": {"position": [1, 2, 3]}}))
    found = landmarks_on_markers(spots, Markers(NAMES, points, 60.0), points[0], path)
    np.testing.assert_array_equal(found["chin_tip"], points[0, 0])
    np.testing.assert_array_equal(found["ear"], [1, 2, 3])


@pytest.mark.parametrize("spot", NONSENSE, ids=repr)
def test_a_landmark_that_is_nonsense_is_refused_by_name(spot: Any, path: Path) -> None:
    with pytest.raises(FileError, match=r"file\.json.*'here'"):
        landmarks_on_mesh(read_landmarks(landmarks(path, {"here": spot})), MESH, path)


@pytest.mark.parametrize(
    "spot", [{"vertex": 3}, {"marker": "Chinn"}, {"marker": None}, {"marker": []}, {"position": [1]}]
)
def test_a_landmark_that_is_no_marker_is_refused_by_name(spot: Any, path: Path) -> None:
    take = Markers(NAMES, np.zeros((1, 4, 3)), 60.0)
    with pytest.raises(FileError, match=r"file\.json.*'here'"):
        landmarks_on_markers(read_landmarks(landmarks(path, {"here": spot})), take, take.points[0], path)


@pytest.mark.parametrize(
    "document",
    [
        "{",
        "[]",
        "5",
        '"text"',
        "null",
        "1" * 5000,
        {"format": "mien-pairs"},
        {"version": 2},
        {"landmarks": []},
        {"landmarks": {}},
    ],
)
def test_what_is_no_landmark_file_is_refused(document: Any, path: Path) -> None:
    with pytest.raises(FileError, match=r"file\.json"):
        read_landmarks(written(path, document))


def test_pairs_of_markers_come_back(path: Path, rng: np.random.Generator) -> None:
    weights = rng.dirichlet([1, 1, 1], 4)
    weights[0] = [0, 1, 0]
    made = Correspondence(
        NAMES, SurfacePoints(MESH.triangles[[3, 9, 20, 41]], weights), None, np.array([1, 0.5, 0, 1.0])
    )
    write_pairs(path, made, MESH)
    found = read_pairs(path, MESH, NAMES)
    assert found.names == NAMES
    assert found.source is None
    np.testing.assert_allclose(found.target.of(MESH.vertices), made.target.of(MESH.vertices), atol=1e-9)
    np.testing.assert_array_equal(found.confidence, made.confidence)


def test_pairs_of_meshes_come_back(path: Path, rng: np.random.Generator) -> None:
    source = SurfacePoints(MESH.triangles[[1, 2, 30]], rng.dirichlet([1, 1, 1], 3))
    made = Correspondence(("a", "b", "c"), SurfacePoints.at_vertices(np.array([4, 30, 17])), source)
    write_pairs(path, made, MESH, MESH)
    found = read_pairs(path, MESH, source=MESH)
    assert found.source is not None
    np.testing.assert_allclose(found.source.of(MESH.vertices), source.of(MESH.vertices), atol=1e-9)
    np.testing.assert_array_equal(found.target.of(MESH.vertices), made.target.of(MESH.vertices))


def test_a_pair_on_no_triangle_is_not_written(path: Path) -> None:
    off = SurfacePoints(np.array([[0, 17, 35]]), np.full((1, 3), 1 / 3))
    with pytest.raises(MienError, match="no triangle"):
        write_pairs(path, Correspondence(("a",), off), MESH)
    assert not path.exists()


def test_a_target_mesh_counts_vertices_and_triangles_of_that_part(path: Path) -> None:
    rows = [{"source": "Chin", "target": 3}, {"source": "Nose", "target": {"triangle": 1, "barycentric": [1, 0, 0]}}]
    found = read_pairs(pairs(path, rows, target_mesh="lid"), MESH, NAMES)
    assert found.target.corners[0, 0] == MESH.groups["lid"][3]
    assert set(found.target.corners[1]) <= set(MESH.groups["lid"])


@pytest.mark.parametrize("name", ["lids", 5, ["lid"], {"lid": 1}, True])
def test_an_unknown_target_mesh_is_refused(name: Any, path: Path) -> None:
    with pytest.raises(FileError, match=r"file\.json: pair 0.*unknown mesh.*lid"):
        read_pairs(pairs(path, [{"source": "Chin", "target": 3}], target_mesh=name), MESH, NAMES)


@pytest.mark.parametrize("spot", NONSENSE, ids=repr)
def test_a_pair_with_nonsense_on_either_side_is_refused_by_number(spot: Any, path: Path) -> None:
    good = {"source": "Chin", "target": 1}
    with pytest.raises(FileError, match=r"file\.json: pair 1"):
        read_pairs(pairs(path, [good, {"source": "Nose", "target": spot}]), MESH, NAMES)
    with pytest.raises(FileError, match=r"file\.json: pair 1"):
        read_pairs(pairs(path, [{"source": 0, "target": 1}, {"source": spot, "target": 2}]), MESH, source=MESH)
    with pytest.raises(FileError, match=r"file\.json: pair 1"):
        read_pairs(pairs(path, [good, {"source": spot, "target": 2}]), MESH, NAMES)


@pytest.mark.parametrize("rows", [None, {}, [], 5, "text", [5], [[]], [{}], [{"source": "Chin"}], [None]], ids=repr)
def test_rows_that_are_no_pairs_are_refused(rows: Any, path: Path) -> None:
    with pytest.raises(FileError, match=r"file\.json"):
        read_pairs(pairs(path, rows), MESH, NAMES)


@pytest.mark.parametrize("value", [-0.1, 1.1, float("nan"), float("inf"), "1", None, True, [1], {}, 10**400], ids=repr)
def test_a_confidence_outside_0_to_1_is_refused(value: Any, path: Path) -> None:
    rows = [{"source": "Chin", "target": 1}, {"source": "Nose", "target": 2, "confidence": value}]
    with pytest.raises(FileError, match=r"file\.json.*confidence"):
        read_pairs(pairs(path, rows), MESH, NAMES)


def test_a_marker_paired_twice_is_refused(path: Path) -> None:
    rows = [{"source": "Chin", "target": 1}, {"source": "Chin", "target": 2}]
    with pytest.raises(FileError, match="'Chin' more than once"):
        read_pairs(pairs(path, rows), MESH, NAMES)


TABLES: dict[str, str] = {
    ".csv": "frame,time,jawOpen,smile\n3,0.1,1,\n 8 ,0.2,0.5,0.25\n",
    ".json": '{"examples": [{"frame": 3, "jawOpen": 1}, {"frame": 8, "jawOpen": 0.5, "smile": 0.25}]}',
}


@pytest.mark.parametrize("suffix", TABLES)
def test_examples_come_back_with_blanks_as_nan(suffix: str, tmp_path: Path) -> None:
    found = read_examples(written(tmp_path / f"e{suffix}", TABLES[suffix]))
    assert found.names == ("jawOpen", "smile")
    np.testing.assert_array_equal(found.frames, [3, 8])
    np.testing.assert_array_equal(found.values, [[1, np.nan], [0.5, 0.25]])


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        (".csv", "time,jawOpen\n0,1\n"),
        (".csv", "frame,jawOpen\n"),
        (".csv", "frame\n3\n"),
        (".csv", "\n\n"),
        (".csv", "frame,jawOpen\n,1\n"),
        (".csv", "frame,jawOpen\n1.5,1\n"),
        (".csv", "frame,jawOpen\n-1,1\n"),
        (".csv", "frame,jawOpen\ninf,1\n"),
        (".csv", "frame,jawOpen\n1e300,1\n"),
        (".csv", "frame,jawOpen\n3,inf\n"),
        (".csv", "frame,jawOpen\n3,wide\n"),
        (".csv", "frame,jawOpen,jawOpen\n3,1,1\n"),
        (".csv", "frame,jawOpen\n3,1\n3,0\n"),
        (".csv", f'frame,jawOpen\n3,"{"1" * 200_000}"\n'),
        (".json", '{"examples": 5}'),
        (".json", '{"examples": [5]}'),
        (".json", '{"examples": [{"jawOpen": 1}]}'),
        (".json", '{"examples": []}'),
        (".json", '{"examples": [{"frame": "3", "jawOpen": true}]}'),
        (".json", '{"examples": [{"frame": [3], "jawOpen": 1}]}'),
        (".json", '{"examples": [{"frame": 3, "jawOpen": {}}]}'),
        (".json", '{"examples": [{"frame": 3, "jawOpen": Infinity}]}'),
        (".json", f'{{"examples": [{{"frame": 1{"0" * 400}, "jawOpen": 1}}]}}'),
        (".json", "[" * 100_000),
    ],
    ids=lambda text: text[:50],
)
def test_examples_that_are_nonsense_are_refused(suffix: str, text: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=rf"e\{suffix}"):
        read_examples(written(tmp_path / f"e{suffix}", text))


@pytest.mark.parametrize(
    ("suffix", "make", "read"),
    [
        (".json", lambda p: landmarks(p, {"a": {"vertex": 1}, "b": {"triangle": 3}}), read_landmarks),
        (
            ".json",
            lambda p: pairs(p, [{"source": n, "target": i} for i, n in enumerate(NAMES)]),
            lambda p: read_pairs(p, MESH, NAMES),
        ),
        (".csv", lambda p: written(p, TABLES[".csv"]), read_examples),
        (".json", lambda p: written(p, TABLES[".json"]), read_examples),
    ],
    ids=["landmarks", "pairs", "examples in csv", "examples in json"],
)
def test_damaged_documents_only_ever_give_an_error_of_ours(
    suffix: str, make: Callable[[Path], Path], read: Callable[[Path], object], tmp_path: Path, rng: np.random.Generator
) -> None:
    survives(read, make(tmp_path / f"file{suffix}"), rng)


def test_an_empty_mesh_part_has_no_vertex_to_name(path: Path) -> None:
    bare = Mesh(MESH.vertices, MESH.triangles, groups={"none": np.empty(0, np.int64)})
    with pytest.raises(FileError, match="has none"):
        read_pairs(pairs(path, [{"source": "Chin", "target": 0}], target_mesh="none"), bare, NAMES)
