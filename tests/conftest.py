"""Shared pieces of the tests: where the real data is, and a small rig to try things on."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from mien.core import Blendshapes, Mesh, Rig

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real rigs and captures; tests that need it are skipped without it."""
    folder = Path(os.environ.get("MIEN_DATA", ROOT.parent / "shared" / "data"))
    if not (folder / "README.md").is_file():
        pytest.skip(f"no real data at {folder}; name it with MIEN_DATA")
    return folder


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20260111)


def grid_rig(n: int = 6, shapes: tuple[str, ...] = ("jawOpen", "smile_L", "smile_R")) -> Rig:
    """A bent sheet of n × n vertices with smooth random shapes: small, and with nothing symmetric about it."""
    rng = np.random.default_rng(7)
    u, v = np.meshgrid(np.linspace(-0.08, 0.08, n), np.linspace(-0.1, 0.1, n), indexing="ij")
    vertices = np.stack([u.ravel(), v.ravel(), 0.1 - 4 * u.ravel() ** 2 - 2 * v.ravel() ** 2], axis=1)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate([np.stack([a, a + n, a + 1], 1), np.stack([a + 1, a + n, a + n + 1], 1)])
    centres = vertices[rng.integers(0, len(vertices), len(shapes))]
    falloff = np.exp(-((vertices[None] - centres[:, None]) ** 2).sum(2) / 0.05**2)
    deltas = falloff[..., None] * rng.normal(0, 0.01, (len(shapes), 1, 3))
    return Rig(Mesh(vertices, triangles), Blendshapes(shapes, deltas), name="sheet")
