"""A puppet on controls: small rigs whose motion is known by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Clip, InputError, Mesh, Rig, Skeleton, Skin
from mien.core.anatomy import AXES, Anatomy, Cluster, Flexor, Muscle
from mien.core.arrays import Floats
from mien.core.rig import no_blendshapes
from mien.geometry.muscles import across, beside, drawn, on_polyline, pull
from mien.geometry.puppet import Puppet, controls_of, joint_matrices, joint_scales, posed
from mien.geometry.templates import played, template_controls, template_shapes


def frame(place: tuple[float, float, float], turn: float = 0.0) -> Floats:
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    matrix[:3, 3] = place
    return matrix


def puppet_rig(rng: np.random.Generator, size: float = 1.0) -> Rig:
    """A cloud of points with one of everything, `size` times as large as the face it was authored on."""
    n = 40
    points = rng.uniform(-1, 1, (n, 3)) * 0.1 + [0, 0, 0.2]
    share = [rng.uniform(0, 1, n) for _ in range(6)]
    line = np.array([[0, 0.1, 0.1], [0.02, 0.05, 0.2], [0.03, 0.0, 0.21]])
    seam = np.array([[-0.1, 0, 0.2], [0, 0.01, 0.24], [0.1, 0, 0.2]])
    rest = np.stack([np.eye(4), frame((0, -0.05, 0.05), 0.4)])
    rest[:, :3, 3] *= size

    def placed(turn: float) -> Floats:
        matrix = frame((0.01, 0.02, 0.2), turn)
        matrix[:3, 3] *= size
        return matrix

    anatomy = Anatomy(
        (
            Muscle("puller", size * line, share[0], placed(0.3), size, 0.25),
            Muscle("ring", size * seam, share[1], placed(0.0), size, seam=size * seam, pivot=np.zeros(3)),
        ),
        (Cluster("patch", share[2], placed(-0.2), size),),
        (Flexor("loose", "jaw", share[3]),),
        templates={"pull": {"puller": 0.5, "jaw.rx": 0.1}, "open": {"jaw.rx": 0.3}, "shut": {"loose": 1.0}},
        bases={"shut": "open"},
    )
    skin = Skin(np.tile([0, 1], (n, 1)), np.stack([1 - share[4], share[4]], axis=1), np.linalg.inv(rest))
    return Rig(
        Mesh(size * points, np.empty((0, 3), np.int64)),
        no_blendshapes(n),
        Skeleton(("head", "jaw"), np.array([-1, 0]), rest),
        skin,
        anatomy,
        name="cloud",
    )


@pytest.fixture
def rig() -> Rig:
    return puppet_rig(np.random.default_rng(5))


def test_controls_at_rest_give_exactly_the_neutral(rig: Rig) -> None:
    assert np.abs(posed(rig, {}) - rig.neutral.vertices).max() == 0
    assert np.abs(posed(rig, dict.fromkeys(controls_of(rig), 0.0)) - rig.neutral.vertices).max() == 0


def test_a_linear_muscle_moves_the_skin_in_proportion_to_its_contraction(rig: Rig) -> None:
    rest = rig.neutral.vertices
    once, twice = (posed(rig, {"puller": c}) - rest for c in (0.3, 0.6))
    assert np.allclose(twice, 2 * once, rtol=0, atol=1e-15)


def test_a_straight_fibre_pulls_along_itself_by_its_share_of_its_length() -> None:
    muscle = Muscle("straight", np.array([[0, 0, 0], [0, 0.5, 0], [0, 2.0, 0]]), np.ones(4), np.eye(4), shortening=0.25)
    around = np.array([[0.3, 1, 0], [0, 3, 1], [1, -2, 0], [0, 2, 0.0]])
    assert np.allclose(pull(muscle, around), [0, -0.5, 0])


def test_a_curved_fibre_pulls_around_the_curve() -> None:
    turn = np.linspace(0, np.pi / 2, 400)
    arc = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    muscle = Muscle("arc", arc, np.ones(1), np.eye(4), shortening=1.0)
    somewhere = 1.3 * np.array([[np.cos(0.7), np.sin(0.7), 0]])
    expected = np.pi / 2 * np.array([[np.sin(0.7), -np.cos(0.7), 0]])
    assert np.allclose(pull(muscle, somewhere), expected, atol=5e-3)


def test_a_ring_closes_exactly_onto_its_seam_and_keeps_to_the_ball(rig: Rig) -> None:
    seam = np.array([[-1, 0, 1], [0, -0.2, 1.2], [1, 0, 1.0]])
    x = np.linspace(-0.9, 0.9, 7)
    above, below = (np.stack([x, 0 * x + y, 0 * x + 1], axis=1) for y in (0.5, -0.4))
    upper, lower = across(seam, above), across(seam, below)
    assert np.allclose(upper, lower)
    for lid, place in ((above, upper), (below, lower)):
        arrived = lid + drawn(lid, place, np.ones(7), np.zeros(3))
        assert np.allclose(arrived, place)
        half = lid + drawn(lid, place, np.full(7, 0.5), np.zeros(3))
        radii = (np.linalg.norm(lid, axis=1) + np.linalg.norm(place, axis=1)) / 2
        assert np.allclose(np.linalg.norm(half, axis=1), radii)


def test_the_place_beside_a_seam_goes_around_a_snout() -> None:
    turn = np.linspace(0, np.pi, 181)
    snout = np.stack([np.cos(turn), 0 * turn, 3 * np.sin(turn)], axis=1)
    above = snout[10:-10] + [0, 0.1, 0]
    assert np.abs(beside(snout, above) - snout[10:-10]).max() < 1e-3
    assert np.allclose(beside(snout, snout[:1] - [0, 0, 0.5]), snout[:1] - [0, 0, 0.5], atol=1e-2)


def test_without_a_pivot_points_go_straight() -> None:
    points, places = np.array([[0.0, 1, 0]]), np.array([[1.0, 0, 0]])
    assert np.allclose(drawn(points, places, np.array([0.25]), None), [[0.25, -0.25, 0]])


def test_the_nearest_point_of_a_polyline_is_no_farther_than_any_other(rng: np.random.Generator) -> None:
    line, points = rng.normal(size=(6, 3)), rng.normal(size=(50, 3))
    segment, share, nearest = on_polyline(line, points)
    t = np.linspace(0, 1, 201)[:, None, None]
    dense = ((1 - t) * line[:-1] + t * line[1:]).reshape(-1, 3)
    best = np.linalg.norm(points[:, None] - dense, axis=2).min(axis=1)
    assert (np.linalg.norm(points - nearest, axis=1) <= best + 1e-12).all()
    assert np.allclose(line[segment] + share[:, None] * (line[segment + 1] - line[segment]), nearest)


def test_moving_the_head_moves_everything_rigidly(rig: Rig) -> None:
    expression = {"puller": 0.7, "ring": 0.4, "patch.tx": 0.01, "jaw.rx": 0.2, "loose": 0.5}
    turned = {"head.rx": 0.3, "head.ry": -0.2, "head.rz": 0.4, "head.tx": 0.05, "head.tz": -0.02}
    matrix = joint_matrices(rig, turned)[0]
    still, moved = posed(rig, expression), posed(rig, expression | turned)
    assert np.allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3))
    assert np.allclose(moved, still @ matrix[:3, :3].T + matrix[:3, 3], atol=1e-14)


def test_an_influence_moves_along_the_axes_of_its_own_frame(rig: Rig) -> None:
    assert rig.anatomy is not None
    for part in (*rig.anatomy.muscles, *rig.anatomy.clusters):
        moved = posed(rig, {f"{part.name}.ty": 0.01}) - rig.neutral.vertices
        assert np.allclose(moved, 0.01 * part.weights[:, None] * part.frame[:3, 1])


def test_a_turned_cluster_of_full_weight_turns_rigidly_about_its_place(rig: Rig) -> None:
    assert rig.anatomy is not None
    patch = replace(rig.anatomy.clusters[0], weights=np.ones(len(rig.neutral.vertices)))
    whole = replace(rig, anatomy=replace(rig.anatomy, clusters=(patch,)))
    moved = posed(whole, {"patch.rx": 0.5, "patch.rz": -0.8})
    place = patch.frame[:3, 3]
    before, after = (np.linalg.norm(p - place, axis=1) for p in (rig.neutral.vertices, moved))
    assert np.allclose(before, after)
    assert np.abs(moved - rig.neutral.vertices).max() > 0.01


def test_a_flexor_at_full_strength_keeps_skin_with_the_joint_s_parent(rig: Rig) -> None:
    assert rig.anatomy is not None
    loose = Flexor("loose", "jaw", np.ones(len(rig.neutral.vertices)))
    firm = replace(rig, anatomy=replace(rig.anatomy, flexors=(loose,)))
    assert np.allclose(posed(firm, {"jaw.rx": 0.4, "loose": 1.0}), rig.neutral.vertices, atol=1e-15)
    half = posed(firm, {"jaw.rx": 0.4, "loose": 0.5}) - rig.neutral.vertices
    assert np.allclose(2 * half, posed(firm, {"jaw.rx": 0.4}) - rig.neutral.vertices, atol=1e-14)


def test_a_rig_a_hundred_times_as_large_moves_a_hundred_times_as_far() -> None:
    small, large = (puppet_rig(np.random.default_rng(5), size) for size in (1.0, 100.0))
    values = np.random.default_rng(6).normal(0, 0.2, len(controls_of(small)))
    controls = dict(zip(controls_of(small), values.tolist(), strict=True))
    assert joint_scales(large) == pytest.approx({"head": 100.0, "jaw": 100.0})
    assert np.allclose(posed(large, controls), 100 * posed(small, controls), rtol=1e-10, atol=1e-10)


def test_the_scale_of_a_joint_can_be_told(rig: Rig) -> None:
    once, thrice = (joint_matrices(rig, {"jaw.tx": 0.01}, {"jaw": s})[1, :3, 3] for s in (1.0, 3.0))
    at_rest = joint_matrices(rig, {})[1, :3, 3]
    assert np.allclose(thrice - at_rest, 3 * (once - at_rest))


def test_templates_become_shapes_on_top_of_their_base(rig: Rig) -> None:
    shapes = template_shapes(rig)
    assert shapes.names == ("pull", "open", "shut")
    assert np.allclose(shapes.deltas[1], posed(rig, {"jaw.rx": 0.3}) - rig.neutral.vertices)
    on_top = posed(rig, {"jaw.rx": 0.3, "loose": 1.0}) - posed(rig, {"jaw.rx": 0.3})
    assert np.allclose(shapes.deltas[2], on_top)
    assert np.abs(on_top).max() > 1e-3
    assert template_shapes(rig, ["open"]).names == ("open",)


def test_a_script_plays_as_the_weighted_sum_of_its_templates(rig: Rig, rng: np.random.Generator) -> None:
    script = Clip(("open", "pull"), rng.uniform(0, 1, (4, 2)), 30.0)
    values, names = played(rig, script), controls_of(rig)
    assert values.shape == (4, len(names))
    for row, weights in zip(values, script.values, strict=True):
        told = template_controls(rig, dict(zip(script.names, weights.tolist(), strict=True)))
        assert {n: v for n, v in zip(names, row.tolist(), strict=True) if v} == pytest.approx(told)


def test_every_influence_has_six_controls_and_every_muscle_one_more(rig: Rig) -> None:
    names = controls_of(rig)
    assert len(set(names)) == len(names) == 3 + 6 * (2 + 1 + 2)
    assert {"puller", "ring", "loose"} <= set(names)
    assert {f"jaw.{axis}" for axis in AXES} <= set(names)


def test_an_unknown_control_names_the_nearest(rig: Rig) -> None:
    with pytest.raises(InputError, match=r"jaw_rx.*Did you mean 'jaw\.rx'"):
        Puppet.of(rig).posed({"jaw_rx": 1.0})
    with pytest.raises(InputError, match="finite"):
        posed(rig, {"puller": float("nan")})
    with pytest.raises(InputError, match=r"template.*'opne'.*'open'"):
        template_controls(rig, {"opne": 1.0})


def test_a_bare_mesh_is_a_puppet_without_strings(rig: Rig) -> None:
    bare = replace(rig, anatomy=None, skeleton=None, skin=None)
    assert controls_of(bare) == ()
    assert np.array_equal(posed(bare, {}), rig.neutral.vertices)
    assert template_shapes(bare).names == ()
