"""The main job as a person meets it: a minute of capture onto a large character, from a cold start.

    python -m benchmarks.speed.whole

The take is the built-in actor's, played until it is 60 s at 60 frames a second, 60
markers with noise and gaps.  The character is the built-in one with every triangle cut
into four, or the real head with 26,719 vertices where `MIEN_DATA` names the real data.
Wall time, processor time and peak memory are the operating system's, for the whole process.
Python's compiled modules are kept, as they are for anyone who runs the command twice, in a
folder of their own; what numba has not cached yet is compiled by a run before those that count.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks.report import Row, publish
from mien.core import Blendshapes, Markers, Mesh, Rig
from mien.io import gltf, trc
from mien.io.c3d import write_markers
from mien.job.demo import write_landmarks
from mien.library import actor, character, performance

FRAMES, FPS = 3600, 60.0


def long_take() -> Markers:
    """Return the built-in take, forwards and backwards until it is a minute long."""
    take = performance(actor())[1]
    there_and_back = np.concatenate([take.points, take.points[::-1]])
    rounds = -(-FRAMES // len(there_and_back))
    return replace(take, points=np.tile(there_and_back, (rounds, 1, 1))[:FRAMES], fps=FPS)


def finer(rig: Rig) -> Rig:
    """Cut every triangle into four at the middles of its edges."""
    n, triangles = len(rig.neutral.vertices), rig.neutral.triangles
    edges = np.sort(np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    distinct, where = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = (where.ravel()[i * len(triangles) : (i + 1) * len(triangles)] + n for i in range(3))
    a, b, c = triangles.T
    cut = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    vertices = np.concatenate([rig.neutral.vertices, rig.neutral.vertices[distinct].mean(axis=1)])
    deltas = np.concatenate([rig.blendshapes.deltas, rig.blendshapes.deltas[:, distinct].mean(axis=2)], axis=1)
    return replace(rig, neutral=Mesh(vertices, cut), blendshapes=Blendshapes(rig.blendshapes.names, deltas), colours={})


def measure(command: list[str], repeats: int, environment: dict[str, str]) -> Row:
    """Run a command afresh a few times; return the medians of its time, its own stages and its memory."""
    walls, processor, stages = [], [], []
    for _ in range(repeats):
        begin, before = time.perf_counter(), _processor_seconds()
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        walls.append(time.perf_counter() - begin)
        processor.append(_processor_seconds() - before)
        stages.append(json.loads(done.stdout)["timing_s"])
    row: Row = {"wall_s": round(median(walls), 2), "processor_s": round(median(processor), 2)}
    row |= {f"{name}_s": round(median(s[name] for s in stages), 2) for name in stages[0]}
    row["start_and_write_s"] = round(row["wall_s"] - sum(median(s[name] for s in stages) for name in stages[0]), 2)
    row["peak_mb"] = round(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)
    return row


def _processor_seconds() -> float:
    """Return what all processes that this one has waited for have used."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Write the files, run the command, publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    repeats = parser.parse_args().repeats
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        take, hero, out = folder / "take.c3d", folder / "hero.glb", folder / "out.glb"
        try:
            write_markers(take, long_take())
        except ImportError:
            take = folder / "take.trc"
            trc.write_markers(take, long_take())
        rig = finer(character())
        gltf.write_rig(hero, rig)
        write_landmarks(hero.with_suffix(".landmarks.json"), rig.landmarks, rig.neutral)
        heroes = {f"built-in, {len(rig.neutral.vertices):,} vertices": hero}
        real = Path(os.environ.get("MIEN_DATA", "../shared/data")) / "rigs" / "ict_head.glb"
        if real.is_file():
            heroes["ICT head, 26,719 vertices"] = real
        rows = []
        for label, path in heroes.items():
            command = [sys.executable, "-m", "mien", "retarget", str(take), str(path), "-o", str(out), "--json"]
            environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(folder / "modules")}
            environment.pop("PYTHONDONTWRITEBYTECODE", None)
            subprocess.run(command, capture_output=True, check=True, env=environment)  # compiles
            rows.append({"character": label, "frames": FRAMES, **measure(command, repeats, environment)})
    publish(
        "speed_whole", "A 60 s, 60 fps take onto a large character, whole process", rows, ["numpy", "scipy", "numba"]
    )


if __name__ == "__main__":
    main()
