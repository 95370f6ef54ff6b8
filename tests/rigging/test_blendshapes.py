"""Carrying blendshapes: what every method owes, whatever the faces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mien.core import InputError, Mesh
from mien.core.arrays import Floats
from mien.io.documents import join, landmarks_on_mesh, read_landmarks
from mien.io.formats import read_rig
from mien.rigging.blendshapes import METHODS, carried
from mien.rigging.dense import lay
from mien.rigging.parts import pieces
from tests.conftest import grid_rig
from tests.rigging.faces import ball, exact_fit, rig_of, sheet

methods = pytest.mark.parametrize("method", METHODS)


def similar(mesh: Mesh, scale: float = 1.7) -> tuple[Mesh, Floats]:
    turn = scale * Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix()
    return replace(mesh, vertices=mesh.vertices @ turn.T + [0.3, -0.1, 0.2]), turn


def other_face(vertices: Floats) -> Floats:
    """A face of other proportions, turned a little."""
    grown = vertices * [1.2, 0.9, 1.1] + 0.01 * np.sin(vertices[:, [1, 2, 0]] * 30)
    return np.asarray(Rotation.from_rotvec([0.0, 0.2, 0.1]).apply(grown))


@methods
def test_a_face_carried_to_itself_keeps_its_shapes(method: str) -> None:
    rig = grid_rig(9)
    shapes, _ = carried(rig, exact_fit(rig.neutral, rig.neutral), method)
    assert shapes.names == rig.blendshapes.names
    assert np.allclose(shapes.deltas, rig.blendshapes.deltas, atol=1e-6 * np.abs(rig.blendshapes.deltas).max())


@methods
def test_a_similar_face_gets_similar_shapes(method: str) -> None:
    rig = grid_rig(9)
    target, turn = similar(rig.neutral)
    shapes, _ = carried(rig, exact_fit(rig.neutral, target), method)
    assert np.allclose(shapes.deltas, rig.blendshapes.deltas @ turn.T, atol=1e-6 * np.abs(shapes.deltas).max())


def test_by_rbf_a_closed_mouth_is_the_warp_of_the_closed_mouth() -> None:
    """Lips that close where an open jaw has taken them: bent there, not where they rest."""
    mesh = grid_rig(9).neutral
    below = (mesh.vertices[:, 1] < np.median(mesh.vertices[:, 1]))[:, None]
    jaw = np.where(below, [0.0, -0.3, 0.1], 0.0) * np.ptp(mesh.vertices)
    fit = exact_fit(mesh, replace(mesh, vertices=other_face(mesh.vertices)))
    shapes, _ = carried(rig_of(mesh, jawOpen=jaw, mouthClose=-0.9 * jaw), fit, "rbf", contact=False)
    posed = fit.warp(mesh.vertices + 0.1 * jaw) - fit.warp(mesh.vertices)
    assert np.allclose(shapes.deltas.sum(axis=0), posed, atol=1e-12 * np.ptp(mesh.vertices))
    assert not shapes.deltas[:, ~below[:, 0]].any()


@methods
def test_units_do_not_matter(method: str) -> None:
    rig = grid_rig(9)
    target = replace(rig.neutral, vertices=other_face(rig.neutral.vertices))
    small, _ = carried(rig, exact_fit(rig.neutral, target), method)
    shapes = replace(rig.blendshapes, deltas=1000 * rig.blendshapes.deltas)
    large = replace(rig, neutral=replace(rig.neutral, vertices=1000 * rig.neutral.vertices), blendshapes=shapes)
    fit = exact_fit(large.neutral, replace(target, vertices=1000 * target.vertices))
    again, _ = carried(large, fit, method)
    assert np.allclose(again.deltas, 1000 * small.deltas, atol=1e-6 * np.abs(again.deltas).max())


@methods
def test_a_shape_of_the_left_moves_only_the_left(method: str) -> None:
    vertices, triangles = sheet(np.linspace(-0.08, 0.08, 17), np.linspace(-0.1, 0.1, 17))
    left = np.clip(vertices[:, :1] / 0.08, 0, None) ** 2 * [0.0, 0.01, 0.004]
    mesh = Mesh(vertices, triangles)
    target = Mesh(other_face(vertices), triangles)
    shapes, _ = carried(rig_of(mesh, smile_L=left), exact_fit(mesh, target), method)
    size = np.linalg.norm(shapes.deltas[0], axis=1)
    assert size[vertices[:, 0] < 0].max() < 0.02 * size.max()


def test_a_rigid_motion_of_the_source_is_one_of_the_target_by_deformation_transfer() -> None:
    rig = grid_rig(9)
    turn = Rotation.from_rotvec([0.2, 0.1, -0.3]).as_matrix()
    motion = rig.neutral.vertices @ turn.T + [0.01, 0.02, -0.01] - rig.neutral.vertices
    target = replace(rig.neutral, vertices=other_face(rig.neutral.vertices))
    shapes, _ = carried(rig_of(rig.neutral, nod=motion), exact_fit(rig.neutral, target), "deformation-transfer")
    posed = target.vertices + shapes.deltas[0]
    edges = target.triangles[:, [0, 1]]
    before = target.vertices[edges[:, 1]] - target.vertices[edges[:, 0]]
    after = posed[edges[:, 1]] - posed[edges[:, 0]]
    turned = np.linalg.lstsq(before, after, rcond=None)[0]
    assert np.allclose(before @ turned, after, atol=1e-9 * np.abs(after).max())
    assert np.allclose(turned.T @ turned, np.eye(3), atol=1e-8)


@methods
def test_a_texture_seam_does_not_become_a_crack(method: str) -> None:
    rig = grid_rig(9)
    target = other_face(rig.neutral.vertices)
    doubled = np.flatnonzero(np.isclose(rig.neutral.vertices[:, 0], 0))
    second = np.arange(len(target))
    second[doubled] = len(target) + np.arange(len(doubled))
    right = rig.neutral.vertices[rig.neutral.triangles].mean(axis=1)[:, 0] > 0
    triangles = np.where(right[:, None], second[rig.neutral.triangles], rig.neutral.triangles)
    split = [Mesh(np.vstack([v, v[doubled]]), triangles) for v in (rig.neutral.vertices, target)]
    deltas = np.concatenate([rig.blendshapes.deltas, rig.blendshapes.deltas[:, doubled]], axis=1)
    source = replace(rig, neutral=split[0], blendshapes=replace(rig.blendshapes, deltas=deltas))
    shapes, _ = carried(source, exact_fit(*split), method)
    assert (shapes.deltas[:, doubled] == shapes.deltas[:, second[doubled]]).all()


def test_empty_shapes_stay_empty_and_are_noted() -> None:
    rig = grid_rig(6)
    rig = rig_of(rig.neutral, smile=rig.blendshapes.deltas[0], nothing=np.zeros_like(rig.blendshapes.deltas[0]))
    for method in METHODS:
        shapes, notes = carried(rig, exact_fit(rig.neutral, rig.neutral), method)
        assert shapes.empty == ("nothing",)
        assert [note.where for note in notes if note.code == "empty-blendshape"] == ["nothing"]


def test_unknown_methods_and_foreign_fits_are_refused() -> None:
    rig, other = grid_rig(6), grid_rig(7)
    with pytest.raises(InputError, match="deformation-transfer"):
        carried(rig, exact_fit(rig.neutral, rig.neutral), "deformation-tranfer")
    with pytest.raises(InputError, match="49 vertices"):
        carried(rig, exact_fit(other.neutral, other.neutral))


@methods
def test_an_eyeball_turns_about_its_own_centre(method: str) -> None:
    skin, triangles = sheet(np.linspace(-0.08, 0.08, 17), np.linspace(-0.1, 0.1, 17))
    here, there = np.array([0.03, 0.02, 0.05]), np.array([0.034, 0.021, 0.05])
    eye, faces = ball(here, 0.012)
    bigger, _ = ball(there, 0.014)
    flags = np.arange(len(skin) + len(eye)) < len(skin)
    source = Mesh(np.vstack([skin, eye]), np.vstack([triangles, faces + len(skin)]))
    target = Mesh(np.vstack([skin * 1.1, bigger]), source.triangles)
    look = np.zeros_like(source.vertices)
    turn = Rotation.from_rotvec([0.0, 0.4, 0.0])
    look[~flags] = turn.apply(eye - here) + here - eye
    shapes, _ = carried(rig_of(source, eyeLookOutLeft=look), exact_fit(source, target, flags), method)
    posed = target.vertices[~flags] + shapes.deltas[0][~flags]
    assert np.allclose(posed, turn.apply(bigger - there) + there, atol=1e-9)
    assert not shapes.deltas[0][flags].any()


@pytest.mark.real
def test_eyes_stay_balls_on_a_real_head(data: Path) -> None:
    adult, head = (read_rig(data / "rigs" / f"{name}.glb") for name in ("makehuman_adult", "ict_head"))
    marks = []
    for rig, name in ((adult, "makehuman_adult"), (head, "ict_head")):
        path = data / "rigs" / f"{name}.landmarks.json"
        marks.append(landmarks_on_mesh(read_landmarks(path), rig.neutral, path))
    names = [name for name in marks[0] if name in marks[1]]
    ours, theirs = (join([mark[name] for name in names]) for mark in marks)
    gazes = [i for i, name in enumerate(adult.blendshapes.names) if name.startswith("eyeLook")]
    shapes = replace(
        adult.blendshapes,
        names=tuple(adult.blendshapes.names[i] for i in gazes),
        deltas=adult.blendshapes.deltas[gazes],
    )
    fit = lay(adult.neutral, ours, head.neutral, theirs)
    moved, _ = carried(replace(adult, blendshapes=shapes), fit, contact=False)
    eyes = [part for part in pieces(head.neutral.triangles, ~fit.target_skin) if len(part) in (770, 800)]
    assert len(eyes) == 4  # two shells each
    for eye in eyes:
        rest = head.neutral.vertices[eye]
        looks = [delta for delta in moved.deltas[:, eye] if delta.any()]
        assert len(looks) == 4
        for delta in looks:
            before, after = (np.linalg.norm(points - points[0], axis=1) for points in (rest, rest + delta))
            assert np.allclose(after, before, atol=1e-9)
            assert 0.002 < np.linalg.norm(delta, axis=1).max() < 0.02
