"""A whole rig onto other faces: what must hold whatever the face looks like."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mien.core import InputError, Mesh, Rig, SurfacePoints
from mien.core.rig import no_blendshapes
from mien.geometry.templates import template_shapes
from mien.library.generic import generic_rig
from mien.library.heads import HEADS
from mien.rigging.transfer import METHODS, Transfer, transfer_rig

PLAYED = ("jawOpen", "eyeBlinkLeft", "joy", "viseme_U")


def bare(rig: Rig) -> Rig:
    return replace(rig, blendshapes=no_blendshapes(len(rig.neutral.vertices)), skeleton=None, skin=None, anatomy=None)


@cache
def moved(name: str) -> Transfer:
    face = bare(generic_rig()) if name == "generic" else HEADS[name]()
    return transfer_rig(generic_rig(), face)


def test_onto_itself_the_rig_plays_as_it_did() -> None:
    own, again = (template_shapes(rig, PLAYED).deltas for rig in (generic_rig(), moved("generic").rig))
    size = float(np.ptp(generic_rig().neutral.vertices, axis=0).max())
    skin = generic_rig().neutral.groups["face"]
    off = np.linalg.norm(own - again, axis=2)[:, skin]
    assert np.sqrt((off**2).mean()) < 1e-3 * size


@pytest.mark.parametrize("name", ["cartoon", "goat"])
def test_the_faces_own_mesh_is_untouched(name: str) -> None:
    face, rig = HEADS[name]().neutral, moved(name).rig.neutral
    n, t = len(face.vertices), len(face.triangles)
    assert np.array_equal(rig.vertices[:n], face.vertices)
    assert np.array_equal(rig.triangles[:t], face.triangles)
    assert len(rig.vertices) == n + len(moved(name).brought.vertices)


@pytest.mark.parametrize("name", ["cartoon", "goat"])
def test_weights_stay_shares_and_labels_labels(name: str) -> None:
    rig = moved(name).rig
    assert rig.skin is not None
    assert rig.anatomy is not None
    assert rig.skin.weights.min() >= 0
    assert np.allclose(rig.skin.weights.sum(axis=1), 1)
    assert rig.skin.weights.shape[1] <= 4
    for part in rig.anatomy.parts:
        assert 0 <= part.weights.min() <= part.weights.max() <= 1
    generic = generic_rig().anatomy
    assert generic is not None
    assert rig.anatomy.labels["region"].names == generic.labels["region"].names
    assert rig.anatomy.templates == generic.templates


@pytest.mark.parametrize("name", ["cartoon", "goat"])
def test_frames_stay_rigid(name: str) -> None:
    rig = moved(name).rig
    assert rig.skeleton is not None
    assert rig.anatomy is not None
    for frame in [*rig.skeleton.rest, *(muscle.frame for muscle in rig.anatomy.muscles)]:
        turn = frame[:3, :3]
        assert np.allclose(turn @ turn.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(turn) > 0


def test_size_and_place_of_the_face_do_not_matter() -> None:
    face = HEADS["cartoon"]()
    turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    far = replace(face, neutral=replace(face.neutral, vertices=1000 * face.neutral.vertices @ turn.T + 7))
    here, there = (
        template_shapes(rig, PLAYED).deltas for rig in (moved("cartoon").rig, transfer_rig(generic_rig(), far).rig)
    )
    size = np.abs(here).max()
    off = np.linalg.norm(here @ turn.T - there / 1000, axis=2)
    assert np.median(off) < 1e-6 * size
    assert np.quantile(off, 0.99) < 0.02 * size


@pytest.mark.parametrize("method", sorted(set(METHODS) - {"warp-and-stick"}))
def test_the_baselines_move_the_templates_as_shapes(method: str) -> None:
    rig = transfer_rig(generic_rig(), HEADS["cartoon"](), method=method).rig
    jaw = rig.blendshapes.deltas[rig.blendshapes.index("jawOpen")]
    chin = rig.landmarks["chin_tip"].of(jaw)[0]
    assert chin[1] < -0.01
    assert rig.anatomy is not None
    assert not rig.anatomy.templates


def test_a_cube_is_refused_with_a_number() -> None:
    corners = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)]) * 0.2
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    names = ("ibug_36", "ibug_45", "ibug_30", "ibug_48", "ibug_54", "chin_tip", "glabella")
    spots = {name: SurfacePoints.at_vertices(np.array([i])) for i, name in enumerate(names)}
    cube = Rig(Mesh(corners, triangles), no_blendshapes(8), landmarks=spots, name="cube")
    with pytest.raises(InputError, match=r"cube.*"):
        transfer_rig(generic_rig(), cube)


def test_unknown_choices_name_the_known_ones() -> None:
    with pytest.raises(InputError, match="warp-and-stick"):
        transfer_rig(generic_rig(), HEADS["goat"](), method="magic")
    with pytest.raises(InputError, match="auto"):
        transfer_rig(generic_rig(), HEADS["goat"](), parts="some")
