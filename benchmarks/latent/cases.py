"""Real performances as rows: markers that ride on the mesh, and the parameters that made them.

Parameters come in two kinds: the weights themselves, of which the markers are nearly a linear map, and
parameters such as a rig's bones and sliders, of which they are not.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mien.core import Clip, Rig
from mien.core.arrays import Floats
from mien.geometry.correspond import spread_points
from mien.io.documents import join, landmarks_on_mesh, read_landmarks
from mien.io.formats import read_clip, read_rig
from mien.retargeting.methods import make_method
from mien.retargeting.samples import Samples

MARKERS = 99
LIVELINK = ("alex_rom_3", "S07-001", "apfel")
TEST_FRAMES = 400


@dataclass(frozen=True, eq=False)
class Take:
    """Frames of a performance.

    Attributes:
        name: of the take.
        kind: of its targets.
        markers: `(F, 297)` [mm].
        targets: `(F, k)`.
        names: of the targets, if they are weights.
        heights: `(99,)` of the markers at rest.
    """

    name: str
    kind: str
    markers: Floats
    targets: Floats
    names: tuple[str, ...]
    heights: Floats


@dataclass(frozen=True, eq=False)
class Draw:
    """Samples drawn from a take, and other frames of it to test on.

    Attributes:
        given: what is learned from.
        hidden: `(m, k)` the targets of its source-only rows, which nobody labelled yet.
        markers, targets: the test frames.
    """

    given: Samples
    hidden: Floats
    markers: Floats
    targets: Floats


def read_takes(data: Path, names: tuple[str, ...] = (*LIVELINK, "aura")) -> list[Take]:
    """Return each take twice: with weights and with non-linear parameters as targets."""
    takes = []
    for name in names:
        aura = name == "aura"
        rig_file = data / "rigs" / ("aura.glb" if aura else "ict_face.glb")
        rig, landmarks = read_rig(rig_file), rig_file.with_suffix(".landmarks.json")
        clip = read_clip(data / "clips" / ("aura_controls_first_half.csv" if aura else f"livelink/{name}.csv"))
        takes += takes_of(name, rig, landmarks, clip)
    return takes


def takes_of(name: str, rig: Rig, landmarks: Path, clip: Clip) -> list[Take]:
    """Return a clip played on a rig, with both kinds of targets."""
    points = landmarks_on_mesh(read_landmarks(landmarks), rig.neutral, landmarks)
    spread = spread_points(rig.neutral, join(list(points.values())), MARKERS)
    played, _ = make_method("copy").fit(rig, clip).retarget(clip)
    good = ~(np.isnan(played.values).any(axis=1) | np.isnan(clip.values).any(axis=1))
    deltas = rig.only(spread.corners.ravel()).blendshapes.deltas.reshape(len(played.names), MARKERS, 3, 3)
    moved = np.einsum("kmca,mc->kma", deltas, spread.weights).reshape(len(played.names), -1)
    markers, weights = 1000 * played.values[good] @ moved, clip.values[good]
    heights = spread.of(rig.neutral.vertices)[:, 1]
    rigged = rig_parameters(weights, clip.names)
    return [
        Take(name, "weights", markers, weights, clip.names, heights),
        Take(name, "rig", markers, rigged, (), heights),
    ]


def rig_parameters(weights: Floats, names: tuple[str, ...]) -> Floats:
    """Return parameters `(F, 72)` that weights `(F, K)` are no linear map of.

    In the order of the names, so that two takes of one rig have the same parameters: bone
    quaternions of three joint angles each, correctives (products of two), eased sliders (roots), and sliders that are
    the stronger of two shapes.
    """
    w = np.clip(weights[:, np.argsort(names)], 0, None)
    pick = np.random.default_rng(11).permutation(w.shape[1])
    bones = []
    for three in pick[:18].reshape(6, 3):
        turn = Rotation.from_euler("xyz", w[:, three] * np.array([1.2, -0.9, 0.6]))
        bones.append(turn.as_quat(canonical=True))
    correctives = 2 * w[:, pick[18:34]] * w[:, pick[2:18]]
    eased = np.sqrt(w[:, pick[20:40]])
    stronger = np.maximum(w[:, pick[:12]], w[:, pick[36:48]])
    return np.concatenate([*bones, correctives, eased, stronger], axis=1)


def draw(
    take: Take, labels: int, seed: int, *, unlabelled: int = 100, noise: float = 0.2, other: Take | None = None
) -> Draw:
    """Draw labels, unlabelled rows of both sides and test frames, all different, at random.

    Args:
        take: what is drawn from.
        labels: how many.
        seed: of the draw.
        unlabelled: of each side.
        noise: standard deviation of each marker coordinate [mm].
        other: the take that target-only rows come from, if not the same.
    """
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(take.markers))
    markers = take.markers + noise * rng.normal(size=take.markers.shape)
    ends = np.cumsum([labels, unlabelled, unlabelled, TEST_FRAMES])
    a, b, c, d = np.split(order[: ends[-1]], ends[:-1])
    goals = take.targets[c] if other is None else other.targets[rng.permutation(len(other.targets))[:unlabelled]]
    given = Samples(markers[a], take.targets[a], markers[b], goals)
    return Draw(given, take.targets[b], markers[d], take.targets[d])


def rms(found: Floats, right: Floats) -> float:
    """Return the root-mean-square difference."""
    return float(np.sqrt(((found - right) ** 2).mean()))
