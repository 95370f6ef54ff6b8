"""People made by code, what methods are given, and crossings counted against a plain reference."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from mien.core import Blendshapes, Mesh, Rig
from mien.core.arrays import Floats
from mien.evaluate import Case
from mien.evaluate.embedded import SENTENCE, LibraryRecipe, library_case
from mien.evaluate.given import LABELS, chosen_frames, given
from mien.evaluate.intersections import crossing_pairs, new_crossings
from mien.evaluate.people import person
from mien.library import actor
from mien.retargeting import make_method


@pytest.fixture(scope="module")
def acting() -> Case:
    return library_case(LibraryRecipe(1), 4)


def test_a_person_is_always_the_same_and_no_other() -> None:
    one, again, other = (person(actor(), number) for number in (1, 1, 2))
    assert np.array_equal(one.neutral.vertices, again.neutral.vertices)
    apart = np.linalg.norm(one.neutral.vertices - other.neutral.vertices, axis=1)
    assert 0.001 < apart.mean() < 0.02


def test_what_a_shape_brings_together_stays_together_on_every_person() -> None:
    face = actor()
    shape = face.blendshapes.index("eyeBlinkLeft")
    posed = face.neutral.vertices + face.blendshapes.deltas[shape]
    upper, lower = (face.landmarks[f"ibug_{n}"] for n in (43, 47))
    before = np.linalg.norm(upper.of(posed) - lower.of(posed))
    warped = person(face, 3)
    closed = warped.neutral.vertices + warped.blendshapes.deltas[shape]
    assert np.linalg.norm(upper.of(closed) - lower.of(closed)) < before + 0.0002
    assert np.linalg.norm(upper.of(warped.neutral.vertices) - lower.of(warped.neutral.vertices)) > 0.005


def test_labels_are_the_truth_of_the_training_take_at_different_frames(acting: Case) -> None:
    frames = chosen_frames(acting, LABELS)
    assert len(np.unique(frames)) == LABELS
    got = given(acting, make_method("ridge"))
    assert got.examples is not None
    assert np.array_equal(got.examples.frames, frames)
    assert np.array_equal(got.examples.values, np.asarray(acting.lesson.values)[frames])
    assert got.examples.names == acting.character.blendshapes.names
    assert len(acting.lesson) == len(acting.training)


def test_chosen_labels_show_more_shapes_than_frames_at_equal_distances(acting: Case) -> None:
    lesson = np.asarray(acting.lesson.values)
    chosen = lesson[chosen_frames(acting, LABELS)].max(axis=0)
    even = lesson[np.linspace(0, len(lesson) - 1, LABELS).astype(int)].max(axis=0)
    assert (chosen > 0.3).sum() >= (even > 0.3).sum()


def test_layers_get_the_actors_extremes_where_names_are_shared_and_markers_otherwise(acting: Case) -> None:
    layers = make_method("layers")
    assert given(acting, layers).pairs is acting.pairs
    spoken = library_case(LibraryRecipe(1, "cartoon", SENTENCE), 8)
    got = given(spoken, layers)
    assert got.pairs is None
    assert got.examples is not None
    assert {name.partition(".")[0] for name in got.examples.names} == {"emotion", "speech", "blink"}


def test_copy_gets_the_recorded_weights_and_others_the_markers_alone(acting: Case) -> None:
    assert given(acting, make_method("copy")).test is acting.recording
    assert given(acting, make_method("rbf")) == ("", acting.training, acting.test, acting.pairs, acting.neutral, None)


def _crosses(one: Floats, other: Floats) -> bool:
    """Return whether an edge of a triangle passes through another."""
    normal = np.cross(other[1] - other[0], other[2] - other[0])
    for a, b in itertools.combinations(one, 2):
        heights = [(p - other[0]) @ normal for p in (a, b)]
        if heights[0] * heights[1] >= 0:
            continue
        hit = a + (b - a) * heights[0] / (heights[0] - heights[1])
        sides = [np.cross(other[(i + 1) % 3] - other[i], hit - other[i]) @ normal for i in range(3)]
        if min(sides) >= 0 or max(sides) <= 0:
            return True
    return False


def test_crossings_are_those_that_trying_every_pair_of_triangles_finds(rng: np.random.Generator) -> None:
    vertices = rng.normal(size=(90, 3))
    triangles = np.arange(90).reshape(30, 3)
    corners = vertices[triangles]
    expected = [
        i * len(triangles) + j
        for i, j in itertools.combinations(range(len(triangles)), 2)
        if _crosses(corners[i], corners[j]) or _crosses(corners[j], corners[i])
    ]
    assert len(expected) > 10
    assert crossing_pairs(vertices, triangles).tolist() == expected


def test_only_crossings_that_are_not_there_at_rest_count(rng: np.random.Generator) -> None:
    vertices = rng.normal(size=(60, 3))
    triangles = np.arange(60).reshape(20, 3)
    far = np.zeros((1, 60, 3))
    far[0, :30, 0] = 100.0
    rig = Rig(Mesh(vertices, triangles), Blendshapes(("apart",), far))
    rest = crossing_pairs(vertices, triangles)
    moved = Rig(Mesh(vertices + far[0], triangles), Blendshapes(("together",), -far))
    apart = crossing_pairs(moved.neutral.vertices, triangles)
    assert new_crossings(rig, np.array([[0.0], [1.0]]), rest).tolist() == [0, 0]
    assert new_crossings(moved, np.array([[1.0]]), apart).tolist() == [len(np.setdiff1d(rest, apart))]
