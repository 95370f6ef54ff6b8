"""Covering the rest of a head with even triangles, from the borders of its features to its neck.

Points are thrown on the skin no closer to each other than a length that grows away
from the features, joined in the flat disc, and a few times moved to the middle of
their neighbours: the triangles end up even and of no particular direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from mien.core.arrays import Flags, Floats, Ints
from mien.library.heads.clay import cast, settled
from mien.library.heads.joining import joined
from mien.library.heads.unfold import Core, within
from mien.library.modelling.half import Half
from mien.library.modelling.solids import Solids


@dataclass(frozen=True)
class Cover:
    """How the skin between the features is covered.

    Attributes:
        core: the bar from which the whole skin is seen.
        edge: length of edges in front and at the back [cm].
        depths: the depths between which it changes from one to the other [cm].
        growth: by how much edges may lengthen per length of the way from a feature.
    """

    core: Core
    edge: tuple[float, float]
    depths: tuple[float, float] = (-4.0, 4.0)
    growth: float = 0.3

    def length(self, points: Floats, borders: cKDTree, at_border: Floats) -> Floats:
        """Return the wanted edge length at each point."""
        distance, nearest = borders.query(points)
        return np.asarray(np.minimum(self.far_length(points), at_border[nearest] + self.growth * distance))

    def far_length(self, points: Floats) -> Floats:
        """Return the edge length at each point if no feature is near."""
        share = np.clip((points[:, 2] - self.depths[0]) / (self.depths[1] - self.depths[0]), 0, 1)
        return np.asarray(self.edge[1] + share * (self.edge[0] - self.edge[1]))


def cover(half: Half, solids: Solids, plan: Cover, borders: list[Ints], pins: Floats, below: Floats) -> Ints:
    """Cover the skin between `borders` (the neck's the last) and return the vertices of the pinned places.

    Args:
        half: the half being put together.
        solids: what the skin is blended from.
        plan: how long the edges are.
        borders: rings that run counter-clockwise, closed or from midline to midline.
        pins: `(P, 3)` places that must be vertices.
        below: `(4,)` the neck's plane: points where `below · (x, y, z, 1)` is negative are cut off.
    """
    known = np.concatenate(half.vertices)
    rim = known[np.concatenate(borders)]
    rim_edge = np.concatenate([_edges(known[b]) for b in borders])
    tree = cKDTree(rim)
    polygons = [_hole(plan.core.flat(known[b]), bool(known[b[0], 0] == 0)) for b in borders]
    candidates = _candidates(solids, plan)
    keep = (candidates[:, :3] @ below[:3] + below[3]) > 0.3 * plan.edge[1]
    flat = plan.core.flat(candidates)
    for polygon in polygons:
        keep &= ~within(polygon, flat)
    candidates = candidates[keep]
    length = plan.length(candidates, tree, rim_edge)
    keep = (candidates[:, 0] == 0) | (candidates[:, 0] > 0.55 * length)
    pins = settled(solids, pins, 4)
    fixed = np.concatenate([rim, pins])
    keep &= cKDTree(fixed).query(candidates)[0] > 0.75 * length
    candidates, length = candidates[keep], length[keep]
    free = candidates[_thrown(candidates, length, candidates[:, 0] == 0)]
    points, triangles = _relaxed(solids, plan.core, polygons, fixed, settled(solids, free))
    added = half.add(points[len(rim) :], "face")
    half.triangles.append(np.concatenate([*borders, added])[triangles])
    return added[: len(pins)]


def _hole(ring: Floats, open_ring: bool) -> Floats:
    """Return the polygon a border cuts out of the disc; one that ends on the midline is closed outside."""
    return np.concatenate([ring, 1.5 * ring[[-1, 0]]]) if open_ring else ring


def _edges(ring: Floats) -> Floats:
    step = np.linalg.norm(np.diff(ring, axis=0), axis=1)
    return np.concatenate([step, step[-1:]])


def _candidates(solids: Solids, plan: Cover) -> Floats:
    """Return places near the skin, many to each wanted triangle, those on the midline first."""
    core, side = plan.core, np.linspace(-1.04, 1.04, 61)
    lattice = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2)
    origin, out = core.rays(lattice)
    hit = cast(solids, origin + 40 * out, -out, 25)
    reach = np.linalg.norm(hit - origin, axis=1).reshape(61, 61)
    grid = hit.reshape(61, 61, 3)
    area = np.linalg.norm(np.cross(np.gradient(grid, axis=0), np.gradient(grid, axis=1)), axis=2).ravel()
    area[(lattice**2).sum(axis=1) > 1.05] = 0
    share = area / plan.far_length(hit) ** 2
    rng = np.random.default_rng(0)
    cell = rng.choice(len(lattice), 6000, p=share / share.sum())
    disc = lattice[cell] + rng.uniform(-0.5, 0.5, (6000, 2)) * (side[1] - side[0])
    disc = disc[(disc**2).sum(axis=1) < 1]
    turn = np.linspace(0, 2 * np.pi, 900, endpoint=False)
    flat = np.concatenate([np.stack([np.cos(turn), np.sin(turn)], axis=1), disc])
    origin, out = core.rays(flat)
    points = origin + map_coordinates(reach, (flat.T + 1.04) / (side[1] - side[0]), order=1)[:, None] * out
    points[: len(turn), 0] = 0
    return np.asarray(points)


def _thrown(points: Floats, length: Floats, first: Flags) -> Ints:
    """Return points no two of which are closer than their length; those that come `first` are never displaced."""
    pairs = cKDTree(points).query_pairs(length.max(), output_type="ndarray")
    apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    pairs = pairs[apart < 0.86 * np.minimum(length[pairs[:, 0]], length[pairs[:, 1]])]
    order = np.random.default_rng(0).permutation(len(points)) + len(points) * ~first
    state = np.zeros(len(points), np.int8)
    while (state == 0).any():
        open_pairs = pairs[(state[pairs] == 0).all(axis=1)]
        lowest = order.copy()
        np.minimum.at(lowest, open_pairs[:, 0], order[open_pairs[:, 1]])
        np.minimum.at(lowest, open_pairs[:, 1], order[open_pairs[:, 0]])
        chosen = (state == 0) & (lowest == order)
        state[chosen] = 1
        beaten = open_pairs[chosen[open_pairs].any(axis=1)].ravel()
        state[beaten[~chosen[beaten]]] = 2
    return np.flatnonzero(state == 1)


def _relaxed(solids: Solids, core: Core, polygons: list[Floats], fixed: Floats, free: Floats) -> tuple[Floats, Ints]:
    """Return all points and their triangles after moving the free ones to the middle of their neighbours."""
    points = np.concatenate([fixed, free])
    count, movable = len(points), np.arange(len(fixed), len(points))
    for _ in range(4):
        t = joined(core, polygons, points)
        rows, columns = t[:, [0, 1, 2]].ravel(), t[:, [1, 2, 0]].ravel()
        total, links = np.zeros((count, 3)), np.zeros(count)
        for a, b in ((rows, columns), (columns, rows)):
            np.add.at(total, a, points[b])
            np.add.at(links, a, 1)
        middle = total[movable] / np.maximum(links[movable, None], 1)
        moved = points[movable] + 0.7 * (links[movable, None] > 0) * (middle - points[movable])
        moved[points[movable, 0] == 0, 0] = 0
        moved = settled(solids, moved, 1)
        flat = core.flat(moved)
        astray = np.any([within(polygon, flat) for polygon in polygons], axis=0)
        points[movable] = np.where(astray[:, None], points[movable], moved)
    return points, joined(core, polygons, points)
