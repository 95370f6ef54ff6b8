"""Made-up rigs for faces: joints, influences, shapes and muscles that mean nothing but are all different."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mien.core import (
    Anatomy,
    Blendshapes,
    Clip,
    Cluster,
    Flexor,
    Labels,
    Mesh,
    Muscle,
    Rig,
    Skeleton,
    Skin,
    SurfacePoints,
)
from tests.io.gltf_samples import matrix, turn

JOINTS = ("head", "jaw", "eye_left")


def fitted(face: Rig, width: int = 6, shapes: tuple[str, ...] = ("joy", "tick", "nothing")) -> Rig:
    """The face with three joints, `width` influences per vertex and new shapes: one everywhere, one sparse, one empty."""
    rng = np.random.default_rng(5)
    points = face.neutral.vertices
    middle, size = points.mean(axis=0), float(np.ptp(points, axis=0).max())
    places = [(0, 0, 0), (0, -0.1, 0.1), (0.1, 0.1, 0.1)]
    rest = np.stack([matrix(middle + size * np.array(p), turn(i, 0.2 + i)) for i, p in enumerate(places)])
    skeleton = Skeleton(JOINTS, np.array([-1, 0, 0]), rest)
    weights = rng.random((len(points), width)) * (np.arange(width) < 3)
    weights /= weights.sum(axis=1, keepdims=True)
    joints = np.tile(np.arange(width) % 3, (len(points), 1))
    deltas = np.zeros((len(shapes), len(points), 3))
    deltas[0] = 0.05 * size * np.sin(points / size * [3.0, 5.0, 7.0])
    if len(shapes) > 1:
        deltas[1, ::9] = 0.01 * size
    skin = Skin(joints, weights, np.linalg.inv(rest))
    return replace(face, blendshapes=Blendshapes(shapes, deltas), skeleton=skeleton, skin=skin)


def moved(rig: Rig, count: int = 4) -> np.ndarray:
    """World matrices of the joints over time: the head turns, the others turn with it and on their own."""
    assert rig.skeleton is not None
    rest = rig.skeleton.rest
    joints = np.tile(rest, (count, 1, 1, 1))
    for f in range(1, count):
        joints[f, 0] = rest[0] @ matrix((0.01 * f, 0, 0), turn(1, 0.1 * f))
        for j in range(1, len(rest)):
            joints[f, j] = joints[f, 0] @ np.linalg.solve(rest[0], rest[j]) @ matrix((0, 0, 0), turn(0, 0.2 * f * j))
    return joints


def played(rig: Rig, count: int = 4) -> Clip:
    """A clip that moves everything."""
    values = np.random.default_rng(8).random((count, len(rig.blendshapes)))
    return Clip(rig.blendshapes.names, values, 24.0, joints=moved(rig, count))


def with_parts(rig: Rig, count: int = 5) -> Rig:
    """The rig with a strip of extra vertices behind its own, as eyes that come with a generic rig."""
    assert rig.skin is not None
    rng = np.random.default_rng(2)
    n, mesh = len(rig.neutral.vertices), rig.neutral
    extra = mesh.vertices.mean(axis=0) + 0.01 * rng.normal(size=(count, 3))
    strip = n + np.stack([np.arange(count - 2), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    uv = None if mesh.uv is None else np.concatenate([mesh.uv, rng.random((len(strip), 3, 2))])
    deltas = np.pad(rig.blendshapes.deltas, ((0, 0), (0, count), (0, 0)))
    deltas[0, n:] = 0.01
    joints = np.concatenate([rig.skin.joints, np.full((count, rig.skin.joints.shape[1]), 2)])
    weights = np.zeros((n + count, rig.skin.weights.shape[1]))
    weights[:n], weights[n:, 0] = rig.skin.weights, 1
    return replace(
        rig,
        neutral=Mesh(
            np.concatenate([mesh.vertices, extra]),
            np.concatenate([mesh.triangles, strip]),
            uv,
            groups={**mesh.groups, "eye_left": np.arange(n, n + count)},
        ),
        blendshapes=Blendshapes(rig.blendshapes.names, deltas),
        skin=Skin(joints, weights, rig.skin.inverse_bind),
    )


def with_anatomy(rig: Rig) -> Rig:
    """The rig with one of everything that an anatomy and landmarks can hold."""
    rng = np.random.default_rng(4)
    n = len(rig.neutral.vertices)
    sparse = rng.random(n) * (rng.random(n) < 0.2)
    frame = matrix(rng.normal(size=3), turn(1, 0.7))
    muscles = (
        Muscle("zygomatic_left", rng.normal(size=(4, 3)), sparse, frame, 1.2, 0.25),
        Muscle(
            "orbicularis_left",
            rng.normal(size=(9, 3)),
            rng.random(n),
            frame,
            seam=rng.normal(size=(3, 3)),
            pivot=rng.normal(size=3),
        ),
    )
    script = Clip(("joy", "blink"), rng.random((7, 2)), 30.0, eyes=rng.random((7, 2, 3)), start=0.5)
    anatomy = Anatomy(
        muscles,
        (Cluster("chin", rng.random(n), frame, 0.8),),
        (Flexor("lips", "jaw", sparse),),
        fields={"stress": rng.random(n), "colour": rng.random((n, 3))},
        labels={"region": Labels(("brow", "lid", "cheek"), rng.integers(0, 3, n))},
        templates={"joy": {"zygomatic_left": 0.1 + 0.2, "jaw.rx": -0.05}, "rest": {}, "blink": {"orbicularis_left": 1}},
        bases={"blink": "rest"},
        scripts={"sentence": script, "still": Clip((), np.zeros((3, 0)), 30.0)},
    )
    triangle = rig.neutral.triangles[3]
    landmarks = {
        "chin": SurfacePoints.at_vertices(np.array([7])),
        "cheek": SurfacePoints(triangle[None], np.array([[0.2, 0.3, 0.5]])),
    }
    return replace(rig, anatomy=anatomy, landmarks=landmarks)
