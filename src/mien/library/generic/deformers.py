"""Clusters and flexors: what moves a face where no muscle of the eleven reaches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mien.core.anatomy import Cluster, Flexor
from mien.core.arrays import Floats
from mien.library.generic.frames import frame_at, outward_at
from mien.library.generic.places import Field, Side, places, smooth


class Patch(NamedTuple):
    """A cluster of the left side: where it is, how far it reaches along x, y and z [cm of a human face], whose lip."""

    name: str
    place: str
    reach: tuple[float, float, float]
    side: Side = "both"
    behind: float = 0.0


PATCHES = (
    Patch("brow_inner", "brow_inner", (1.2, 1.1, 2.0)),
    Patch("brow_middle", "brow_peak", (1.5, 1.1, 2.0)),
    Patch("nose_wing", "wing", (0.9, 0.9, 1.4)),
    Patch("cheek", "cheek", (2.1, 2.2, 3.2)),
    Patch("cheekbone", "cheekbone", (1.7, 1.2, 2.2)),
    Patch("buccal", "buccal", (1.7, 1.9, 3.2)),
    Patch("malar", "malar", (2.0, 2.2, 3.2)),
    Patch("infraorbital", "infraorbital", (2.0, 0.9, 2.0)),
    Patch("lip_corner", "corner", (1.2, 1.25, 1.8)),
    Patch("lip_upper", "lip_upper", (1.9, 0.85, 1.6), "upper", 0.45),
    Patch("lip_lower", "lip_lower", (1.9, 0.9, 1.6), "lower", 0.45),
)
"""Those of each side; `behind` sets the centre about which a lip rolls back from the skin [cm]."""

BROW = ("brow_inner", "brow_middle", "cheekbone", "malar", "infraorbital")


def clusters(field: Field) -> tuple[Cluster, ...]:
    """Return all clusters of a head [m]: both sides of each patch, the mouth, and the tongue if there is one."""
    spots = places(field.measures)
    left = [_patch(field, spots, row) for row in PATCHES]
    paired = [cluster for one in left for cluster in (one, _mirrored(field, one))]
    tongue = field.group("tongue")
    return (*paired, _mouth(field, spots["lips"]), *([_tongue(field)] if len(tongue) else []))


def flexors(field: Field) -> tuple[Flexor, ...]:
    """Return the flexor that keeps the lips together while the jaw opens."""
    m, points = field.measures.mouth, field.head.vertices
    x = np.maximum(np.abs(points[:, 0]) - m.half_width, 0)
    slit = m.height + m.lift * np.minimum(np.abs(points[:, 0]) / m.half_width, 1) ** 4
    off = np.hypot(x, points[:, 1] - slit) / (2.0 * field.mouth_size)
    in_front = smooth((points[:, 2] - field.measures.hinge[1]) / 2)
    return (Flexor("lips_together", "jaw", np.exp(-(off**4)) * in_front * field.skin),)


def _patch(field: Field, spots: dict[str, Floats], row: Patch) -> Cluster:
    size = field.eye_size if row.name in BROW else field.mouth_size
    place = spots[row.place]
    weights = field.around(place, size * np.array(row.reach), row.side)
    outward = outward_at(field, place) * [1, 0, 1]
    frame = frame_at(place - row.behind * size * outward, np.array([0.0, 1, 0]), outward)
    return Cluster(f"{row.name}_left", weights * field.left, frame, size)


def _mirrored(field: Field, cluster: Cluster) -> Cluster:
    flip = np.diag([-1.0, 1, 1, 1])
    weights = cluster.weights[field.head.mirror]
    return Cluster(cluster.name.removesuffix("left") + "right", weights, flip @ cluster.frame @ flip, cluster.scale)


def _mouth(field: Field, place: Floats) -> Cluster:
    size = field.measures.mouth.half_width
    weights = field.around(place, (1.2 * size, 0.8 * size, 2.4 * size))
    frame = frame_at(place, np.array([0.0, 1, 0]), np.array([0.0, 0, 1]))
    return Cluster("mouth", np.minimum(1.25 * weights, 1), frame, field.mouth_size)


def _tongue(field: Field) -> Cluster:
    """Return the tongue, its tip following fully and its root not at all."""
    ids = field.group("tongue")
    depth = field.head.vertices[ids, 2]
    weights = np.zeros(len(field.head.vertices))
    weights[ids] = smooth((depth - depth.min()) / max(float(np.ptp(depth)), 1e-9))
    root = field.head.vertices[ids].mean(axis=0)
    root[2] = depth.min()
    return Cluster("tongue", weights, frame_at(root, np.array([0.0, 1, 0]), np.array([0.0, 0, 1])), field.mouth_size)
