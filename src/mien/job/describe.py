"""What a file holds, in words and numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mien.core import Clip, FileError, Markers, Rig
from mien.core.errors import Note
from mien.io.documents import read_landmarks
from mien.io.formats import format_of, read_clip, read_markers, read_rig
from mien.job.pairs import landmarks_beside


def describe(path: Path) -> dict[str, Any]:
    """Return an account of a file for people and scripts.

    Raises:
        FileError: the file is missing, damaged or of no known kind.
    """
    if path.name.endswith(".landmarks.json"):
        return {"file": str(path), "format": "mien-landmarks", "landmarks": list(read_landmarks(path))}
    row = format_of(path)
    found: dict[str, Any] = {"file": str(path), "format": row.name}
    notes: tuple[Note, ...] = ()
    if row.read_rig is not None:
        rig = read_rig(path)
        found["rig"], notes = _rig(rig), rig.notes
    if row.read_clip is not None:
        try:
            clip = read_clip(path)
            found["clip"], notes = _clip(clip), (*notes, *clip.notes)
        except FileError:
            if row.read_rig is None:
                raise  # a mesh without animation is a fine file; weights without weights are not
    if row.read_markers is not None:
        markers = read_markers(path)
        found["markers"], notes = _markers(markers), markers.notes
    found["warnings"] = [{"code": n.code, "message": n.message, "where": n.where} for n in dict.fromkeys(notes)]
    return found


def _rig(rig: Rig) -> dict[str, Any]:
    size = np.ptp(rig.neutral.vertices, axis=0)
    reach = np.linalg.norm(rig.blendshapes.deltas, axis=2).max(axis=1) if len(rig.blendshapes) else np.zeros(0)
    beside = landmarks_beside(rig.source)
    return {
        "vertices": len(rig.neutral.vertices),
        "triangles": len(rig.neutral.triangles),
        "size_m": [round(float(x), 5) for x in size],
        "parts": {name: len(ids) for name, ids in rig.neutral.groups.items()},
        "joints": len(rig.skeleton.names) if rig.skeleton else 0,
        "shapes": {name: round(float(r) * 1000, 3) for name, r in zip(rig.blendshapes.names, reach, strict=True)},
        "empty_shapes": list(rig.blendshapes.empty),
        "landmarks": str(beside) if beside else None,
    }


def _clip(clip: Clip) -> dict[str, Any]:
    lost = np.isnan(clip.values).any(axis=1) if clip.names else np.zeros(len(clip), bool)
    good = clip.values[~lost]
    low = good.min(axis=0) if len(good) else np.full(len(clip.names), np.nan)
    high = good.max(axis=0) if len(good) else np.full(len(clip.names), np.nan)
    return {
        "frames": len(clip),
        "fps": round(clip.fps, 4),
        "seconds": round(len(clip) / clip.fps, 3),
        "channels": {
            name: [round(float(x), 4) if np.isfinite(x) else None for x in ends]
            for name, *ends in zip(clip.names, low, high, strict=True)
        },
        "still_channels": [n for n, a, b in zip(clip.names, low, high, strict=True) if not b - a > 1e-6],
        "lost_frames": int(lost.sum()),
        "head": clip.head is not None,
        "eyes": clip.eyes is not None,
        "joints": clip.joints is not None,
    }


def _markers(markers: Markers) -> dict[str, Any]:
    missing = (~markers.seen).sum(axis=0)
    seen = markers.points[markers.seen]
    return {
        "frames": len(markers),
        "fps": round(markers.fps, 4),
        "seconds": round(len(markers) / markers.fps, 3),
        "markers": list(markers.names),
        "missing": {name: int(n) for name, n in zip(markers.names, missing, strict=True) if n},
        "size_m": [round(float(x), 4) for x in np.ptp(seen, axis=0)] if len(seen) else None,
    }
