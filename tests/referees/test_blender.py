"""Blender's own importer opens what is written, and moves it as mien does.

Blender as a module lives in an environment of its own (`pip install bpy "numpy<2"` with
Python 3.11); name its interpreter with MIEN_BLENDER_PYTHON.
"""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.core import Rig
from mien.io.gltf import read_rig, write_rigged
from mien.library import actor
from tests.io.gltf_samples import matrix, turn
from tests.io.rigged_samples import fitted, moved, played, with_anatomy, with_parts

PROBE = Path(__file__).with_name("blender_probe.py")
WEIGHTS = {"joy": 0.7, "tick": 1.0}


@pytest.fixture(scope="module")
def blender():
    """Return what Blender says about a file, after playing it to some frames or posing it."""
    python = os.environ.get("MIEN_BLENDER_PYTHON")
    if not python:
        pytest.skip("no Blender: name a Python that has bpy with MIEN_BLENDER_PYTHON")

    def asked(path: Path, **request: Any) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        question, answer = path.with_suffix(".json"), path.with_suffix(".npz")
        question.write_text(json.dumps({"path": str(path), **request}))
        done = subprocess.run([python, str(PROBE), str(question), str(answer)], capture_output=True, text=True)
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        with np.load(answer) as arrays:
            return json.loads(str(arrays["said"])), {name: arrays[name] for name in arrays if name != "said"}

    return asked


def used(rig: Rig) -> np.ndarray:
    """Blender leaves out the vertices that no triangle uses."""
    return np.unique(rig.neutral.triangles)


def checked(blender, path: Path, rig: Rig, clips: dict[str, Any]) -> None:
    """Write the rig; Blender must find everything of it, and put its vertices where `rig.pose` does."""
    write_rigged(path, rig)
    frame = moved(rig)[3]
    motions = frame @ np.linalg.inv(rig.skeleton.rest)
    request = {"shapes": WEIGHTS, "motions": dict(zip(rig.skeleton.names, motions.tolist(), strict=True))}
    said, arrays = blender(path, **request)
    assert set(rig.skeleton.names) <= set(said["bones"])
    for mesh in said["meshes"]:
        assert set(said["groups"][mesh]) == set(rig.skeleton.names)
        assert np.allclose(said["weights"][mesh], 1, atol=1e-6)
    assert set(rig.blendshapes.names) <= {name for names in said["shapes"].values() for name in names}
    weights = np.array([WEIGHTS.get(name, 0.0) for name in rig.blendshapes.names])
    same(arrays, "rest", rig, rig.neutral.vertices)
    same(arrays, "posed", rig, rig.pose(weights, frame))

    write_rigged(path, rig, clips)
    said, arrays = blender(path, frames=[0, 2])
    assert set(clips) <= set(said["actions"])
    first = next(iter(clips.values()))
    for at in (0, 2):
        same(arrays, f"frame {at}", rig, rig.pose(first.values[at], first.joints[at]))


def same(arrays: dict[str, np.ndarray], when: str, rig: Rig, expected: np.ndarray) -> None:
    """All meshes together show the expected vertices, in order."""
    found = np.concatenate([points for name, points in arrays.items() if name.startswith(f"{when} ")])
    assert np.abs(found - expected[used(rig)]).max() < 1e-5


def test_a_new_file_opens_rigged_and_moves_the_same(blender, tmp_path):
    rig = with_anatomy(fitted(actor()))
    checked(blender, tmp_path / "a.glb", rig, {"act": played(rig), "nod": played(rig, 3)})


def test_a_turned_node_with_parts_added_opens_and_moves_the_same(blender, tmp_path):
    from tests.io.test_gltf_rigged import sheet_file

    _, path = sheet_file(tmp_path / "face.glb", translation=[0.1, 1, 0], rotation=turn(1, 0.3).tolist(), name="a_face")
    rig = with_parts(fitted(read_rig(path)))
    checked(blender, tmp_path / "a.glb", rig, {"act": played(rig)})


def test_the_probe_turns_axes_as_it_should():
    up = matrix((1, 2, 3))[:3, 3]
    to_blender = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    assert np.array_equal((to_blender @ up)[[0, 2, 1]] * [1, 1, -1], up)


@pytest.mark.real
@pytest.mark.parametrize("name", ["toon.glb", "variants/adult_draco.glb", "variants/adult_quantized.glb"])
def test_real_faces_open_rigged_and_move_the_same(blender, data, tmp_path, name):
    if "draco" in name:
        pytest.importorskip("DracoPy")
    rig = fitted(read_rig(data / "rigs" / name))
    checked(blender, tmp_path / "a.glb", rig, {"act": played(rig), "nod": played(rig, 3)})
