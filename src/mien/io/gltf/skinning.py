"""Which joints carry which vertices, over all the skins of a file at once."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mien.core import Note, Skeleton
from mien.core.arrays import Floats, Ints
from mien.io.gltf.accessors import count_of, floats_at
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields
from mien.io.gltf.meshes import Part
from mien.io.gltf.scene import Scene

STILL = -1
"""Stands for the world where a joint's node is asked for."""

OFF = 0.005
"""Sums of weights further from 1 than this are worth a note: a little more than 8 bits round off."""


@dataclass
class Joints:
    """The joints found so far, each a node with an inverse bind matrix.

    Two skins may bind the same node differently; it is then two joints.
    """

    nodes: list[int] = field(default_factory=list)
    inverse_bind: list[Floats] = field(default_factory=list)
    _rows: dict[tuple[int, bytes], int] = field(default_factory=dict)

    def row(self, node: int, inverse_bind: Floats | None = None) -> int:
        """Return the number of a joint, new or known."""
        matrix = np.eye(4) if inverse_bind is None else inverse_bind
        key = (node, matrix.tobytes())
        if key not in self._rows:
            self._rows[key] = len(self.nodes)
            self.nodes.append(node)
            self.inverse_bind.append(matrix)
        return self._rows[key]

    def of_skin(self, document: Document, skin: Fields, scene: Scene) -> Ints:
        """Return the rows of a skin's joints.

        Raises:
            FileError: the skin has no joints, missing ones, or too few inverse bind matrices.
        """
        nodes = skin.integers("joints")
        if not nodes or max(nodes) >= len(scene.nodes):
            raise skin.error(f"must list joints among the {len(scene.nodes)} nodes")
        matrices = np.broadcast_to(np.eye(4), (len(nodes), 4, 4))
        if "inverseBindMatrices" in skin:
            index = skin.integer("inverseBindMatrices")
            if count_of(document, index, skin) < len(nodes):
                raise skin.error(f"has {len(nodes)} joints, but fewer inverse bind matrices")
            matrices = floats_at(document, index, skin, "MAT4").reshape(-1, 4, 4).swapaxes(1, 2)
        return np.array([self.row(node, matrix) for node, matrix in zip(nodes, matrices, strict=False)])

    def rest(self, scene: Scene) -> Floats:
        """Return the joints' world matrices at rest, `(J, 4, 4)`."""
        return np.array([np.eye(4) if node == STILL else scene.world[node] for node in self.nodes])

    def skeleton(self, scene: Scene) -> Skeleton:
        """Return the joints as a tree, leaving out the nodes between them."""
        first: dict[int, int] = {}
        for joint, node in enumerate(self.nodes):
            first.setdefault(node, joint)
        above = scene.nearest(first, absent=-1)
        parents = [-1 if node == STILL else above[node] for node in self.nodes]
        names = tuple("still" if node == STILL else scene.name(node) for node in self.nodes)
        return Skeleton(names, np.array(parents, dtype=np.int64), self.rest(scene))


def influences(part: Part, rows: Ints, fallback: int, notes: list[Note]) -> tuple[Ints, Floats]:
    """Return the joint rows and weights of a skinned part's vertices, `(n, I)`.

    Args:
        part: the vertices.
        rows: the joint row of each joint of the skin.
        fallback: the row for vertices that no joint carries.
        notes: where repairs are recorded.

    Raises:
        FileError: a vertex refers to a joint that the skin does not have.
    """
    places = np.concatenate([joints for joints, _ in part.influences], axis=1)
    weights = np.concatenate([weights for _, weights in part.influences], axis=1)
    weights = np.maximum(weights, 0)
    used = weights > 0
    if (used & ((places < 0) | (places >= len(rows)))).any():
        raise part.by.error(f"is bound to joint {int(places[used].max())}, but its skin has only {len(rows)}")
    joints = rows[np.where(used, places, 0)]
    total = weights.sum(axis=1)
    loose = total <= 0
    off = int((~loose & (np.abs(total - 1) > OFF)).sum())
    if off:
        notes.append(Note("skin-weights", f"{off} vertices had weights that did not sum to 1: scaled", part.by.where))
    if loose.any():
        notes.append(Note("unskinned", f"{loose.sum()} vertices without weights follow their node", part.by.where))
        joints[loose, 0] = fallback
        weights[loose, 0] = 1
    return joints, weights / np.where(loose, 1, total)[:, None]
