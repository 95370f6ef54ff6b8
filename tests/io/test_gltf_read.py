"""Reading glTF characters: geometry in world space, shapes by name, skins, encodings."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from mien.core import FileError
from mien.io.gltf import read_rig
from mien.io.gltf.fields import Fields
from mien.io.gltf.meshopt import decoded
from tests.io.gltf_samples import FACES, SQUARE, Sample, matrix, skinned, turn

STREAMS = json.loads((Path(__file__).parent / "meshopt_streams.json").read_text())


def moved(m, points):
    return points @ m[:3, :3].T + m[:3, 3]


def test_nested_nodes_with_scale_put_the_neutral_and_the_deltas_in_world_space(tmp_path, rng):
    s = Sample()
    delta = np.float32(rng.normal(0, 0.1, (4, 3)))
    s.mesh(s.primitive(deltas=[delta]), shapes=["a"])
    s.node(translation=[1, 2, 3], rotation=turn(1, 0.7).tolist(), children=[1])
    s.node(root=False, mesh=0, scale=[2, 0.5, 3], translation=[0, 1, 0])
    world = matrix((1, 2, 3), turn(1, 0.7)) @ matrix((0, 1, 0), scale=(2, 0.5, 3))
    rig = read_rig(s.save(tmp_path / "a.glb"))
    assert np.allclose(rig.neutral.vertices, moved(world, SQUARE), atol=1e-12)
    assert np.allclose(rig.blendshapes.deltas[0], delta @ world[:3, :3].T, atol=1e-12)
    assert rig.skeleton is None
    assert np.array_equal(rig.neutral.triangles, FACES)


def test_a_mirrored_node_keeps_triangles_counter_clockwise_from_outside(tmp_path):
    s = Sample()
    s.mesh(s.primitive())
    s.node(mesh=0, scale=[-1, 1, 1])
    rig = read_rig(s.save(tmp_path / "a.glb"))
    a, b, c = rig.neutral.vertices[rig.neutral.triangles[0]]
    assert np.cross(b - a, c - a)[2] > 0


def test_shapes_of_the_same_name_on_several_meshes_are_one_shape(tmp_path, rng):
    s = Sample()
    d = np.float32(rng.normal(0, 0.1, (4, 4, 3)))
    s.mesh(s.primitive(deltas=d[:2]), shapes=["smile", "jaw"], name="head")
    s.mesh(s.primitive(deltas=d[2:]), shapes=["jaw", "tongue"], name="teeth")
    s.node(mesh=1, name="teeth")
    s.node(mesh=0, name="head")
    rig = read_rig(s.save(tmp_path / "a.glb"))
    assert rig.blendshapes.names == ("jaw", "tongue", "smile")
    assert {name: list(ids) for name, ids in rig.neutral.groups.items()} == {
        "teeth": [0, 1, 2, 3],
        "head": [4, 5, 6, 7],
    }
    jaw = rig.blendshapes.deltas[0]
    assert np.array_equal(jaw, np.concatenate([d[2], d[1]]))
    assert not rig.blendshapes.deltas[1, 4:].any()


def test_primitives_that_share_their_positions_share_their_vertices(tmp_path):
    s = Sample()
    s.add("materials", {"name": "skin"})
    s.add("materials", {})
    one = s.primitive(faces=FACES[:1], material=0)
    two = {"attributes": one["attributes"], "indices": s.array(FACES[1:].ravel()), "material": 1}
    points = {"attributes": one["attributes"], "mode": 0}
    s.mesh(one, two, points, s.primitive(SQUARE + 5), name="face")
    s.node(mesh=0)
    rig = read_rig(s.save(tmp_path / "a.glb"))
    assert len(rig.neutral.vertices) == 8
    assert np.array_equal(rig.neutral.triangles, np.concatenate([FACES, FACES + 4]))
    assert list(rig.neutral.groups["face/skin"]) == [0, 1, 2]
    assert list(rig.neutral.groups["face/material_01"]) == [1, 2, 3]
    assert [note.code for note in rig.notes] == ["not-triangles"]


@pytest.mark.parametrize(
    ("mode", "order", "triangles"),
    [
        (5, [0, 1, 2, 3], [[0, 1, 2], [1, 3, 2]]),
        (6, [1, 3, 2, 0], [[3, 2, 1], [2, 0, 1]]),
        (5, [0, 1, 2, 2], [[0, 1, 2]]),
    ],
)
def test_strips_and_fans_become_triangles(tmp_path, mode, order, triangles):
    s = Sample()
    s.mesh(s.primitive(faces=np.array(order, np.uint8), mode=mode))
    s.node(mesh=0)
    got = read_rig(s.save(tmp_path / "a.glb")).neutral.triangles
    canonical = [np.roll(t, -int(np.argmin(t))).tolist() for t in got]
    assert canonical == [np.roll(t, -int(np.argmin(t))).tolist() for t in triangles]


def test_texture_coordinates_are_per_corner_and_may_be_normalized(tmp_path):
    s = Sample()
    uv = np.array([[0, 0], [255, 0], [0, 255], [255, 51]], np.uint8)
    s.mesh(s.primitive(attributes={"TEXCOORD_0": s.array(uv, normalized=True)}))
    s.node(mesh=0)
    assert np.allclose(read_rig(s.save(tmp_path / "a.glb")).neutral.uv, (uv / 255)[FACES])


def test_missing_short_and_repeated_shape_names_are_made_distinct_and_noted(tmp_path):
    s = Sample()
    s.mesh(s.primitive(deltas=[SQUARE, None, SQUARE, SQUARE]), shapes=["a", "b", "a"], weights=[0, 0.5, 0, 0])
    s.node(mesh=0)
    rig = read_rig(s.save(tmp_path / "a.glb"))
    assert rig.blendshapes.names == ("a", "b", "a_2", "shape_03")
    assert rig.blendshapes.empty == ("b",)
    assert [note.code for note in rig.notes] == ["shape-renamed", "default-weights"]


@pytest.mark.parametrize("dtype", ["int8", "uint8", "int16", "uint16"])
@pytest.mark.parametrize("normalized", [True, False])
def test_quantised_interleaved_positions_are_read(tmp_path, dtype, normalized, rng):
    s = Sample()
    top = np.iinfo(dtype).max
    q = rng.integers(0, top, (4, 4)).astype(dtype)
    stride = -(-q.itemsize * 4 // 4) * 4
    rows = np.zeros((4, stride), np.uint8)
    rows[:, : q.itemsize * 4] = q.view(np.uint8).reshape(4, -1)
    view = s.view(b"\0" * 4 + rows.tobytes()[: -q.itemsize], byteStride=stride)
    accessor = {"bufferView": view, "byteOffset": 4, "count": 4, "type": "VEC3"}
    more = {"normalized": True} if normalized else {}
    position = s.add(
        "accessors", {**accessor, "componentType": {1: 5120, 2: 5122}[q.itemsize] + (dtype[0] == "u"), **more}
    )
    s.mesh({"attributes": {"POSITION": position}, "indices": s.array(FACES.ravel())})
    s.node(mesh=0)
    expected = q[:, :3] / (top if normalized else 1)
    assert np.allclose(read_rig(s.save(tmp_path / "a.glb")).neutral.vertices, expected, rtol=1e-12)


@pytest.mark.parametrize("based", [True, False])
def test_sparse_targets_replace_rows_of_their_base_or_of_zeros(tmp_path, based):
    s = Sample()
    base = np.float32(np.arange(12).reshape(4, 3)) if based else np.zeros((4, 3), np.float32)
    sparse = {
        "count": 2,
        "indices": {"bufferView": s.view(np.array([1, 3], np.uint16).tobytes()), "componentType": 5123},
        "values": {"bufferView": s.view(np.float32([[1, 2, 3], [4, 5, 6]]).tobytes())},
    }
    more = {"bufferView": s.view(base.tobytes())} if based else {}
    target = s.add("accessors", {"componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse, **more})
    primitive = s.primitive()
    primitive["targets"] = [{"POSITION": target}]
    s.mesh(primitive)
    s.node(mesh=0)
    base[[1, 3]] = [[1, 2, 3], [4, 5, 6]]
    rig = read_rig(s.save(tmp_path / "a.glb"))
    assert rig.blendshapes.names == ("shape_00",)
    assert np.array_equal(rig.blendshapes.deltas[0], base)


def test_only_the_default_scene_is_read(tmp_path):
    s = Sample()
    s.mesh(s.primitive())
    s.node(mesh=0)
    hidden = s.node(root=False, mesh=0, translation=[9, 9, 9])
    s.add("scenes", {"nodes": [hidden]})
    assert len(read_rig(s.save(tmp_path / "a.glb")).neutral.vertices) == 4
    s.root["scene"] = 1
    assert read_rig(s.save(tmp_path / "a.glb")).neutral.vertices.min() == 9


@pytest.mark.parametrize("embedded", [True, False])
def test_a_text_document_with_its_buffer_inside_or_beside_it_reads_the_same(tmp_path, embedded):
    s = skinned()
    expected = read_rig(s.save(tmp_path / "a.glb"))
    (tmp_path / "my data.bin").write_bytes(s.binary)
    encoded = "data:application/octet-stream;base64," + base64.b64encode(s.binary).decode()
    s.root["buffers"][0]["uri"] = encoded if embedded else "my%20data.bin"
    (tmp_path / "a.gltf").write_text(json.dumps(s.root))
    rig = read_rig(tmp_path / "a.gltf")
    assert np.array_equal(rig.neutral.vertices, expected.neutral.vertices)
    assert np.array_equal(rig.blendshapes.deltas, expected.blendshapes.deltas)


@pytest.mark.parametrize(
    "uri", ["../secret.bin", "/etc/hostname", "https://example.org/a.bin", "file:///etc/hostname", "a\0b"]
)
def test_addresses_outside_the_folder_are_refused(tmp_path, uri):
    (tmp_path / "secret.bin").write_bytes(b"0" * 1000)
    folder = tmp_path / "in"
    folder.mkdir()
    s = skinned()
    s.root["buffers"][0]["uri"] = uri
    (folder / "a.gltf").write_text(json.dumps(s.root))
    with pytest.raises(FileError, match=r"buffers\[0\]"):
        read_rig(folder / "a.gltf")


def test_an_unknown_required_extension_is_named(tmp_path):
    s = skinned()
    s.root["extensionsRequired"] = ["KHR_materials_unlit", "ACME_curves"]
    with pytest.raises(FileError, match="ACME_curves"):
        read_rig(s.save(tmp_path / "a.glb"))


def test_skin_weights_are_scaled_to_one_and_loose_vertices_follow_their_node(tmp_path):
    s = skinned(animated=False)
    off = np.float32([[2, 2, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0], [0.25] * 4])
    s.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = s.array(off)
    rig = read_rig(s.save(tmp_path / "a.glb"))
    assert np.allclose(rig.skin.weights.sum(1), 1)
    assert rig.skeleton.names == ("neck", "mixamorig:Head", "body", "eye")
    assert list(rig.skeleton.parents) == [-1, 0, -1, 1]
    assert rig.skin.joints[2, 0] == 2
    assert np.allclose(rig.neutral.vertices[2], SQUARE[2])
    assert {note.code for note in rig.notes} == {"skin-weights", "unskinned"}


def test_a_mesh_scaled_to_nothing_at_rest_stays_posable(tmp_path):
    s = skinned()
    s.root["nodes"][4]["scale"] = [0, 0, 0]
    rig = read_rig(s.save(tmp_path / "a.glb"))
    assert "collapsed" in {note.code for note in rig.notes}
    posed = rig.pose(np.zeros(2), np.array(rig.skeleton.rest))
    assert np.allclose(posed, rig.neutral.vertices)


@pytest.mark.parametrize("stream", STREAMS, ids=lambda stream: stream["name"])
def test_meshopt_streams_decode_as_the_reference_does(stream):
    packed = Fields(
        Path("a.glb"), "view", {k: stream[k] for k in ("mode", "filter", "count")} | {"byteStride": stream["stride"]}
    )
    assert decoded(packed, memoryview(base64.b64decode(stream["encoded"]))) == base64.b64decode(stream["decoded"])


@pytest.mark.parametrize("stream", STREAMS, ids=lambda stream: stream["name"])
def test_damaged_meshopt_streams_are_refused_or_decode_to_the_right_size(stream, rng):
    content = base64.b64decode(stream["encoded"])
    size = stream["count"] * stream["stride"]
    for _ in range(60):
        broken = bytearray(content[: int(rng.integers(0, len(content) + 1))] if rng.random() < 0.5 else content)
        if broken:
            broken[int(rng.integers(len(broken)))] = int(rng.integers(256))
        fields = {k: stream[k] for k in ("mode", "filter", "count")} | {"byteStride": stream["stride"]}
        with np.errstate(all="ignore"):
            try:
                assert len(decoded(Fields(Path("a.glb"), "view", fields), memoryview(broken))) == size
            except FileError:
                continue


@pytest.mark.real
def test_real_rigs_have_the_documented_sizes(data):
    sizes = {
        "makehuman_adult": (4836, 67),
        "makehuman_child": (5186, 67),
        "ict_head": (26719, 57),
        "ict_face": (9409, 57),
    }
    for name, (vertices, shapes) in {**sizes, "toon": (9409, 40), "aura": (5944, 72)}.items():
        rig = read_rig(data / "rigs" / f"{name}.glb")
        assert rig.blendshapes.deltas.shape == (shapes, vertices, 3)
        assert rig.notes == ()


@pytest.mark.real
@pytest.mark.parametrize(
    ("variant", "tolerance"), [("draco", 1e-5), ("meshopt", 4e-5), ("quantized", 4e-5), ("sparse", 0)]
)
def test_every_encoding_of_the_adult_is_the_same_adult(data, variant, tolerance):
    if variant == "draco":
        pytest.importorskip("DracoPy")
    adult = read_rig(data / "rigs" / "makehuman_adult.glb")
    other = read_rig(data / "rigs" / "variants" / f"adult_{variant}.glb")
    same = cKDTree(adult.neutral.vertices).query(other.neutral.vertices)[1]
    assert np.abs(other.neutral.vertices - adult.neutral.vertices[same]).max() <= tolerance
    assert len(np.unique(same)) == len(adult.neutral.vertices)
    assert np.abs(other.blendshapes.deltas - adult.blendshapes.deltas[:, same]).max() <= tolerance
    assert _turned_to_start(same[other.neutral.triangles]) == _turned_to_start(adult.neutral.triangles)


def _turned_to_start(triangles):
    start = np.argmin(triangles, axis=1)[:, None]
    return set(map(tuple, np.take_along_axis(triangles, (start + np.arange(3)) % 3, axis=1).tolist()))
