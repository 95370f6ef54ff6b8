"""Damaged and malicious glTF files: one clear FileError, never anything else."""

from __future__ import annotations

import copy
import struct
import tracemalloc

import numpy as np
import pytest

from mien.core import FileError, MienError
from mien.io.gltf import read_clip, read_rig
from tests.io.gltf_samples import FACES, SQUARE, Sample, skinned
from tests.io.hostile import survives

HUGE = 4_000_000_000


def first(root, kind):
    return root[kind][0]


def position(root):
    return root["accessors"][root["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]


DAMAGE = {
    "accessors": lambda r: r.pop("accessors"),
    "asset": lambda r: r.pop("asset"),
    "version": lambda r: r["asset"].update(version="1.0"),
    "count": lambda r: position(r).update(count=HUGE),
    "count of nothing": lambda r: (position(r).pop("bufferView"), position(r).update(count=HUGE)),
    "negative count": lambda r: position(r).update(count=-1),
    "boolean count": lambda r: position(r).update(count=True),
    "offset": lambda r: position(r).update(byteOffset=10**30),
    "component": lambda r: position(r).update(componentType=1),
    "type": lambda r: position(r).update(type="VEC9"),
    "view": lambda r: position(r).update(bufferView=HUGE),
    "stride": lambda r: r["bufferViews"][position(r)["bufferView"]].update(byteStride=1),
    "wide stride": lambda r: r["bufferViews"][position(r)["bufferView"]].update(byteStride=252),
    "buffer": lambda r: first(r, "bufferViews").update(buffer=7),
    "buffer length": lambda r: first(r, "buffers").update(byteLength=HUGE),
    "no data": lambda r: r["buffers"].insert(0, {"byteLength": 10, "uri": "data:;base64,AAAA"}),
    "cycle": lambda r: r["nodes"][2].update(children=[1]),
    "own child": lambda r: r["nodes"][4].update(children=[4]),
    "two parents": lambda r: r["nodes"][3].update(children=[4]),
    "child": lambda r: r["nodes"][0].update(children=[99]),
    "scene": lambda r: r.update(scene=5),
    "root": lambda r: first(r, "scenes").update(nodes=[77]),
    "empty scene": lambda r: first(r, "scenes").update(nodes=[]),
    "mesh": lambda r: r["nodes"][3].update(mesh=12),
    "skin": lambda r: r["nodes"][3].update(skin=12),
    "joints": lambda r: first(r, "skins").update(joints=[1]),
    "joint": lambda r: first(r, "skins").update(joints=[1, 88]),
    "scale": lambda r: [node.update(scale=[1e300, 1e300, 1e300]) for node in r["nodes"][:2]],
    "rotation": lambda r: r["nodes"][1].update(rotation=[0, 0, 0, 0]),
    "text": lambda r: r["nodes"][0].update(translation="here"),
    "huge number": lambda r: r["nodes"][0].update(translation=[10**400, 0, 0]),
    "nodes": lambda r: r.update(nodes={"0": {}}),
    "primitives": lambda r: first(r, "meshes").update(primitives=[3]),
    "attributes": lambda r: r["meshes"][0]["primitives"][0].update(attributes=[]),
    "no position": lambda r: r["meshes"][0]["primitives"][0].update(attributes={}),
    "target": lambda r: r["meshes"][0]["primitives"][0]["targets"][0].update(
        POSITION=r["skins"][0]["inverseBindMatrices"]
    ),
    "sampler": lambda r: r["animations"][0]["channels"][0].update(sampler=9),
    "interpolation": lambda r: r["animations"][0]["samplers"][0].update(interpolation="WILD"),
    "output": lambda r: r["animations"][0]["samplers"][0].update(output=r["animations"][0]["samplers"][1]["output"]),
    "animated node": lambda r: r["animations"][0]["channels"][0]["target"].update(node=55),
    "instances": lambda r: r["nodes"].extend({"mesh": 0} for _ in range(100)) or r["scenes"][0]["nodes"].append(-1),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
def test_what_contradicts_the_format_is_a_file_error_that_names_the_file(tmp_path, damage):
    s = skinned()
    damage(s.root)
    with pytest.raises(FileError, match=r"a\.glb") as caught:
        read_clip(s.save(tmp_path / "a.glb"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_positions_that_are_no_numbers_are_refused(tmp_path, number):
    s = Sample()
    vertices = SQUARE.copy()
    s.mesh(s.primitive(vertices))
    s.node(mesh=0)
    s.binary = s.binary.replace(np.float32(0.5).tobytes(), np.float32(number).tobytes())
    with pytest.raises(FileError, match="element 3"):
        read_rig(s.save(tmp_path / "a.glb"))


def test_vertex_indices_beyond_the_vertices_are_refused(tmp_path):
    s = Sample()
    s.mesh(s.primitive(faces=FACES + 3))
    s.node(mesh=0)
    with pytest.raises(FileError, match="uses vertex 6"):
        read_rig(s.save(tmp_path / "a.glb"))


def test_key_times_of_years_ask_for_no_memory(tmp_path):
    s = skinned(animated=False)
    s.animate((3, "weights", [0, 1e9], np.zeros((2, 2)), "LINEAR"))
    with pytest.raises(FileError, match="too long"):
        read_clip(s.save(tmp_path / "a.glb"))


def test_a_small_file_cannot_ask_for_much_memory(tmp_path):
    s = Sample()
    nothing = s.add("accessors", {"componentType": 5126, "count": 1 << 23, "type": "VEC3"})
    s.mesh({"attributes": {"POSITION": nothing}, "targets": [{"POSITION": nothing}] * 500})
    s.node(mesh=0)
    path = s.save(tmp_path / "a.glb")
    tracemalloc.start()
    with pytest.raises(FileError, match="unfolds"):
        read_rig(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1 << 29


@pytest.mark.parametrize(
    "content",
    [
        b"<!DOCTYPE html><html></html>",
        b"glTF",
        struct.pack("<4sII", b"glTF", 2, HUGE),
        struct.pack("<4sIIII", b"glTF", 2, 20, HUGE, 0x4E4F534A),
        struct.pack("<4sII", b"glTF", 2, 12),
        struct.pack("<4sII", b"glTF", 1, 12),
        b'{"a":' * 100_000,
        b"{" + b'"asset":{"version":NaN}}',
        b'{"asset":{"version":"2.0"},"n":' + b"9" * 5000 + b"}",
        b"\xff\xfe{}",
        b"PK\x03\x04",
    ],
)
def test_what_is_no_gltf_file_is_refused(tmp_path, content):
    (tmp_path / "a.glb").write_bytes(content)
    with pytest.raises(FileError, match=r"a\.glb"):
        read_rig(tmp_path / "a.glb")


def test_cut_and_overwritten_files_only_ever_raise_our_errors(tmp_path, rng):
    survives(read_clip, skinned().save(tmp_path / "a.glb"), rng)


def test_any_value_of_the_json_may_be_anything(tmp_path, rng):
    """Replace one value of the document after another by something of another kind."""
    s = skinned()
    original = s.root
    strange = [None, True, -1, 0, 3, HUGE, 1.5, 1e308, "", "LINEAR", [], [0], [None], {}, {"a": 1}, 10**40]
    refused = 0
    for place in _places(original):
        s.root = copy.deepcopy(original)
        holder = s.root
        for key in place[:-1]:
            holder = holder[key]
        holder[place[-1]] = strange[int(rng.integers(len(strange)))]
        try:
            read_clip(s.save(tmp_path / "a.glb"))
        except MienError:
            refused += 1
    assert refused > 50


def _places(value, above=()):
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield (*above, key)
        yield from _places(inner, (*above, key))


@pytest.mark.real
@pytest.mark.parametrize("variant", ["meshopt", "sparse"])
def test_compressed_real_files_survive_damage(data, tmp_path, rng, variant):
    content = (data / "rigs" / "variants" / f"adult_{variant}.glb").read_bytes()
    (length,) = struct.unpack_from("<I", content, 12)
    path, refused = tmp_path / "a.glb", []
    for _ in range(25):
        changed = bytearray(content)
        for place in rng.integers(20 + length, len(content), 20):
            changed[place] = int(rng.integers(256))
        for place in rng.integers(20, 20 + length, int(rng.integers(0, 3))):
            changed[place] = int(rng.integers(32, 127))
        path.write_bytes(changed)
        try:
            read_rig(path)
        except MienError as error:
            refused.append(str(error))
    assert refused
    assert all(str(path) in said for said in refused)
