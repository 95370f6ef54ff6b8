"""The characters for the layers: every extreme, whole meshes, and eyes and mouths that close."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

from mien.core import Rig
from mien.core.arrays import Floats
from mien.io import gltf
from mien.io.formats import read_rig
from mien.library.characters import globe, radio
from mien.library.characters.globe import COLOURS as GLOBE_COLOURS
from mien.library.characters.globe import MASKS as GLOBE_MASKS
from mien.library.characters.radio import COLOURS as RADIO_COLOURS
from mien.library.characters.radio import MASKS as RADIO_MASKS
from mien.retargeting.layers import rig_face
from mien.vocabularies.expressions import BLINKS, LAYER_EMOTIONS, LAYER_REGION, VISEMES

MAKERS: Mapping[str, Any] = {"globe": globe, "radio": radio}
MASKS = {"globe": GLOBE_MASKS, "radio": RADIO_MASKS}
COLOURS = {"globe": GLOBE_COLOURS, "radio": RADIO_COLOURS}
MOUTHS = {"globe": "mouths", "radio": "compartment"}
EYES = {"globe": "eyes", "radio": "speakers"}
REST = ("neutral", "blink_open")
BALLS = {
    "globe": {f"eyeball_{n}": f"lids_{n}" for n in range(1, 6)},
    "radio": {f"cap_{side}": f"lids_{side}" for side in ("left", "right")},
}
"""The balls that see, and the lids that close over them."""


@pytest.fixture(params=list(MAKERS))
def rig(request: pytest.FixtureRequest) -> Rig:
    return MAKERS[request.param]()


def posed(rig: Rig, extreme: str) -> Floats:
    return np.asarray(rig.neutral.vertices + rig.blendshapes.deltas[rig.blendshapes.index(extreme)])


def moving(rig: Rig, extreme: str) -> set[str]:
    reach = np.linalg.norm(rig.blendshapes.deltas[rig.blendshapes.index(extreme)], axis=1)
    return {mask for mask in MASKS[rig.name] if reach[rig.neutral.groups[mask]].max() > 1e-9}


def test_the_masks_share_out_the_vertices(rig: Rig) -> None:
    together = np.concatenate([rig.neutral.groups[mask] for mask in MASKS[rig.name]])
    assert np.array_equal(np.sort(together), np.arange(len(rig.neutral.vertices)))
    assert tuple(rig.neutral.groups)[:3] == MASKS[rig.name]
    told = rig.anatomy.labels[LAYER_REGION]
    assert told.names == MASKS[rig.name]
    for k, mask in enumerate(told.names):
        assert np.array_equal(np.flatnonzero(told.of == k), np.sort(rig.neutral.groups[mask]))


def test_a_file_keeps_the_masks(rig: Rig, tmp_path: Path) -> None:
    gltf.write_rig(tmp_path / "it.glb", rig)
    again = rig_face(read_rig(tmp_path / "it.glb"))
    assert again.regions.names == MASKS[rig.name]
    assert np.array_equal(again.regions.of, rig_face(rig).regions.of)
    named = rig_face(read_rig(tmp_path / "it.glb"), masks=MASKS[rig.name][::-1])
    assert named.regions.names == MASKS[rig.name][::-1]


def test_all_extremes_are_there_in_the_order_of_the_layers(rig: Rig) -> None:
    assert rig.blendshapes.names == (*LAYER_EMOTIONS, *VISEMES, *BLINKS)
    assert rig.blendshapes.empty == REST


def test_sounds_move_only_mouths_and_blinks_only_eyes(rig: Rig) -> None:
    assert {frozenset(moving(rig, name)) for name in VISEMES} == {frozenset({MOUTHS[rig.name]})}
    assert moving(rig, "blink_half") == moving(rig, "blink_closed") == {EYES[rig.name]}


def test_every_emotion_moves_mouths_and_eyes(rig: Rig) -> None:
    for name in LAYER_EMOTIONS[1:]:
        assert {MOUTHS[rig.name], EYES[rig.name]} <= moving(rig, name), name


LAYERS = {"emotions": LAYER_EMOTIONS, "visemes": tuple(VISEMES), "blinks": BLINKS}


@pytest.mark.parametrize(("layer", "least"), [("emotions", 0.001), ("visemes", 0.0007), ("blinks", 0.001)])
def test_any_two_extremes_of_a_layer_differ_visibly(rig: Rig, layer: str, least: float) -> None:
    """By the root mean square [m] over what the layer moves."""
    parts = {"emotions": MASKS[rig.name], "visemes": (MOUTHS[rig.name],), "blinks": (EYES[rig.name],)}[layer]
    ids = np.concatenate([rig.neutral.groups[part] for part in parts])
    d = np.stack([rig.blendshapes.deltas[rig.blendshapes.index(n)][ids].ravel() for n in LAYERS[layer]])
    assert pdist(d).min() / np.sqrt(len(ids)) > least


@pytest.mark.parametrize("layer", list(LAYERS))
def test_the_extremes_of_a_layer_span_a_simplex(rig: Rig, layer: str) -> None:
    d = np.stack([rig.blendshapes.deltas[rig.blendshapes.index(n)].ravel() for n in LAYERS[layer]])
    d = d[1:] - d[0]
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    assert np.linalg.cond(d @ d.T) < 1e6


def test_a_stronger_degree_of_an_emotion_goes_further(rig: Rig) -> None:
    for three in (("serenity", "joy", "ecstasy"), ("apprehension", "fear", "terror"), ("annoyance", "anger", "rage")):
        reach = [np.linalg.norm(rig.blendshapes.deltas[rig.blendshapes.index(name)]) for name in three]
        assert reach == sorted(reach)


def test_no_extreme_has_a_degenerate_triangle(rig: Rig) -> None:
    t = rig.neutral.triangles
    for name in rig.blendshapes.names:
        v = posed(rig, name)
        edges = np.linalg.norm(v[t] - v[np.roll(t, 1, axis=1)], axis=2).max(axis=1)
        height = np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1) / edges
        assert height.min() > 1e-6, (name, height.argmin())


def test_the_mesh_is_closed_and_faces_outwards(rig: Rig) -> None:
    t = rig.neutral.triangles
    directed = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed)
    assert np.array_equal(np.unique(directed, axis=0), np.unique(directed[:, ::-1], axis=0))
    assert np.array_equal(np.unique(t), np.arange(len(rig.neutral.vertices)))
    ends = (np.ones(len(directed)), (directed[:, 0], directed[:, 1]))
    _, piece = connected_components(coo_matrix(ends, (t.max() + 1, t.max() + 1)), directed=False)
    volume = np.linalg.det(rig.neutral.vertices[t])
    assert (np.bincount(piece[t[:, 0]], weights=volume) > 0).all()


def test_eyeballs_stay_balls(rig: Rig) -> None:
    for name in rig.blendshapes.names:
        for ball in BALLS[rig.name]:
            points = posed(rig, name)[rig.neutral.groups[ball]]
            system = np.column_stack([2 * points, np.ones(len(points))])
            fit = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=None)[0]
            radius = np.linalg.norm(points - fit[:3], axis=1)
            assert np.ptp(radius) < 1e-6 * radius.mean(), (name, ball)


def test_closed_lids_hide_the_eyeballs(rig: Rig) -> None:
    t = rig.neutral.triangles
    for ball, over in BALLS[rig.name].items():
        lids = t[np.isin(t, rig.neutral.groups[over]).all(axis=1)]
        ids = rig.neutral.groups[ball]
        for view in ((0.0, 0.0, 1.0), (-0.4, 0.1, 1.0)):
            towards = np.array(view) / np.linalg.norm(view)
            front = ids[(rig.neutral.vertices[ids] - rig.neutral.vertices[ids].mean(axis=0)) @ towards > 0]
            assert all(meets(posed(rig, "blink_closed"), lids, i, towards) for i in front), (ball, view)
            assert not all(meets(rig.neutral.vertices, lids, i, towards) for i in front), (ball, view)


def meets(v: Floats, t: np.ndarray, vertex: int, towards: Floats) -> bool:
    """Return whether a ray from a vertex meets a triangle (Möller and Trumbore 1997)."""
    side, across = v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]
    p = np.cross(towards, across)
    size = (side * p).sum(axis=1)
    crossed = np.abs(size) > 1e-18
    off = v[vertex] - v[t[:, 0]]
    q = np.cross(off, side)
    x, y, z = ((a * b).sum(axis=1)[crossed] / size[crossed] for a, b in ((off, p), (q, towards), (across, q)))
    return bool(((x >= 0) & (y >= 0) & (x + y <= 1) & (z > 0)).any())


def gap(rig: Rig, extreme: str) -> float:
    """Return how far the lips of the widest open mouth are apart [m]."""
    v, groups = posed(rig, extreme), rig.neutral.groups
    if rig.name == "radio":
        pairs = [("door_rim", "door_frame")]
    else:
        pairs = [(f"upper_lip_{n}", f"lower_lip_{n}") for n in range(1, 5)]
    return max(float(cKDTree(v[groups[b]]).query(v[groups[a]])[0].max()) for a, b in pairs)


def test_p_b_m_close_all_mouths(rig: Rig) -> None:
    assert gap(rig, "viseme_PP") < 0.0003
    assert gap(rig, "viseme_aa") > 0.01


def test_vowels_open_the_mouths_wider_than_consonants(rig: Rig) -> None:
    closed = max(gap(rig, f"viseme_{sound}") for sound in ("PP", "FF", "SS"))
    assert gap(rig, "viseme_aa") > gap(rig, "viseme_E") > gap(rig, "viseme_I") > closed


def test_colours_are_of_groups_and_paint_every_triangle(rig: Rig) -> None:
    colours = COLOURS[rig.name]
    t = rig.neutral.triangles
    assert np.any([np.isin(t, rig.neutral.groups[group]).all(axis=1) for group in colours], axis=0).all()
    assert all(0 <= band <= 1 for colour in colours.values() for band in colour)


def test_characters_are_as_large_as_a_head(rig: Rig) -> None:
    wide, tall, deep = np.ptp(rig.neutral.vertices, axis=0)
    assert 0.21 < tall < 0.25
    assert wide < 0.3
    assert deep < 0.25


def test_building_repeats_itself(rig: Rig) -> None:
    again = MAKERS[rig.name].__wrapped__()
    assert np.array_equal(again.neutral.vertices, rig.neutral.vertices)
    assert np.array_equal(again.neutral.triangles, rig.neutral.triangles)
    assert np.array_equal(again.blendshapes.deltas, rig.blendshapes.deltas)
