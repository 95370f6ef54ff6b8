"""Which part is which, by name and by shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Blendshapes, InputError, Mesh, Rig
from mien.look.parts import COLOURS, part_named, surface_of
from mien.look.shade import linear
from tests.conftest import grid_rig
from tests.look.solids import ball


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("EyeLeft", "eye"),
        ("Wolf3D_Teeth", "teeth"),
        ("tongue01", "tongue"),
        ("iris_L", "iris"),
        ("eyebrows", "hair"),
        ("Eyelashes", "hidden"),
        ("head", ""),
        ("eyelids", "skin"),
        ("greyed", ""),
        ("upper_lip", "lips"),
        ("lip_corner_left", "lips"),
        ("mouth_teeth", "teeth"),
        ("pocket", "mouth"),
        ("face", ""),
        ("horn_left", "horn"),
        ("beard_front", "hair"),
        ("HairTuft", "hair"),
        ("ears", "skin"),
        ("nostril", "nostril"),
        ("Beak_Upper", "beak"),
        ("claws", "horn"),
        ("shell", "shell"),
        ("brow_left", "hair"),
    ],
)
def test_names_tell_parts(name: str, part: str) -> None:
    assert part_named(name) == part


def with_eye(groups: bool) -> tuple[Rig, slice]:
    sheet = grid_rig(40, shapes=("a",))
    eye, faces = ball(20, 0.012)
    n = len(sheet.neutral.vertices)
    vertices = np.concatenate([sheet.neutral.vertices, eye + np.array([0.03, 0.03, 0.12])])
    named = {"eye_L": np.arange(n, len(vertices))} if groups else {}
    mesh = Mesh(vertices, np.concatenate([sheet.neutral.triangles, faces + n]), groups=named)
    return Rig(mesh, Blendshapes(("a",), np.zeros((1, len(vertices), 3)))), slice(n, None)


@pytest.mark.parametrize("groups", [True, False])
def test_an_eyeball_is_white_with_an_iris_whether_named_or_not(groups: bool) -> None:
    rig, eye = with_eye(groups)
    surface = surface_of(rig)
    assert (surface.colours[eye] == COLOURS["eye"]).all()
    assert (surface.colours[: eye.start] == COLOURS["skin"]).all()
    ahead = surface.gaze[eye][np.argmax(rig.neutral.vertices[eye, 2])]
    assert ahead[2] > 10 * np.hypot(ahead[0], ahead[1])
    assert not surface.gaze[: eye.start].any()


def test_a_mesh_split_along_a_seam_is_still_one_piece_with_shared_normals() -> None:
    rig, eye = with_eye(groups=False)
    copies = np.arange(eye.start, len(rig.neutral.vertices))
    split = rig.neutral.triangles.copy()
    on_eye = (split >= eye.start).all(axis=1)
    half = on_eye & (rig.neutral.vertices[split, 1].mean(axis=1) > 0.03)
    split[half] += len(copies)
    vertices = np.concatenate([rig.neutral.vertices, rig.neutral.vertices[copies]])
    again = surface_of(Rig(Mesh(vertices, split), Blendshapes(("a",), np.zeros((1, len(vertices), 3)))))
    used = np.unique(split[on_eye])
    assert (again.colours[used] == COLOURS["eye"]).all()
    assert np.array_equal(again.same[-len(copies) :], again.same[copies])


def test_where_groups_overlap_the_smaller_one_is_meant() -> None:
    rig, eye = with_eye(groups=True)
    ids = np.arange(len(rig.neutral.vertices))
    groups = {"pupil_L": ids[-9:], "mouth": ids, "eye_L": ids[eye]}
    surface = surface_of(Rig(Mesh(rig.neutral.vertices, rig.neutral.triangles, groups=groups), rig.blendshapes))
    for part, place in (("mouth", slice(0, eye.start)), ("eye", slice(eye.start, -9)), ("pupil", slice(-9, None))):
        assert (surface.colours[place] == COLOURS[part]).all()


def coloured(rig: Rig, **colours: tuple[float, float, float]) -> Rig:
    return replace(rig, colours=colours)


def test_a_rigs_own_colours_come_first_later_over_earlier() -> None:
    rig, eye = with_eye(groups=True)
    ids = np.arange(len(rig.neutral.vertices))
    mesh = Mesh(rig.neutral.vertices, rig.neutral.triangles, groups={"all": ids, "eye_L": ids[eye]})
    surface = surface_of(coloured(Rig(mesh, rig.blendshapes), all=(0.0, 0.0, 0.2), eye_L=(0.5, 1.0, 0.0)))
    assert linear(surface.colours[0]) == pytest.approx([0, 0, 0.2])
    assert linear(surface.colours[eye][0]) == pytest.approx([0.5, 1, 0])
    assert not surface.gaze.any()


@pytest.mark.parametrize("groups", [True, False])
def test_a_rig_in_one_colour_keeps_it_but_for_the_eyes_that_names_or_shapes_tell(groups: bool) -> None:
    rig, eye = with_eye(groups)
    everything = {**rig.neutral.groups, "all": np.arange(len(rig.neutral.vertices))}
    rig = Rig(replace(rig.neutral, groups=everything), rig.blendshapes)
    surface = surface_of(coloured(rig, all=(0.1, 0.5, 0.1)))
    assert linear(surface.colours[0]) == pytest.approx([0.1, 0.5, 0.1])
    assert (surface.colours[eye] == COLOURS["eye"]).all()
    assert surface.gaze[eye].any()


def test_what_another_colour_tells_is_not_told_again_on_the_ground() -> None:
    rig, eye = with_eye(groups=False)
    ids = np.arange(len(rig.neutral.vertices))
    groups = {"all": ids, "eyes": ids[20:], "iris": ids[eye]}
    rig = Rig(Mesh(rig.neutral.vertices, rig.neutral.triangles, groups=groups), rig.blendshapes)
    surface = surface_of(coloured(rig, all=(0.1, 0.5, 0.1), iris=(0.6, 0.3, 0.0)))
    assert linear(surface.colours[: eye.start]) == pytest.approx(np.tile([0.1, 0.5, 0.1], (eye.start, 1)))
    assert linear(surface.colours[eye][0]) == pytest.approx([0.6, 0.3, 0])


def test_one_telling_name_does_not_hide_the_eyes_that_only_their_shape_tells() -> None:
    rig, eye = with_eye(groups=False)
    named = replace(rig.neutral, groups={"teeth": np.arange(5)})
    surface = surface_of(Rig(named, rig.blendshapes))
    assert (surface.colours[:5] == COLOURS["teeth"]).all()
    assert (surface.colours[eye] == COLOURS["eye"]).all()


def test_where_names_tell_the_eyes_no_other_ball_is_one() -> None:
    rig, eye = with_eye(groups=True)
    bead, faces = ball(20, 0.012)
    n = len(rig.neutral.vertices)
    vertices = np.concatenate([rig.neutral.vertices, bead + np.array([-0.06, -0.09, 0.12])])
    mesh = Mesh(vertices, np.concatenate([rig.neutral.triangles, faces + n]), groups=rig.neutral.groups)
    surface = surface_of(Rig(mesh, Blendshapes(("a",), np.zeros((1, len(vertices), 3)))))
    assert (surface.colours[eye.start : n] == COLOURS["eye"]).all()
    assert not (surface.colours[n:] == COLOURS["eye"]).all(axis=1).any()


@pytest.mark.parametrize("colour", [(0.0, 0.0), (0.0, 0.0, 1.5), (0.0, np.nan, 0.0)])
def test_a_colour_that_is_none_is_refused_and_so_is_one_of_no_group(colour: tuple[float, ...]) -> None:
    rig, _ = with_eye(groups=True)
    with pytest.raises(InputError, match="colour"):
        replace(rig, colours={"eye_L": colour})
    with pytest.raises(InputError, match="eye_R"):
        coloured(rig, eye_R=(0.0, 0.0, 0.0))


@pytest.mark.real
@pytest.mark.parametrize("name", ["ict_head", "makehuman_adult"])
def test_real_heads_have_two_eyes_teeth_and_a_tongue(data, name: str) -> None:  # type: ignore[no-untyped-def]
    from mien.io.formats import read_rig

    surface = surface_of(read_rig(data / "rigs" / f"{name}.glb"))
    for part in ("eye", "teeth", "tongue"):
        assert (surface.colours == COLOURS[part]).all(axis=1).any(), part
    eyes = surface.gaze.any(axis=1)
    assert eyes.sum() > 100
    assert linear(surface.colours[np.argmin(surface.colours.sum(axis=1) < 2)]) == pytest.approx([0.85, 0.68, 0.58])
