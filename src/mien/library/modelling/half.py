"""Putting a head together: its left half piece by piece, and then the whole.

Only the subject's left half (`x >= 0`) is ever modelled.  Mirroring it makes the
neutral and the shapes exactly symmetric.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mien.core.arrays import Floats, Ints


@dataclass(frozen=True, eq=False)
class Head:
    """A finished head, in centimetres.

    Attributes:
        vertices, triangles, groups: the mesh.
        mirror: `(N,)` the mirror image of each vertex.
        lid: `(N,)` by how much it turns about the eye's x-axis to close the lid [rad], positive downwards.
    """

    vertices: Floats
    triangles: Ints
    groups: dict[str, Ints]
    mirror: Ints
    lid: Floats


@dataclass
class Half:
    """The left half while it is being put together."""

    vertices: list[Floats] = field(default_factory=list)
    triangles: list[Ints] = field(default_factory=list)
    lid: list[Floats] = field(default_factory=list)
    groups: dict[str, list[Ints]] = field(default_factory=dict)
    count: int = 0

    def add(self, points: Floats, *groups: str, lid: Floats | float = 0.0) -> Ints:
        """Append vertices to these groups and return their indices."""
        ids = np.arange(self.count, self.count + len(points))
        self.count += len(points)
        self.vertices.append(points)
        self.lid.append(np.broadcast_to(lid, len(points)).astype(float))
        self.label(ids, *groups)
        return ids

    def label(self, ids: Ints, *groups: str) -> None:
        """Put vertices into groups."""
        for name in groups:
            self.groups.setdefault(name, []).append(ids)

    def strip(self, inner: Ints, outer: Ints, *, closed: bool) -> None:
        """Join two rings that run counter-clockwise seen from outside."""
        i, o = (np.append(r, r[0]) if closed else r for r in (inner, outer))
        self.triangles.append(np.stack([i[:-1], o[:-1], o[1:]], axis=1))
        self.triangles.append(np.stack([i[:-1], o[1:], i[1:]], axis=1))

    def fan(self, ring: Ints, tip: int, *, closed: bool) -> None:
        """Close a counter-clockwise ring with triangles to a tip."""
        r = np.append(ring, ring[0]) if closed else ring
        self.triangles.append(np.stack([r[:-1], r[1:], np.full(len(r) - 1, tip)], axis=1))


def mirrored(half: Half) -> Head:
    """Return the whole head; vertices on the midline (`x == 0`) stay single."""
    points, triangles = np.concatenate(half.vertices), np.concatenate(half.triangles)
    lid = np.concatenate(half.lid)
    off = np.flatnonzero(points[:, 0] != 0)
    image = np.arange(len(points))
    image[off] = len(points) + np.arange(len(off))
    mirror = np.concatenate([image, off])
    groups = {}
    for name, pieces in half.groups.items():
        ids = np.unique(np.concatenate(pieces))
        if name.endswith("_left"):
            groups[name], groups[name[:-4] + "right"] = ids, image[ids]
        else:
            groups[name] = np.unique([ids, image[ids]])
    return Head(
        np.concatenate([points, points[off] * [-1, 1, 1]]),
        np.concatenate([triangles, image[triangles][:, ::-1]]),
        groups,
        mirror,
        np.concatenate([lid, lid[off]]),
    )
