"""The generic rig's skin and bones: the modelled head in metres, its landmarks, four joints and how they hold it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mien.core import Mesh, Rig, Skeleton, Skin
from mien.core.arrays import Floats, Ints
from mien.core.rig import Colour, no_blendshapes
from mien.library.generic.landmarks import generic_landmarks
from mien.library.generic.measures import Measures
from mien.library.modelling.colours import of_groups
from mien.library.modelling.half import Head

CENTIMETRE = 0.01

JOINTS = ("head", "jaw", "eye_left", "eye_right")
"""The head is the root; the others are its children."""

NECK_PIVOT = (-2.5, -2.2)
"""Where the head turns on the neck, below and behind the hinge of the jaw [cm]."""

COLOURS: Mapping[str, Colour] = {
    "face": (0.70, 0.46, 0.35),
    "ear": (0.70, 0.44, 0.34),
    "lips": (0.56, 0.25, 0.22),
    "mouth": (0.25, 0.06, 0.06),
    "nostril": (0.25, 0.11, 0.09),
    "brow": (0.09, 0.055, 0.035),
    "teeth": (0.80, 0.76, 0.68),
    "tongue": (0.50, 0.17, 0.16),
    "sclera": (0.82, 0.80, 0.77),
    "iris": (0.10, 0.16, 0.18),
    "pupil": (0.01, 0.01, 0.01),
}
"""Linear red, green and blue of the parts; where they overlap, the later one shows."""

ALONG = (0.10, 0.42)
"""From where to where along the line from hinge to chin the jaw takes hold of the skin [its length]."""

BEHIND = (0.12, 0.78)
"""From where to where behind that line it lets go, under the chin and on the throat [its length]."""


def generic_skin(head: Head, measures: Measures) -> Rig:
    """Return the head as a rig of 4 joints with landmarks, without blendshapes or anatomy."""
    mesh = Mesh(
        head.vertices * CENTIMETRE, head.triangles, _unwrapped(head.vertices, head.triangles), None, head.groups
    )
    skeleton = generic_skeleton(measures)
    count = len(head.vertices)
    skin = Skin(
        np.tile(np.arange(4), (count, 1)),
        joint_weights(head, measures),
        np.asarray(np.linalg.inv(skeleton.rest), np.float64),
    )
    return Rig(
        mesh,
        no_blendshapes(count),
        skeleton,
        skin,
        landmarks=generic_landmarks(head, measures),
        name="generic",
        colours=of_groups(mesh, COLOURS),
    )


def generic_skeleton(measures: Measures) -> Skeleton:
    """Return the head, jaw and eye joints at rest [m].

    All frames are upright: turning the jaw about +x opens it, turning an eye about +x
    looks down and about +y to the subject's left.
    """
    hinge, eye = np.array([0.0, *measures.hinge]), np.array(measures.eye.centre)
    rest = np.tile(np.eye(4), (4, 1, 1))
    rest[:, :3, 3] = CENTIMETRE * np.stack([hinge + [0.0, *NECK_PIVOT], hinge, eye, eye * [-1, 1, 1]])
    return Skeleton(JOINTS, np.array([-1, 0, 0, 0]), rest)


def joint_weights(head: Head, measures: Measures) -> Floats:
    """Return `(N, 4)` how the joints share each vertex; rows sum to 1.

    The jaw holds the lower lip, chin and lower teeth; it lets go smoothly towards the
    corners of the mouth, the cheek, the angle of the jaw and the throat.
    """
    jaw = _jaw_share(measures, head.vertices)
    for still in ("eye_left", "eye_right", "brow_left", "brow_right", "ear_left", "ear_right", "teeth_upper", "neck"):
        jaw[head.groups.get(still, np.empty(0, np.int64))] = 0
    for lower in ("teeth_lower", "tongue"):
        jaw[head.groups.get(lower, np.empty(0, np.int64))] = 1
    weights = np.zeros((len(jaw), 4))
    weights[:, 1] = jaw
    for joint, group in ((2, "eye_left"), (3, "eye_right")):
        weights[head.groups[group], joint] = 1
    weights[:, 0] = 1 - weights[:, 1:].sum(axis=1)
    return weights


def _jaw_share(m: Measures, points: Floats) -> Floats:
    chin = np.array(m.places["chin_tip"][1:]) - m.hinge
    length = float(np.hypot(*chin))
    down, forward = chin / length
    y, z = (points[:, 1:] - m.hinge).T / length
    along, behind = y * down + z * forward, -y * forward + z * down
    held = _smooth((along - ALONG[0]) / (ALONG[1] - ALONG[0]))
    held *= _smooth((BEHIND[1] - behind) / (BEHIND[1] - BEHIND[0]))
    share = held * _smooth(1.12 * (1 - side_of_slit(m, points)) / 2 - 0.06)
    return np.asarray(np.where(share > 1e-3, share, 0))


def side_of_slit(m: Measures, points: Floats) -> Floats:
    """Return 1 above the mouth, -1 below it, and 0 at and beside its corners.

    This is the sine of the angular elliptic coordinate whose foci are the corners: it
    jumps across the slit and is smooth everywhere else, as the motion of lips is.
    """
    x = points[:, 0] / m.mouth.half_width
    lift = m.mouth.lift * np.minimum(np.abs(x), 1) ** 4
    y = (points[:, 1] - m.mouth.height - lift) / m.mouth.half_width
    q = x * x + y * y - 1
    return np.asarray(np.sign(y) * np.sqrt(np.maximum((np.hypot(q, 2 * y) - q) / 2, 0)))


def _unwrapped(vertices: Floats, triangles: Ints) -> Floats:
    """Return cylindrical texture coordinates per corner, `(T, 3, 2)`; the seam runs down the back."""
    turn = 0.5 + np.arctan2(vertices[:, 0], vertices[:, 2]) / (2 * np.pi)
    low, high = vertices[:, 1].min(), vertices[:, 1].max()
    down = (high - vertices[:, 1]) / (high - low)
    u = turn[triangles]
    u = np.where((np.ptp(u, axis=1, keepdims=True) > 0.5) & (u < 0.5), u + 1, u)
    return np.asarray(np.stack([u, down[triangles]], axis=2))


def _smooth(t: Floats) -> Floats:
    """Return 0 below 0, 1 above 1, and the cubic step between."""
    t = np.clip(t, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))
