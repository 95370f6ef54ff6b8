"""Muscles, templates and landmarks in a glTF file: they come back, and nonsense in their place is no harm."""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest

from mien.core import Anatomy, Clip, InputError, MienError
from mien.io.gltf import read_clip, read_rig, write_clip, write_rig, write_rigged
from tests.conftest import grid_rig
from tests.io.gltf_samples import contents
from tests.io.rigged_samples import fitted, with_anatomy, with_parts
from tests.io.test_gltf_rigged import sheet_file
from tests.io.test_gltf_write import faults, seamed_rig  # noqa: F401


def alike(a: Any, b: Any) -> bool:
    """Whether two nouns are the same, field by field, to single precision."""
    if is_dataclass(a):
        return all(alike(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, Mapping):
        return list(a) == list(b) and all(alike(a[key], b[key]) for key in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(alike(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, np.ndarray):
        return a.shape == b.shape and bool(np.allclose(a, b, rtol=1e-7, atol=1e-9))
    return a == b


def test_an_anatomy_with_one_of_everything_reads_back_the_same(tmp_path, faults):  # noqa: F811
    rig = with_anatomy(fitted(grid_rig()))
    assert all(getattr(rig.anatomy, f.name) for f in fields(Anatomy))
    write_rigged(tmp_path / "a.glb", rig)
    again = read_rig(tmp_path / "a.glb")
    assert again.notes == ()
    assert alike(rig.anatomy, again.anatomy)
    assert alike(rig.landmarks, again.landmarks)
    assert again.anatomy.templates == rig.anatomy.templates
    write_rig(tmp_path / "b.gltf", again)
    assert alike(again.anatomy, read_rig(tmp_path / "b.gltf").anatomy)
    assert faults(tmp_path / "a.glb", tmp_path / "b.gltf") == []


def test_it_is_kept_beside_a_face_of_its_own_and_by_clips_written_later(tmp_path, faults):  # noqa: F811
    _, path = sheet_file(tmp_path / "a.glb")
    rig = with_anatomy(with_parts(fitted(read_rig(path))))
    write_rigged(tmp_path / "b.glb", rig)
    again = read_rig(tmp_path / "b.glb")
    assert alike(rig.anatomy, again.anatomy)
    assert alike(rig.landmarks, again.landmarks)
    write_clip(tmp_path / "c.glb", Clip(("joy",), np.ones((3, 1)), 30), again)
    assert alike(rig.anatomy, read_rig(tmp_path / "c.glb").anatomy)
    assert len(read_clip(tmp_path / "c.glb")) == 3
    assert faults(tmp_path / "c.glb") == []


def test_vertices_copied_along_texture_seams_take_their_values_with_them(tmp_path):
    rig = with_anatomy(fitted(seamed_rig()))
    write_rigged(tmp_path / "a.glb", rig)
    again = read_rig(tmp_path / "a.glb")
    n = len(rig.neutral.vertices)
    assert len(again.anatomy.muscles[1].weights) == len(again.neutral.vertices) > n
    corners, copies = rig.neutral.triangles, again.neutral.triangles
    assert alike(rig.anatomy.muscles[1].weights[corners], again.anatomy.muscles[1].weights[copies])
    assert np.array_equal(rig.anatomy.labels["region"].of[corners], again.anatomy.labels["region"].of[copies])


def test_a_script_with_lost_frames_is_refused(tmp_path):
    rig = with_anatomy(fitted(grid_rig()))
    lost = Clip(("joy",), np.full((2, 1), np.nan), 30)
    with pytest.raises(InputError, match="not tracked"):
        write_rigged(tmp_path / "a.glb", replace(rig, anatomy=replace(rig.anatomy, scripts={"lost": lost})))
    assert list(tmp_path.iterdir()) == []


NONSENSE: list[Any] = [
    None, 5, -1, 1.5, 1e300, 10**400, True, "x", "\ud800", [], {}, [None], [[1]], [1e9], {"shape": [3]}, {"accessor": 0},
    {"shape": [36], "accessor": 0}, {"shape": [1 << 40], "accessor": 3}, {"shape": [0]}, {"shape": [2] * 40},
    {"shape": [], "accessor": 0}, {"name": "x"}, ["brow", "brow", "x"],
]  # fmt: skip


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(place for key, item in inner for place in places(item, (*path, key)))]


def changed(value: Any, path: tuple[Any, ...], into: Any) -> Any:
    result = copy.deepcopy(value)
    holder = result
    for key in path[:-1]:
        holder = holder[key]
    holder[path[-1]] = into
    return result


def test_nonsense_anywhere_in_the_extras_gives_a_note_or_another_value_but_never_a_failure(tmp_path, rng):
    write_rigged(tmp_path / "a.gltf", with_anatomy(fitted(grid_rig())))
    root = json.loads((tmp_path / "a.gltf").read_text())
    spots = [("extras", *place) for place in places(root["extras"])[1:]]
    unread = 0
    for i in rng.choice(len(spots), 150):
        bad = changed(root, spots[i], NONSENSE[rng.integers(len(NONSENSE))])
        (tmp_path / "b.gltf").write_text(json.dumps(bad))
        rig = read_rig(tmp_path / "b.gltf")
        unread += any(note.code == "anatomy-unread" for note in rig.notes)
        assert len(rig.neutral.vertices) == 36
    assert unread > 100


def test_accessors_that_a_program_renumbered_are_not_mistaken_for_the_anatomys(tmp_path):
    write_rigged(tmp_path / "a.gltf", with_anatomy(fitted(grid_rig())))
    root = json.loads((tmp_path / "a.gltf").read_text())
    muscle = root["extras"]["mien"]["anatomy"]["muscles"][1]["weights"]
    cluster = root["extras"]["mien"]["anatomy"]["clusters"][0]["weights"]
    muscle["accessor"], cluster["accessor"] = cluster["accessor"], muscle["accessor"]
    (tmp_path / "a.gltf").write_text(json.dumps(root))
    rig = read_rig(tmp_path / "a.gltf")
    assert rig.anatomy is None
    assert [note.code for note in rig.notes] == ["anatomy-unread"]
    assert "accessors[" in rig.notes[0].message


def test_stored_numbers_that_are_not_finite_or_out_of_range_give_a_note(tmp_path):
    write_rigged(tmp_path / "a.glb", with_anatomy(fitted(grid_rig())))
    root, data = contents(tmp_path / "a.glb")
    accessor = root["accessors"][root["extras"]["mien"]["anatomy"]["clusters"][0]["weights"]["accessor"]]
    start = root["bufferViews"][accessor["bufferView"]]["byteOffset"]
    content = (tmp_path / "a.glb").read_bytes()
    at = content.index(data) + start
    for number in (np.nan, np.inf, -0.5, 2):
        (tmp_path / "b.glb").write_bytes(content[:at] + np.float32(number).tobytes() + content[at + 4 :])
        rig = read_rig(tmp_path / "b.glb")
        assert rig.anatomy is None
        assert [note.code for note in rig.notes] == ["anatomy-unread"]


def test_a_file_without_any_has_none(tmp_path):
    write_rig(tmp_path / "a.glb", grid_rig())
    rig = read_rig(tmp_path / "a.glb")
    assert rig.anatomy is None
    assert rig.landmarks == {}
    assert "extras" not in contents(tmp_path / "a.glb")[0]
    with pytest.raises(MienError):
        read_rig(tmp_path / "b.glb")
