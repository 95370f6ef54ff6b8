"""three.js opens what is written, and moves it as mien does."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.core import Rig
from mien.io.gltf import read_rig, write_rigged
from mien.library import actor
from tests.io.rigged_samples import fitted, moved, played, with_anatomy, with_parts
from tests.io.test_gltf_rigged import sheet_file

TOOLS = Path(__file__).parents[1] / "tools"


@pytest.fixture(scope="module")
def three():
    """Return what three.js says about a file after posing or playing it."""
    node = shutil.which("node")
    if node is None or not (TOOLS / "node_modules" / "three").is_dir():
        pytest.skip("three.js is not installed: npm install --no-package-lock in tests/tools")

    def asked(path: Path, **request: Any) -> tuple[dict[str, Any], np.ndarray]:
        question = path.with_suffix(".json")
        question.write_text(json.dumps({"path": str(path), **request}))
        done = subprocess.run([node, str(TOOLS / "pose_in_three.mjs"), str(question)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-2000:]
        said = json.loads(done.stdout)
        return said, np.concatenate([np.array(mesh["vertices"]) for mesh in said["meshes"]])

    return asked


def checked(three, path: Path, rig: Rig) -> dict[str, Any]:
    """Pose the file and play it; its vertices must be where `rig.pose` puts them."""
    clip = played(rig)
    write_rigged(path, rig, {"act": clip, "nod": played(rig, 3)})
    frame, weights = moved(rig)[3], {"joy": 0.7, "tick": 1.3}
    motions = (frame @ np.linalg.inv(rig.skeleton.rest)).tolist()
    said, found = three(path, shapes=weights, motions=motions)
    assert said["animations"] == ["act", "nod"]
    for mesh in said["meshes"]:
        assert mesh["skinned"]
        names = zip(mesh["joints"], rig.skeleton.names, strict=True)
        assert all(shown.startswith(name) for shown, name in names)  # numbered where a mesh is called the same
    count = len(rig.neutral.vertices)
    values = np.array([weights.get(name, 0.0) for name in rig.blendshapes.names])
    assert np.abs(found[:count] - rig.pose(values, frame)).max() < 1e-6
    _, found = three(path, clip="act", time=2 / clip.fps)
    assert np.abs(found[:count] - rig.pose(clip.values[2], clip.joints[2])).max() < 1e-6
    return said


def test_a_new_file_moves_the_same_and_shows_its_anatomy_to_scripts(three, tmp_path):
    rig = with_anatomy(fitted(actor()))
    said = checked(three, tmp_path / "a.glb", rig)
    assert "muscles" in said["anatomy"]


def test_a_turned_scaled_node_with_parts_added_moves_the_same(three, tmp_path):
    _, path = sheet_file(tmp_path / "face.glb")
    checked(three, tmp_path / "a.glb", with_parts(fitted(read_rig(path))))


@pytest.mark.real
@pytest.mark.parametrize("name", ["toon.glb", "variants/adult_meshopt.glb", "variants/adult_quantized.glb"])
def test_real_faces_move_the_same(three, data, tmp_path, name):
    checked(three, tmp_path / "a.glb", fitted(read_rig(data / "rigs" / name)))
