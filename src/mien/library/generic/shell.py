"""The skin between the rings: directions spread evenly around them, each carried out to the solids.

The grid is finest in front and where a head asks for it.  Each new direction is the one
farthest from all that are there, and a few rounds of relaxation even them out; their
spherical Delaunay triangulation then joins them to the rings.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from mien.core.arrays import Flags, Floats, Ints
from mien.library.generic.measures import Measures, front
from mien.library.modelling.half import Half
from mien.library.modelling.solids import first_hit

CANDIDATE_STEP = np.radians(1.6)
ROUNDS = 4
PAIRS = ([0, 1], [1, 2], [2, 0], [1, 0], [2, 1], [0, 2])
"""The edges of a triangle, in both directions."""


def shell(half: Half, m: Measures, borders: list[Ints]) -> None:
    """Cover the rest of the head from the rings' borders to the neck."""
    rims = [*borders, _neck(half, m)]
    outlines = [_flattened(_directions(np.concatenate(half.vertices)[rim], m)) for rim in rims]
    fixed = np.concatenate([*rims, _anchors(half, m, rims, outlines)])
    taken = _directions(np.concatenate(half.vertices)[fixed], m)
    rays = _relaxed(taken, _spread(taken, outlines, m), outlines, m)
    ids = np.concatenate([fixed, half.add(_carried_out(rays, m), "face")])
    half.triangles.append(ids[_joined(np.concatenate([taken, rays]), outlines)])


def _anchors(half: Half, m: Measures, rims: list[Ints], outlines: list[Floats]) -> Ints:
    """Add a vertex at each named place and on the brow, if clear of the rings, so that landmarks lie on them."""
    rays = _directions(np.concatenate([list(m.places.values()), front(m, np.array(m.brow[:3]))]), m)
    rays = rays[~_enclosed(rays, outlines)]
    taken = _directions(np.concatenate(half.vertices)[np.concatenate(rims)], m)
    clear = np.arccos(np.clip(rays @ taken.T, -1, 1)).min(axis=1) > 0.5 * _spacing(rays, m)
    return half.add(_carried_out(rays[clear], m), "face")


def _neck(half: Half, m: Measures) -> Ints:
    """Add the ring at which the neck is cut."""
    turn = np.linspace(0, np.pi, 17)
    ring = np.stack([np.sin(turn), np.zeros(17), np.cos(turn)], axis=1)
    ring[[0, -1], 0] = 0
    level = np.array([0.0, m.neck, 0.3 * m.centre[2] - 2])
    return half.add(first_hit(m.solids, level + 25 * ring, -ring), "face", "neck")


def _carried_out(rays: Floats, m: Measures) -> Floats:
    """Return where the skin is in these directions from the head's centre."""
    return first_hit(m.solids, np.array(m.centre) + 25 * rays, -rays)


def _directions(points: Floats, m: Measures) -> Floats:
    rays = points - m.centre
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


def _spacing(rays: Floats, m: Measures) -> Floats:
    """Return the distance that grid points should keep around each direction [rad]."""
    near, far = np.radians(m.spacing)
    angle = np.arccos(np.clip(rays[:, 2], -1, 1))
    wanted = near + (far - near) * (angle / np.pi) ** 1.2
    for place, reach, share in m.fine:
        towards = np.subtract(place, m.centre)
        distance = np.linalg.norm(towards)
        off = np.arccos(np.clip(rays @ towards / distance, -1, 1)) * distance / reach
        wanted *= 1 - (1 - share) * np.exp(-(off**4))
    return np.asarray(wanted)


