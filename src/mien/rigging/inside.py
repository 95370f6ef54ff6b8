"""Teeth, gums and tongue of the face's own: parts that are hidden inside its head.

Nothing on the outside says where they are, so the mouths of two faces are compared as
wholes: the parts inside one are laid on those inside the other, and each part follows
what it then lies on.  A part moves as one piece where what it follows does: teeth are
never torn between the jaws.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from mien.core import Mesh, Skin
from mien.core.arrays import Flags, Floats, Ints
from mien.geometry.surface import exposed, vertex_normals
from mien.rigging.dense import DenseFit
from mien.rigging.parts import Attachment, Box, pieces

HIDDEN = 0.9
"""A part lies inside if at least this share of its vertices cannot be seen from outside."""
THROUGHOUT = 0.8
"""A part that is this tall for all the parts together, such as gums that are one with the tongue, follows what is near."""
GAP = 0.1
"""Parts belong to two jaws if the heights of their middles leave a gap of this share of the height of them all."""
ROUNDS = 20
"""What such a part follows is averaged among neighbours this many times."""
NEAREST = 4
"""Points that are averaged."""
ENOUGH = 300
"""So many vertices of a part tell where it is and whether it can be seen."""


def settled(fit: DenseFit, skin: Skin | None, attached: tuple[Attachment, ...]) -> tuple[Attachment, ...]:
    """Return the attachments, those of the parts inside the mouth settled among each other."""
    others = pieces(fit.source.triangles, ~fit.source_skin)
    sources = hidden(fit.source, others, fit.warp.centres)
    owners = np.concatenate([np.empty(0, np.int64), *others])
    within = np.isin(owners, np.concatenate([owners[:0], *sources]))
    if not within.any():
        return attached
    near = cKDTree(fit.warped[owners])
    unseen = hidden(fit.target, [part.vertices for part in attached], fit.warp(fit.warp.centres))
    mine = {int(ids[0]) for ids in unseen if within[near.query(fit.target.vertices[ids])[1]].mean() > 0.5}
    inner = [part for part in attached if int(part.vertices[0]) in mine]
    if not inner or _certain(inner, sources):
        return attached
    found = {int(part.vertices[0]): part for part in _settle(fit, skin, sources, inner)}
    return tuple(found.get(int(part.vertices[0]), part) for part in attached)


def hidden(mesh: Mesh, parts: list[Ints], landmarks: Floats) -> list[Ints]:
    """Return those parts `(P,)` of a head that cannot be seen from in front of its face.

    Args:
        mesh: the head.
        parts: vertices of each.
        landmarks: `(L, 3)` places on the face; it looks where the skin does there.
    """
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[mesh.triangles] = True
    parts = [ids for ids in parts if used[ids].all()]
    if not parts:
        return []
    looked_at = [_some(ids) for ids in parts]
    normals, every = vertex_normals(mesh.vertices, mesh.triangles), np.concatenate(looked_at)
    ahead = normals[used][cKDTree(mesh.vertices[used]).query(landmarks)[1]].mean(axis=0)
    seen = np.zeros(len(mesh.vertices), np.bool_)
    seen[every] = exposed(mesh, mesh.vertices[every], normals[every], ahead)
    return [ids for ids, some in zip(parts, looked_at, strict=True) if (~seen[some]).mean() >= HIDDEN]


def _some(points: np.ndarray) -> np.ndarray:
    """Return enough of some points, or all if they are few."""
    return points[:: -(-len(points) // ENOUGH)] if len(points) else points


def _certain(parts: list[Attachment], sources: list[Ints]) -> bool:
    """Tell whether each part has one counterpart inside the source, and no two have the same."""
    counterparts = [[row for row, ids in enumerate(sources) if np.isin(part.followed, ids).any()] for part in parts]
    return all(len(rows) == 1 for rows in counterparts) and len({rows[0] for rows in counterparts}) == len(parts)


def _settle(fit: DenseFit, skin: Skin | None, sources: list[Ints], inner: list[Attachment]) -> list[Attachment]:
    """Return what each of the inner parts follows: the upper ones the upper, the lower ones the lower."""
    own = [fit.target.vertices[part.vertices] for part in inner]
    tall = np.array([float(np.ptp(points[:, 1])) for points in own])
    whole = tall < THROUGHOUT * np.ptp(np.concatenate(own)[:, 1]) if len(inner) > 2 else np.ones(len(inner), np.bool_)
    upper, above = _upper_parts(own, whole), _upper_sources(fit, skin, sources)
    result = {}
    if not whole.all():
        every = np.concatenate(sources)
        laid = _laid(fit, every, np.concatenate(own))
        result = {int(row): _softened(_following(fit, inner[row], every, laid), fit) for row in np.flatnonzero(~whole)}
    for high in (True, False):
        rows = [int(row) for row in np.flatnonzero(whole) if upper[row] == high]
        alike = [ids for ids, up in zip(sources, above, strict=True) if up == high or not any(upper)]
        places = [own[row] for row in rows]
        chosen = _chosen(fit, [inner[row] for row in rows], alike or sources, places)
        first = {int(ids[0]): ids for ids in chosen}
        laid_by = {number: _laid(fit, ids, np.concatenate(places)) for number, ids in first.items()}
        for row, ids in zip(rows, chosen, strict=True):
            result[row] = _following(fit, inner[row], ids, laid_by[int(ids[0])])
    return [result[row] for row in range(len(inner))]


def _chosen(fit: DenseFit, parts: list[Attachment], sources: list[Ints], own: list[Floats]) -> list[Ints]:
    """Return which part of one jaw of the source each part of the same jaw of the target follows.

    As many parts as the source has are paired from front to back: teeth are before the
    tongue.  Others follow their only counterpart, or, as a row of single teeth does, the foremost.
    """
    if len(parts) == len(sources):
        depth = np.argsort(np.argsort([points[:, 2].mean() for points in own]))
        behind = np.argsort([fit.warped[ids, 2].mean() for ids in sources])
        return [sources[behind[rank]] for rank in depth]
    foremost = int(np.argmax([fit.warped[ids, 2].mean() for ids in sources]))
    found = []
    for one in parts:
        only = [ids for ids in sources if one.counterpart and np.isin(one.followed, ids).all()]
        found.append(only[0] if only else sources[foremost])
    return found


def _following(fit: DenseFit, part: Attachment, vertices: Ints, places: Floats) -> Attachment:
    """Let a part of the target follow vertices of the source that were laid on it and what is beside it."""
    weights = _means(places, fit.target.vertices[part.vertices], vertices, len(fit.source.vertices))
    return Attachment(part.vertices, weights, True, vertices)


def _softened(part: Attachment, fit: DenseFit) -> Attachment:
    """Let what a part follows pass gradually from one of its vertices to the next: a palate is not torn from a tongue."""
    number = np.full(len(fit.target.vertices), -1)
    number[part.vertices] = np.arange(len(part.vertices))
    own = number[fit.target.triangles]
    own = own[(own >= 0).all(axis=1)]
    ends = np.concatenate([own[:, [i, (i + 1) % 3]] for i in range(3)])
    count = len(part.vertices)
    linked = sparse.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    linked = sparse.csr_matrix(linked + linked.T + sparse.eye(count))
    step = sparse.diags(1 / np.asarray(linked.sum(axis=1)).ravel()) @ linked
    weights = part.weights
    for _ in range(ROUNDS):
        weights = sparse.csr_matrix(step @ weights)
    return Attachment(part.vertices, weights, part.counterpart, part.followed)


def _laid(fit: DenseFit, vertices: Ints, own: Floats) -> Floats:
    """Return where vertices of the source come to lie on points of the target: where the warp takes them, or so that
    they fill the same box, whichever is closer.
    """
    warped, here, there = fit.warped[vertices], Box.of(fit.warped[vertices]), Box.of(own)
    filled = (warped - here.low) / (here.high - here.low) * (there.high - there.low) + there.low
    some = _some(own)
    return min((warped, filled), key=lambda places: _apart(_some(places), some))


def _upper_parts(parts: list[Floats], whole: Flags) -> list[bool]:
    """Tell which parts are above the widest gap between the heights of their middles; all are alike if none is wide."""
    heights = np.array([points[:, 1].mean() for points in parts])
    ranked = np.sort(heights[whole])
    gaps = np.diff(ranked)
    extent = float(np.ptp(np.concatenate(parts)[:, 1]))
    if not len(gaps) or gaps.max() < GAP * extent:
        return [False] * len(parts)
    return [bool(height > ranked[gaps.argmax()]) for height in heights]


def _upper_sources(fit: DenseFit, skin: Skin | None, sources: list[Ints]) -> list[bool]:
    """Tell which parts of the source belong to the upper jaw: the highest, and what the same joint holds."""
    heights = [float(fit.warped[ids, 1].mean()) for ids in sources]
    highest = int(np.argmax(heights))
    if skin is None:
        return [row == highest for row in range(len(sources))]
    held = [_strongest(skin, ids) for ids in sources]
    return [joint == held[highest] for joint in held]


def _strongest(skin: Skin, vertices: Ints) -> int:
    return int(np.bincount(skin.joints[vertices].ravel(), skin.weights[vertices].ravel()).argmax())


def _apart(some: Floats, others: Floats) -> float:
    """Return the mean distance between two sets of points, each to the nearest of the other."""
    there, back = cKDTree(others).query(some)[0], cKDTree(some).query(others)[0]
    return float(there.mean() + back.mean())


def _means(points: Floats, queries: Floats, numbers: Ints, count: int) -> sparse.csr_matrix:
    """Return `(Q, count)` means over the nearest of some numbered points, by inverse squared distance."""
    k = min(NEAREST, len(points))
    apart, which = (np.reshape(found, (len(queries), k)) for found in cKDTree(points).query(queries, k))
    weights = 1 / np.maximum(apart, 1e-6 * float(np.ptp(points, axis=0).max()) + 1e-100) ** 2
    weights /= weights.sum(axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(queries)), k)
    return sparse.csr_matrix((weights.ravel(), (rows, numbers[which.ravel()])), shape=(len(queries), count))
