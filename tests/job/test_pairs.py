"""Where pairs come from: a pairs file, landmark files, files beside, or the markers' own names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import FileError, InputError
from mien.io.formats import read_markers, read_rig
from mien.io.trc import write_markers
from mien.job.pairs import OWN, find_pairs
from mien.job.performance import load_performance, load_source
from mien.job.request import Request, Result
from mien.vocabularies.marker_sets import MARKER_SETS
from tests.job.small_files import LANDMARKS, NAMES, POINTS, SmallFiles

VERTICES = POINTS.corners[:, 0]


def name_as_landmarks(files: SmallFiles) -> None:
    """Rename the markers of the take that sit on landmarks after them."""
    names = list(NAMES)
    for name, vertex in LANDMARKS.items():
        names[VERTICES.tolist().index(vertex)] = name
    take = read_markers(files["take.trc"])
    files.take(replace(take, names=tuple(names)))


def test_a_pairs_file_is_taken_at_its_word(files: SmallFiles) -> None:
    pairs, notes = find_pairs(
        load_source(files["take.trc"]), read_rig(files["face.glb"]), pairs=files["face.pairs.json"]
    )
    assert (pairs.names, notes) == (NAMES, ())
    np.testing.assert_array_equal(pairs.target.corners[:, 0], VERTICES)


def test_landmarks_place_markers_where_they_sit(files: SmallFiles) -> None:
    character = read_rig(files["face.glb"])
    sides = (files["markers.landmarks.json"], files["mesh.landmarks.json"])
    pairs, _ = find_pairs(load_source(files["take.trc"]), character, landmarks=sides)
    assert pairs.names == NAMES
    placed = pairs.target.of(character.neutral.vertices)
    off = np.linalg.norm(placed - character.neutral.vertices[VERTICES], axis=1)
    landmarks = [VERTICES.tolist().index(v) for v in LANDMARKS.values()]
    assert off[landmarks].max() == 0  # a landmark is exact
    assert off.max() < 2e-3  # the actor is the character, turned


def test_landmarks_beside_the_character_are_found(files: SmallFiles) -> None:
    files["mesh.landmarks.json"].rename(files["face.landmarks.json"])
    name_as_landmarks(files)
    pairs, _ = find_pairs(load_source(files["take.trc"]), read_rig(files["face.glb"]))
    assert set(LANDMARKS) <= set(pairs.names)
    at = {name: int(c[0]) for name, c in zip(pairs.names, pairs.target.corners, strict=True)}
    assert {name: at[name] for name in LANDMARKS} == LANDMARKS


def test_a_dash_stands_for_a_sides_own_landmarks(files: SmallFiles) -> None:
    name_as_landmarks(files)
    take, character = load_source(files["take.trc"]), read_rig(files["face.glb"])
    pairs, _ = find_pairs(take, character, landmarks=(OWN, files["mesh.landmarks.json"]))
    files["mesh.landmarks.json"].rename(files["face.landmarks.json"])
    beside, _ = find_pairs(take, character)
    np.testing.assert_array_equal(pairs.target.corners, beside.target.corners)
    assert beside.names == pairs.names


def test_landmarks_beside_both_meshes_are_found(files: SmallFiles) -> None:
    for name in ("face.landmarks.json", "anim.landmarks.json"):
        files[name].write_bytes(files["mesh.landmarks.json"].read_bytes())
    character = read_rig(files["face.glb"])
    for source in (load_source(files["anim.glb"]), load_performance(files["weights.csv"], files["face.glb"])):
        pairs, _ = find_pairs(source, character, count=30)
        assert pairs.source is not None
        assert 20 <= len(pairs) <= 30
        vertices = character.neutral.vertices
        np.testing.assert_allclose(pairs.target.of(vertices), pairs.source.of(vertices), atol=2e-3)
        exact = [i for i, name in enumerate(pairs.names) if name in LANDMARKS]
        assert len(exact) == len(LANDMARKS)
        assert [int(pairs.target.corners[i, 0]) for i in exact] == [LANDMARKS[pairs.names[i]] for i in exact]


def test_well_known_markers_need_no_landmarks_of_their_own(demo: Request, demo_result: Result) -> None:
    take, character = read_markers(demo.performance), read_rig(demo.character)
    table = MARKER_SETS["animface-41"]
    known = {landmark: marker for landmark, marker in table.items() if landmark in take.names}
    assert len(known) >= 6
    renamed = replace(take.only(tuple(known)), names=tuple(known.values()))
    path = demo.performance.with_name("known.trc")
    write_markers(path, renamed)
    pairs, _ = find_pairs(load_source(path), character)
    path.unlink()
    reference = demo_result.pairs
    assert reference is not None
    for landmark, marker in known.items():
        mine = pairs.target.corners[pairs.names.index(marker)]
        np.testing.assert_array_equal(mine, reference.target.corners[reference.names.index(landmark)])


def test_a_marker_that_is_never_seen_does_not_stop_the_others(files: SmallFiles) -> None:
    take = read_markers(files["take.trc"])
    points = take.points.copy()
    points[:, 20] = np.nan
    points[5:8, 21] = np.nan
    files.take(replace(take, points=points))
    sides = (files["markers.landmarks.json"], files["mesh.landmarks.json"])
    pairs, _ = find_pairs(load_source(files["take.trc"]), read_rig(files["face.glb"]), landmarks=sides)
    assert set(NAMES) - set(pairs.names) == {NAMES[20]}


def test_pairs_may_be_made_from_a_named_rest_frame(files: SmallFiles) -> None:
    sides = (files["markers.landmarks.json"], files["mesh.landmarks.json"])
    source, character = load_source(files["take.trc"]), read_rig(files["face.glb"])
    at_rest, _ = find_pairs(source, character, landmarks=sides, neutral="0")
    found, _ = find_pairs(source, character, landmarks=sides)
    vertices = character.neutral.vertices
    np.testing.assert_allclose(at_rest.target.of(vertices), found.target.of(vertices), atol=1e-3)
    with pytest.raises(InputError, match="frame 400"):
        find_pairs(source, character, landmarks=sides, neutral="400")


def test_without_anything_to_go_by_it_is_said_what_to_give(files: SmallFiles) -> None:
    character = read_rig(files["face.glb"])
    with pytest.raises(InputError, match=r"--pairs FILE, or --landmarks.*face\.landmarks\.json"):
        find_pairs(load_source(files["take.trc"]), character)
    sides = (files["markers.landmarks.json"], files["mesh.landmarks.json"])
    with pytest.raises(InputError, match="--actor"):
        find_pairs(load_performance(files["weights.csv"]), character, landmarks=sides)
    files["mesh.landmarks.json"].rename(files["face.landmarks.json"])
    with pytest.raises(InputError, match="names are not known"):
        find_pairs(load_source(files["take.trc"]), character)
    with pytest.raises(InputError, match=r"anim has no landmarks.*anim\.landmarks\.json"):
        find_pairs(load_source(files["anim.glb"]), character)
    files.landmarks({"z": {"marker": "m0"}}, "other.json")
    with pytest.raises(FileError, match="share 0 landmarks"):
        find_pairs(
            load_source(files["take.trc"]), character, landmarks=(files["other.json"], files["face.landmarks.json"])
        )