def _spread(taken: Floats, outlines: list[Floats], m: Measures) -> Floats:
    """Return directions clear of the rings and of what they enclose, those on the midline first."""
    turn = np.arange(0, 2 * np.pi, CANDIDATE_STEP / 3)
    midline = np.stack([0 * turn, np.sin(turn), np.cos(turn)], axis=1)
    midline = _farthest(midline[~_enclosed(midline, outlines)], taken, m)
    polar, candidates = 0.0, []
    while (polar := polar + CANDIDATE_STEP) < np.pi:
        turn = np.arange(CANDIDATE_STEP / 2, np.pi, CANDIDATE_STEP / np.sin(polar))
        ring = [np.sin(polar) * np.sin(turn), np.sin(polar) * np.cos(turn), 0 * turn + np.cos(polar)]
        candidates.append(np.stack(ring, axis=1))
    rest = np.concatenate(candidates)
    rest = rest[~_enclosed(rest, outlines)]
    return np.concatenate([midline, _farthest(rest, np.concatenate([taken, midline]), m)])


def _farthest(candidates: Floats, taken: Floats, m: Measures) -> Floats:
    """Choose, again and again, the candidate with the most room, until none has room enough."""
    wanted = _spacing(candidates, m)
    mirror = np.where(candidates[:, 0] > 0, 2 * np.arcsin(np.clip(candidates[:, 0], 0, 1)), np.inf)
    room = np.minimum(np.arccos(np.clip(candidates @ taken.T, -1, 1)).min(axis=1), mirror) / wanted
    chosen = []
    while room[best := int(room.argmax())] > 0.72:
        chosen.append(best)
        chord = np.sqrt(np.maximum(2 - 2 * (candidates @ candidates[best]), 0))
        room = np.minimum(room, chord / wanted)
    return candidates[chosen]


def _relaxed(taken: Floats, free: Floats, outlines: list[Floats], m: Measures) -> Floats:
    """Even out the free directions: each goes to the mean of its neighbours, the midline staying on itself."""
    on_midline, first = free[:, 0] == 0, len(taken)
    for _ in range(ROUNDS):
        rays = np.concatenate([taken, free])
        triangles = _joined(rays, outlines)
        edges = np.concatenate([triangles[:, pair] for pair in PAIRS])
        edges = np.stack(np.divmod(np.unique(edges[:, 0] * len(rays) + edges[:, 1]), len(rays)), axis=1)
        wanted = 1 / np.concatenate([_spacing(taken, m), _spacing(free, m)])[edges[:, 1]]
        total, weight = np.zeros_like(rays), np.zeros(len(rays))
        np.add.at(total, edges[:, 0], wanted[:, None] * rays[edges[:, 1]])
        np.add.at(weight, edges[:, 0], wanted)
        mean = total[first:] / np.maximum(weight[first:, None], 1e-12)
        mean[on_midline, 0] = 0
        free = 0.5 * (free + mean)
        free /= np.linalg.norm(free, axis=1, keepdims=True)
    return free


def _joined(rays: Floats, outlines: list[Floats]) -> Ints:
    """Return the triangles between directions of the left half, facing outwards, with the rings left open."""
    triangles: Ints = np.asarray(ConvexHull(rays).simplices, dtype=np.int64)
    corners = rays[triangles]
    triangles = triangles[~(corners[..., 0] == 0).all(axis=1) & ~_enclosed(corners.mean(axis=1), outlines)]
    corners = rays[triangles]
    inward = np.linalg.det(corners) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return np.asarray(triangles)


def _flattened(rays: Floats) -> Floats:
    """Return directions as seen from behind through the front of the sphere (stereographic), `(n, 2)`."""
    length = np.linalg.norm(rays, axis=1)
    return np.asarray(rays[:, :2] / (length + rays[:, 2])[:, None])


def _enclosed(rays: Floats, outlines: list[Floats]) -> Flags:
    """Return which directions lie within one of the outlines (even-odd rule)."""
    x, y = _flattened(rays).T
    inside = np.zeros(len(rays), dtype=bool)
    for outline in outlines:
        within = np.zeros(len(rays), dtype=bool)
        for (x0, y0), (x1, y1) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
            if y0 != y1:
                crosses = (y0 > y) != (y1 > y)
                within ^= crosses & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        inside |= within
    return inside
