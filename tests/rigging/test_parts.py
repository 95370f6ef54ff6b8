"""What a part of a head follows: its counterpart, the skin under it, or what it lies within."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mien.core import Mesh
from mien.core.units import human_centimetre
from mien.rigging.dense import DenseFit
from mien.rigging.parts import attachments
from tests.rigging.faces import exact_fit, sheet

BALL = np.array([[1, 2, 4], [2, 0, 4], [0, 3, 4], [3, 1, 4], [2, 1, 5], [0, 2, 5], [3, 0, 5], [1, 3, 5]])
"""An octahedron: much of its box is far from it."""


@pytest.fixture
def fit() -> DenseFit:
    """A face with a ball close behind its skin, laid on itself."""
    skin, triangles = sheet(np.linspace(-0.08, 0.08, 25), np.linspace(-0.08, 0.08, 25))
    ball = np.array([0.0, 0.0, 0.084]) + 0.012 * np.concatenate([np.eye(3), -np.eye(3)])[[0, 3, 1, 4, 2, 5]]
    mesh = Mesh(np.vstack([skin, ball]), np.vstack([triangles, BALL + len(skin)]))
    return exact_fit(mesh, mesh, np.arange(len(mesh.vertices)) < len(skin))


def with_part(fit: DenseFit, middle: list[float]) -> DenseFit:
    """The same, the target with a small triangle more."""
    more = np.array(middle) + 0.0004 * np.array([[1.0, 0, 0], [-1, 1, 0], [-1, -1, 0]])
    count = len(fit.target.vertices)
    target = Mesh(np.vstack([fit.target.vertices, more]), np.vstack([fit.target.triangles, [np.arange(3) + count]]))
    return replace(fit, target=target, target_skin=np.append(fit.target_skin, [False] * 3))


def test_a_part_within_a_ball_follows_the_ball(fit: DenseFit) -> None:
    lens = attachments(with_part(fit, [0.0, 0.0, 0.089]))[-1]
    assert lens.counterpart
    assert set(lens.followed) == set(np.flatnonzero(~fit.source_skin))


def test_a_lash_in_the_box_of_a_ball_rides_on_the_lid_it_is_nearer_to(fit: DenseFit) -> None:
    place = [0.0105, 0.0105, 0.0955]
    lash = attachments(with_part(fit, place))[-1]
    off = np.linalg.norm(fit.target.vertices[fit.target_skin] - place, axis=1).min()
    assert off > 0.15 * human_centimetre(fit.warp.centres)  # it does not lie on the skin
    assert not lash.counterpart
