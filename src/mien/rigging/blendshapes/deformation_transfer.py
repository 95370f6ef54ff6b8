"""Deformation transfer: each triangle of the target deforms as its counterpart on the source does.

Sumner & Popović 2004.  Their fourth vertices appear in one triangle each, so they can be
eliminated exactly: what is left is, for every target triangle,
`min ‖ (S - I) P - ∇u ‖²` over the displacements `u` of its three corners, `P` the
projection onto its plane.  That is a third of the paper's unknowns, the same answer, and
one matrix for all shapes and all coordinates; it is factored once.

The energy does not know where the face is.  Vertices that hardly move in any shape are
held at their displacement by the dense correspondence, so the back of a head does not
drift and shapes stay local; a piece without such vertices is held by one vertex, as in
the paper, and then shifted to where the dense correspondence has its quietest part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from mien.core.arrays import Flags, Floats, Ints
from mien.core.mesh import SurfacePoints
from mien.rigging.blendshapes import dense
from mien.rigging.blendshapes.gradients import deformation, frames, gradient, hat_gradients, upright
from mien.rigging.dense import DenseFit
from mien.rigging.maps import overall
from mien.rigging.warp_and_stick.sheet import twins_of

STILL = 1e-3
"""Vertices that move less than this share of the largest displacement in every shape are held."""
QUIETEST = 0.1
"""A piece without still vertices is placed by this share of it, its quietest."""
BATCH = 8
"""So many shapes are solved at a time; it bounds the memory."""


def transfer(deltas: Floats, fit: DenseFit, back: SurfacePoints) -> Floats:
    """Move shapes `(K, Ns, 3)` onto target skin vertices whose points on the source are `back`; `(K, M, 3)`."""
    own = fit.source.triangles[fit.source_skin[fit.source.triangles].all(axis=1)]
    number = np.cumsum(fit.target_skin) - 1
    triangles = number[fit.target.triangles[fit.target_skin[fit.target.triangles].all(axis=1)]]
    target = fit.target.vertices[fit.target_skin]
    one = _welded(target, triangles)
    guess, turn = dense.transfer(deltas, fit, back), overall(fit).rotation
    return solve(fit.source.vertices, own, deltas, target, one[triangles], back, guess=guess, turn=turn)[:, one]


def _welded(vertices: Floats, triangles: Ints) -> Ints:
    """Return for each vertex `(N,)` the one that stands for it: a texture seam must not become a crack."""
    twins, n = twins_of(vertices, triangles), len(vertices)
    linked = sparse.csr_matrix((np.ones(len(twins)), (twins[:, 0], twins[:, 1])), shape=(n, n))
    label = connected_components(linked, directed=False)[1]
    return np.asarray(np.unique(label, return_index=True)[1][label])


def solve(
    source: Floats, source_triangles: Ints, deltas: Floats, target: Floats, triangles: Ints, back: SurfacePoints,
    *, guess: Floats, turn: Floats,
) -> Floats:  # fmt: skip
    """Find the displacements of a target whose triangles deform as a source's do.

    Args:
        source: `(Ns, 3)` vertices at rest.
        source_triangles: `(Ts, 3)`.
        deltas: `(K, Ns, 3)`.
        target: `(Nt, 3)` vertices at rest.
        triangles: `(Tt, 3)`.
        back: for each target vertex its point on the source.
        guess: `(K, Nt, 3)` displacements for the vertices that are held.
        turn: `(3, 3)` rotation from the source's pose to the target's.

    Returns:
        `(K, Nt, 3)`; a vertex of no triangle keeps its guess.
    """
    whole = upright(target, triangles)
    kept = triangles[whole]
    usable = np.flatnonzero(upright(source, source_triangles))
    origin = usable[counterparts(source, source_triangles[usable], back, kept)]
    needed, origin = np.unique(origin, return_inverse=True)
    inverse: Floats = np.asarray(np.linalg.inv(frames(source, source_triangles[needed])), np.float64)
    corners = source_triangles[needed]

    anchors = Anchors.of(guess, kept)
    free, held = np.flatnonzero(~anchors.held), np.flatnonzero(anchors.held)
    moved = np.array(guess)
    if len(free) == 0:
        return moved
    operator = gradient(hat_gradients(target, kept), kept, len(target))
    across = operator.T.tocsr()
    normal = (across @ operator).tocsr()[free]
    factor = splu(
        normal[:, free].tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    rim = normal[:, held]
    for first in range(0, len(deltas), BATCH):
        batch = slice(first, first + BATCH)
        change = np.stack([deformation(source, inverse, delta, corners) for delta in deltas[batch]])
        wanted = (turn @ change @ turn.T)[:, origin]
        # (k, T, c, a) to rows (T, a), columns (k, c): the gradient of coordinate c along axis a
        rows = wanted.transpose(1, 3, 0, 2).reshape(3 * len(kept), -1)
        edge = guess[batch][:, held].transpose(1, 0, 2).reshape(len(held), -1)
        solved = factor.solve((across @ rows)[free] - rim @ edge)
        moved[batch, free] = solved.reshape(len(free), -1, 3).transpose(1, 0, 2)
    return anchors.placed(moved, guess)


def counterparts(source: Floats, source_triangles: Ints, back: SurfacePoints, triangles: Ints) -> Ints:
    """Return for each target triangle the source triangle whose centre is nearest to where its own centre lies.

    Only triangles around the points of its corners come into question, so a triangle of
    the upper lip never takes one of the lower.

    Args:
        source: `(Ns, 3)`.
        source_triangles: `(Ts, 3)`.
        back: for each target vertex its point on the source.
        triangles: `(T, 3)` of the target.

    Returns:
        `(T,)` indices into `source_triangles`.
    """
    around = _around(source_triangles, len(source))
    middle = source[source_triangles].mean(axis=1)
    placed = back.of(source)
    found = np.empty(len(triangles), np.int64)
    for rows in np.array_split(np.arange(len(triangles)), 1 + len(triangles) // 8192):
        corners = triangles[rows]
        candidates = around[back.corners[corners]].reshape(len(rows), -1)
        apart = ((middle[candidates] - placed[corners].mean(axis=1)[:, None]) ** 2).sum(axis=2)
        apart[candidates < 0] = np.inf
        found[rows] = candidates[np.arange(len(rows)), apart.argmin(axis=1)]
    return found


def _around(triangles: Ints, count: int) -> Ints:
    """`(N, V)` the triangles around each vertex, filled up with -1."""
    flat = triangles.ravel()
    order = np.argsort(flat, kind="stable")
    valence = np.bincount(flat, minlength=count)
    place = np.arange(len(flat)) - np.repeat(np.cumsum(valence) - valence, valence)
    around = np.full((count, int(valence.max(initial=1))), -1, np.int64)
    around[flat[order], place] = order // 3
    return around


@dataclass(frozen=True, eq=False)
class Anchors:
    """What fixes the place of a surface whose gradients are prescribed.

    Attributes:
        held: `(N,)` vertices that keep their guess: the still ones, those of no triangle, and
            one of every piece that has none.
        loose: of each such piece, its vertices and its quietest ones.
    """

    held: Flags
    loose: tuple[tuple[Ints, Ints], ...]

    @classmethod
    def of(cls, guess: Floats, triangles: Ints) -> Anchors:
        """Choose anchors for guessed displacements `(K, N, 3)` of a surface."""
        count = guess.shape[1]
        motion = np.sqrt((guess**2).sum(axis=2).max(axis=0, initial=0.0))
        held = motion <= STILL * motion.max(initial=0.0)
        edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
        linked = sparse.csr_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
        piece = connected_components(linked, directed=False)[1]
        loose = []
        for number in np.flatnonzero(np.bincount(piece, held) == 0):
            members = np.flatnonzero(piece == number)
            quiet = members[np.argsort(motion[members], kind="stable")][: max(1, int(QUIETEST * len(members)))]
            held[quiet[0]] = True
            loose.append((members, quiet))
        return cls(held, tuple(loose))

    def placed(self, moved: Floats, guess: Floats) -> Floats:
        """Shift the loose pieces of `(K, N, 3)` to where the guess has their quietest vertices."""
        for members, quiet in self.loose:
            moved[:, members] += (guess[:, quiet] - moved[:, quiet]).mean(axis=1)[:, None]
        return moved
