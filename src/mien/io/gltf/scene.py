"""The tree of nodes: who is whose parent, and where everything is in the world."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mien.core import FileError
from mien.core.arrays import Floats
from mien.io.gltf.container import Document
from mien.io.gltf.fields import Fields
from mien.io.gltf.transforms import composed, decomposed

LARGEST = 1e30
"""Transforms beyond this cannot be stored in single precision, as glTF does."""


@dataclass(frozen=True, eq=False)
class Scene:
    """The nodes of a document.

    Attributes:
        nodes: all of them, in the order of the file.
        parents: the parent of each, -1 at a root.
        order: all nodes, parents first.
        shown: the nodes of the default scene.
        local: `(N, 4, 4)` each node's transform at rest.
        world: `(N, 4, 4)` each node's transform to the world at rest.
    """

    nodes: tuple[Fields, ...]
    parents: tuple[int, ...]
    order: tuple[int, ...]
    shown: frozenset[int]
    local: Floats
    world: Floats

    def name(self, node: int) -> str:
        """Return what to call a node."""
        return self.nodes[node].text("name") or f"node_{node:02d}"

    def line(self, node: int) -> Iterator[int]:
        """Yield the node and its ancestors, from itself up."""
        while node >= 0:
            yield node
            node = self.parents[node]

    def lineage(self, nodes: Iterable[int]) -> set[int]:
        """Return the nodes and all their ancestors."""
        found: set[int] = set()
        for node in nodes:
            for ancestor in self.line(node):
                if ancestor in found:
                    break
                found.add(ancestor)
        return found

    def nearest(self, marked: Mapping[int, int], absent: int) -> list[int]:
        """Return for every node what the nearest marked ancestor is marked with."""
        found = [absent] * len(self.nodes)
        for node in self.order:
            parent = self.parents[node]
            if parent >= 0:
                found[node] = marked.get(parent, found[parent])
        return found

    @property
    def mesh_nodes(self) -> list[int]:
        """The shown nodes that have a mesh, in the order of the file."""
        return [node for node in sorted(self.shown) if "mesh" in self.nodes[node]]

    def moved(self, locals_over_time: Mapping[int, Floats], wanted: set[int]) -> dict[int, Floats]:
        """Return the world matrices of nodes when some local transforms change.

        Args:
            locals_over_time: `(F, 4, 4)` per moving node.
            wanted: the nodes to return.

        Returns:
            `(F, 4, 4)` per wanted node, or `(4, 4)` for one that stays where it is.
        """
        needed = self.lineage(wanted)
        world: dict[int, Floats] = {}
        for node in self.order:
            if node in needed:
                local = locals_over_time.get(node, self.local[node])
                parent = self.parents[node]
                world[node] = local if parent < 0 else world[parent] @ local
        return {node: world[node] for node in wanted}


def read_scene(document: Document) -> Scene:
    """Return the tree of a document's nodes.

    Raises:
        FileError: nodes refer to missing ones, have two parents, or form a cycle.
    """
    nodes = tuple(document.top.each("nodes"))
    parents = [-1] * len(nodes)
    children = [node.integers("children") for node in nodes]
    for i, below in enumerate(children):
        for child in below:
            if child >= len(nodes):
                raise nodes[i].error(f"refers to nodes[{child}], which does not exist")
            if parents[child] >= 0:
                raise nodes[child].error(f"is a child of both nodes[{parents[child]}] and nodes[{i}]")
            parents[child] = i
    everything = _descended([i for i, parent in enumerate(parents) if parent < 0], children)
    if len(everything) < len(nodes):
        stray = min(set(range(len(nodes))) - set(everything))
        raise nodes[stray].error("is its own ancestor")
    local = np.array([_local(node) for node in nodes]).reshape(-1, 4, 4)
    world = local.copy()
    for node in everything:
        if parents[node] >= 0:
            world[node] = world[parents[node]] @ local[node]
    if not (np.abs([local, world]) < LARGEST).all():
        raise FileError(f"{document.path} is damaged: its node transforms overflow. Export it again.")
    shown = frozenset(_descended(scene_roots(document, parents), children))
    return Scene(nodes, tuple(parents), tuple(everything), shown, local, world)


def scene_roots(document: Document, parents: list[int] | tuple[int, ...]) -> list[int]:
    """Return the root nodes of the default scene, or of everything where there is no scene.

    Raises:
        FileError: the scene does not exist or has nodes that are missing or not roots.
    """
    if not document.top.each("scenes"):
        return [i for i, parent in enumerate(parents) if parent < 0]
    scene = document.at("scenes", document.top.integer("scene", 0), document.top)
    roots = list(dict.fromkeys(scene.integers("nodes")))
    for root in roots:
        if root >= len(parents):
            raise scene.error(f"refers to nodes[{root}], which does not exist")
        if parents[root] >= 0:
            raise scene.error(f"lists nodes[{root}] as a root, but it is a child of nodes[{parents[root]}]")
    return roots


def _descended(roots: list[int], children: list[list[int]]) -> list[int]:
    order, waiting = [], roots[::-1]
    while waiting:
        node = waiting.pop()
        order.append(node)
        waiting.extend(reversed(children[node]))
    return order


def _local(node: Fields) -> Floats:
    matrix = _matrix(node)
    return composed(*rest_parts(node)) if matrix is None else matrix


def _matrix(node: Fields) -> Floats | None:
    numbers = node.numbers("matrix", 16)
    if numbers is None:
        return None
    matrix = np.array(numbers).reshape(4, 4).T
    if not np.array_equal(matrix[3], [0, 0, 0, 1]):
        raise node.error("has a matrix that is not affine")
    return matrix


def rest_parts(node: Fields) -> tuple[Floats, Floats, Floats]:
    """Return a node's translation, rotation and scale at rest.

    Raises:
        FileError: they are no such numbers.
    """
    matrix = _matrix(node)
    if matrix is not None:
        return decomposed(matrix)
    translation = np.array(node.numbers("translation", 3) or [0.0, 0, 0])
    rotation = np.array(node.numbers("rotation", 4) or [0.0, 0, 0, 1])
    scale = np.array(node.numbers("scale", 3) or [1.0, 1, 1])
    length = np.linalg.norm(rotation)
    if not 0 < length < np.inf:
        raise node.error("has a rotation of no direction")
    return translation, rotation / length, scale
