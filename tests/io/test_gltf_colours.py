"""The colours of materials: read where they say something, kept when written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.core import FileError, Rig
from mien.io.gltf import read_rig, write_rig, write_rigged
from mien.look.parts import surface_of
from tests.conftest import grid_rig
from tests.io.gltf_samples import Sample


def painted() -> Rig:
    rig = grid_rig()
    ids = np.arange(36)
    groups = {"all": ids, "top": ids[12:], "horn": ids[24:]}
    colours = {"all": (0.1, 0.6, 0.2), "top": (0.25, 0.5, 0.75), "horn": (0.05, 0.04, 0.03)}
    return replace(rig, neutral=replace(rig.neutral, groups=groups), colours=colours)


@pytest.mark.parametrize("write", [write_rig, write_rigged])
def test_a_rigs_colours_survive_the_file(tmp_path: Path, write: Any) -> None:
    rig = painted()
    write(tmp_path / "a.glb", rig)
    again = read_rig(tmp_path / "a.glb")
    assert np.abs(surface_of(again).colours - surface_of(rig).colours).max() < 1e-6
    write(tmp_path / "b.glb", replace(again, source=None))
    assert np.abs(surface_of(read_rig(tmp_path / "b.glb")).colours - surface_of(rig).colours).max() < 1e-6


def test_colours_given_to_the_writer_replace_the_rigs_own(tmp_path: Path) -> None:
    write_rig(tmp_path / "a.glb", painted(), colours={"horn": (0.5, 0.25, 0.125)})
    assert list(read_rig(tmp_path / "a.glb").colours.values()) == [(0.5, 0.25, 0.125)]


def read_with(tmp_path: Path, material: dict[str, Any] | None) -> Rig:
    s = Sample()
    more = {} if material is None else {"material": s.add("materials", material)}
    s.node(name="thing", mesh=s.mesh(s.primitive(**more)))
    return read_rig(s.save(tmp_path / "a.glb"))


def test_the_material_of_a_mesh_with_only_one_colours_all_of_it(tmp_path: Path) -> None:
    material = {"name": "jade", "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.5, 0.3, 1]}}
    assert read_with(tmp_path, material).colours == {"thing": (0.1, 0.5, 0.3)}


@pytest.mark.parametrize(
    "material",
    [
        None,
        {},
        {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1]}},
        {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": {"index": 0}}},
        {"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.7, 0.9, 0.1]}},
        {"pbrMetallicRoughness": {"baseColorFactor": [4.0, 0.5, 0.5, 1]}},
    ],
)
def test_white_textured_and_see_through_materials_say_no_colour(
    tmp_path: Path, material: dict[str, Any] | None
) -> None:
    assert read_with(tmp_path, material).colours == {}


def test_what_a_rig_without_colours_is_written_in_is_not_read_as_its_own(tmp_path: Path) -> None:
    write_rig(tmp_path / "a.glb", grid_rig())
    assert read_rig(tmp_path / "a.glb").colours == {}


def test_a_colour_that_is_no_list_of_numbers_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="baseColorFactor"):
        read_with(tmp_path, {"pbrMetallicRoughness": {"baseColorFactor": "red"}})
