"""The small face of `actors`, moved by bones instead of shapes: a jaw that turns far, brows and cheeks on short bones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from mien.core import Clip, Markers, Rig, Skeleton, Skin
from mien.core.rig import no_blendshapes
from mien.geometry.bones import Bones
from tests.retargeting.actors import CENTRES, capture, face, points_on

JOINTS = ("lip", "head", "jaw", "cheek_L", "cheek_R", "lid_L", "lid_R", "brow", "eye_L")
"""Not parents first: the lip hangs on the jaw."""
PARENTS = (2, -1, 1, 1, 1, 1, 1, 1, 1)
PLACES = np.array(
    [(0, -0.055, 0), (0, -0.1, -0.1), (0, 0.01, -0.06), (0.03, -0.04, -0.02), (-0.03, -0.04, -0.02)]
    + [(0.03, 0.035, 0.02), (-0.03, 0.035, 0.02), (0, 0.05, 0.01), (0.03, 0.03, 0)]
)
POINTS = 100
POSES = ("open", "pout", "smile_L", "smile_R", "blink_L", "blink_R", "raise")


def bone_face() -> Rig:
    """The face with nine joints and no shapes; each joint's frame is turned another way."""
    rig = face()
    vertices = rig.neutral.vertices
    centres = np.concatenate([[[0, -0.05]], CENTRES[[0, 1, 2, 3, 4, 5]]])
    widths = np.array([0.015, 0.03, 0.015, 0.015, 0.012, 0.012, 0.02])
    reach = np.exp(-((vertices[:, None, :2] - centres) ** 2).sum(2) / widths**2)
    weights = np.zeros((len(vertices), len(JOINTS)))
    weights[:, [0, 2, 3, 4, 5, 6, 7]] = 0.95 * reach / np.maximum(1, reach.sum(axis=1, keepdims=True))
    weights[:, 1] = 1 - weights.sum(axis=1)
    rest = np.tile(np.eye(4), (len(JOINTS), 1, 1))
    rest[:, :3, :3] = Rotation.from_rotvec(0.3 * np.arange(27).reshape(9, 3)).as_matrix()
    rest[:, :3, 3] = PLACES
    skeleton = Skeleton(JOINTS, np.array(PARENTS), rest)
    skin = Skin(np.tile(np.arange(len(JOINTS)), (len(vertices), 1)), weights, np.linalg.inv(rest))
    return replace(rig, blendshapes=no_blendshapes(len(vertices)), skeleton=skeleton, skin=skin, name="bone_face")


def posed(
    skeleton: Skeleton, own: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]
) -> np.ndarray:
    """World matrices `(J, 4, 4)` of joints turned about the world's axes, and moved; what hangs on them follows."""
    motions: dict[int, np.ndarray] = {}

    def motion(j: int) -> np.ndarray:
        if j not in motions:
            turn, move = own.get(skeleton.names[j], ((0, 0, 0), (0, 0, 0)))
            place, matrix = skeleton.rest[j, :3, 3], np.eye(4)
            matrix[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
            matrix[:3, 3] = place + move - matrix[:3, :3] @ place
            above = motion(skeleton.parents[j]) if skeleton.parents[j] >= 0 else np.eye(4)
            motions[j] = above @ matrix
        return motions[j]

    return np.array([motion(j) @ skeleton.rest[j] for j in range(len(skeleton.names))])


def poses(skeleton: Skeleton) -> dict[str, np.ndarray]:
    """Seven poses; in `open` both jaw and lip turn."""
    still = (0.0, 0.0, 0.0)
    own = {
        "open": {"jaw": ((0.6, 0, 0), still), "lip": ((-0.4, 0, 0), (0, 0.002, 0))},
        "pout": {"lip": ((0.9, 0, 0), (0, 0, 0.006)), "jaw": ((-0.05, 0, 0), still)},
        "smile_L": {"cheek_L": ((-0.5, 0.3, 0), still)},
        "smile_R": {"cheek_R": ((-0.5, -0.3, 0), still)},
        "blink_L": {"lid_L": ((0.8, 0, 0), still)},
        "blink_R": {"lid_R": ((0.8, 0, 0), still)},
        "raise": {"brow": ((-0.2, 0, 0), (0, 0.006, 0))},
    }
    return {name: posed(skeleton, own[name]) for name in POSES}


def bones() -> Bones:
    """The parameters that these poses are."""
    skeleton = bone_face().skeleton
    assert skeleton is not None
    return Bones.of_poses(skeleton, poses(skeleton))


def performed(values: np.ndarray, **conditions: float) -> Markers:
    """The face acting these parameters, as `actors.capture` has it."""
    rig, known = bone_face(), bones()

    class Acting:
        def pose(self, weights: np.ndarray) -> np.ndarray:
            return rig.pose(np.zeros((len(weights), 0)), known.world(weights))

    return capture(Acting(), values, points_on(rig, POINTS), **conditions)  # type: ignore[arg-type]


def played(values: np.ndarray) -> Clip:
    """The truth as a clip."""
    known = bones()
    return Clip(known.names, values, 60.0, joints=known.world(values))


def curves(frames: int = 150) -> np.ndarray:
    """Each pose alone, then mixtures."""
    t = np.arange(frames) / frames
    alone = [np.exp(-(((t - (k + 1.2) / 10.5) / 0.035) ** 2)) for k in range(len(POSES))]
    mixed = [0.6 * np.exp(-(((t - 0.9) / 0.04) ** 2)) * (1 + np.sin(30 * t + k)) / 2 for k in range(len(POSES))]
    values = np.array(alone).T + np.array(mixed).T
    values[values < 1e-3] = 0
    return values
