"""A small face and its capture as files, for tests that go through files."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Markers, SurfacePoints
from mien.io import gltf, trc, weights
from tests.retargeting.actors import capture, clip_of, face, points_on
from tests.retargeting.actors import weights as played

FRAMES = 120
POINTS = points_on(face())
NAMES = tuple(f"m{i}" for i in range(len(POINTS)))
FEW_SHAPES = "sparsity=0.001"
"""Weak enough for a face of six small shapes to act fully."""
LANDMARKS = {
    name: int(POINTS.corners[i, 0]) for name, i in zip("abcdefgh", (0, 6, 10, 24, 31, 38, 42, 48), strict=True)
}
"""Eight of the markers, as landmarks of the face: name → vertex."""


@dataclass(frozen=True)
class SmallFiles:
    """Where the files are.

    Attributes:
        folder: holds them all.
    """

    folder: Path

    def __getitem__(self, name: str) -> Path:
        return self.folder / name

    def take(self, markers: Markers | None = None, name: str = "take.trc") -> Path:
        """Write a capture over the take."""
        trc.write_markers(self[name], capture_of() if markers is None else markers)
        return self[name]

    def pairs(self, rows: Sequence[Mapping[str, Any]], name: str = "face.pairs.json", **more: Any) -> Path:
        """Write pairs over the pairs file."""
        return self.json(name, {"format": "mien-pairs", "version": 1, "pairs": list(rows), **more})

    def landmarks(self, spots: Mapping[str, Any], name: str) -> Path:
        return self.json(name, {"format": "mien-landmarks", "version": 1, "landmarks": dict(spots)})

    def json(self, name: str, document: Any) -> Path:
        self[name].write_text(json.dumps(document), encoding="utf-8")
        return self[name]


def marker_pairs(points: SurfacePoints = POINTS, names: Sequence[str] = NAMES) -> list[dict[str, Any]]:
    """The right pairs of the capture: every marker and its vertex."""
    return [{"source": name, "target": int(v)} for name, v in zip(names, points.corners[:, 0], strict=True)]


def capture_of(values: np.ndarray | None = None) -> Markers:
    """The small face acting, as markers elsewhere in space."""
    return capture(face(), played(FRAMES) if values is None else values, POINTS)


def write_small_files(folder: Path) -> SmallFiles:
    """Write face.glb, take.trc, anim.glb, weights.csv, face.pairs.json, mesh.pairs.json and landmarks of both sides."""
    files = SmallFiles(folder)
    gltf.write_rig(files["face.glb"], face())
    files.take()
    clip = clip_of(played(FRAMES))
    gltf.write_rig(files["anim.glb"], face(), clip)
    weights.write_clip(files["weights.csv"], clip)
    files.pairs(marker_pairs())
    vertices = POINTS.corners[:, 0].tolist()
    files.pairs([{"source": v, "target": v} for v in vertices], "mesh.pairs.json")
    files.landmarks({name: {"vertex": v} for name, v in LANDMARKS.items()}, "mesh.landmarks.json")
    spots = {name: {"marker": NAMES[vertices.index(v)]} for name, v in LANDMARKS.items()}
    files.landmarks(spots, "markers.landmarks.json")
    return files
