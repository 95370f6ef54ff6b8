"""Positions and movements of a whole clip as one problem.

    min_w  Σ_f 1/M |Δa_f − P w_f|²  +  λ Σ_f 1/M |(Δa_{f+1} − Δa_f) − P (w_{f+1} − w_f)|²  +  R(w)

`P` are the actor's own blendshapes at the markers, and `R` is all that the per-frame solve adds:
damping, prior, sparsity, bounds, and smoothness, which here ties both neighbours.  A marker that is
missing in a frame has no position there and no movement into or out of it.  Frames that see nothing
are no part of the problem: the movement across such a gap is one movement that takes longer, and
weights in the gap are interpolated, which is what the sum over its frames would come to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mien.core.arrays import Flags, Floats, Ints
from mien.retargeting.energy import RATE, FrameSolver
from mien.solve import LassoProblem, solve_lasso
from mien.solve.spacetime import ClipProblem, solve_clip, solve_uniform

TOLERANCE = 1e-8
"""KKT residual to reach."""
SPAN = 4000
"""Frames that are solved at once: memory grows with them."""
SHARED = 300
"""Frames by which one span reaches into the next, passing over into it; far more than weights reach in time."""
Sight = tuple[bytes, int]
"""Which markers are seen, and for pairs of frames how far apart these are."""


@dataclass(frozen=True, eq=False)
class MovementSolver:
    """Solves a clip for weights whose positions and movements match the markers.

    Attributes:
        frame: what a frame pays for its positions, and the rest of the energy.
        velocity: λ at 30 frames a second; movements are per frame, so it counts `(fps / 30)²` times as much at others.
    """

    frame: FrameSolver
    velocity: float

    def clip(self, take: Floats, fps: float) -> tuple[Floats, float]:
        """Solve a whole take.

        Args:
            take: `(F, M, 3)` displacements [cm]; NaN where a marker is missing.
            fps: frames per second.

        Returns:
            `(F, K)` weights, and the KKT residual.
        """
        seen = ~np.isnan(take[..., 0])
        kept = np.flatnonzero(seen.any(axis=1))
        weights, worst = np.zeros((len(kept), len(self.frame.shapes))), 0.0
        for begin in range(0, max(len(kept) - SHARED, 1), SPAN):
            span = slice(begin, begin + SPAN + SHARED)
            found, residual = self._span(take[kept[span]], np.diff(kept[span]), fps)
            if begin:
                later = np.linspace(0, 1, len(found[:SHARED]))[:, None]
                found[:SHARED] = (1 - later) * weights[span][:SHARED] + later * found[:SHARED]
            weights[span], worst = found, max(worst, residual)
        return _over_gaps(weights, kept, len(take)), worst

    def _span(self, take: Floats, steps: Ints, fps: float) -> tuple[Floats, float]:
        """Solve frames that each see something, all at once."""
        if not len(take):
            return np.zeros((0, len(self.frame.shapes))), 0.0
        problem, uniform = self.problem(take, steps, fps)
        if uniform is not None:
            weights = solve_uniform(*uniform, problem.load)
        else:
            weights = solve_clip(problem, np.zeros(problem.load.shape), tol=TOLERANCE).weights
        return weights, problem.kkt(weights)

    def problem(self, take: Floats, steps: Ints, fps: float) -> tuple[ClipProblem, tuple[Floats, Floats] | None]:
        """Return the problem of frames that each see something.

        Args:
            take: `(F, M, 3)` displacements [cm], NaN where missing.
            steps: `(F − 1,)` how many frames later the next one is.
            fps: frames per second.

        Returns:
            The problem; and its Gram matrix and link if all frames are alike and nothing is bounded.
        """
        seen = ~np.isnan(take[..., 0])
        data = np.where(seen[..., None], take, 0.0).reshape(len(take), -1)
        sight = [(row.tobytes(), 0) for row in seen]
        ties = [((a & b).tobytes(), int(n)) for a, b, n in zip(seen[:-1], seen[1:], steps, strict=True)]
        grams, which = _numbered(sight)
        joints, joined = _numbered(ties)
        count = len(self.frame.shapes)
        load, blocks, links = np.empty((len(take), count)), [], []
        for number, (key, _) in enumerate(grams):
            mine = which == number
            problem, scaled = self.frame.problem(_flags(key))
            blocks.append(problem.gram)
            load[mine] = data[mine] @ scaled.T
        for number, (key, n) in enumerate(joints):
            link, scaled = self._link(_flags(key), fps, n)
            links.append(link)
            before = np.flatnonzero(joined == number)
            pull = (data[before + 1] - data[before]) @ scaled.T
            np.subtract.at(load, before, pull)
            np.add.at(load, before + 1, pull)
        limits = (self.frame.l1, self.frame.lower, self.frame.upper)
        tied = np.array(links).reshape(-1, count, count)
        whole = ClipProblem(*_with_ties(np.array(blocks), which, tied, joined), tied, joined, load, *limits)
        free = not self.frame.l1.any() and not np.isfinite([self.frame.lower, self.frame.upper]).any()
        alike = free and len(blocks) == 1 and len(links) == 1
        return whole, (blocks[0], links[0]) if alike else None

    def step(
        self, displacements: Floats, before: Floats | None, left: Floats | None, fps: float
    ) -> tuple[Floats, Floats]:
        """Solve one frame `(M, 3)` from the one before alone: the clip's energy with the past held fixed.

        Args:
            displacements: of the markers [cm], NaN where missing.
            before: `(K,)` weights of the frame before.
            left: `(M, 3)` what they left of the markers' displacements, NaN where missing.
            fps: frames per second.

        Returns:
            `(K,)` weights, and `(M, 3)` what they leave.
        """
        seen = ~np.isnan(displacements[:, 0])
        if before is None or left is None or not seen.any():
            weights = self.frame.step(displacements, before, fps)
            return weights, displacements - np.tensordot(weights, self.frame.shapes, axes=1)
        both = seen & ~np.isnan(left[:, 0])
        problem, scaled = self.frame.problem(seen)
        link, pulled = self._movement(both, fps, 1)
        load = scaled @ np.where(seen[:, None], displacements, 0.0).ravel()
        load += pulled @ np.where(both[:, None], displacements - left, 0.0).ravel()
        limits = (problem.l1, problem.lower, problem.upper)
        tied = LassoProblem(problem.gram + link, *limits)
        solved = solve_lasso(tied, load, before, smoothness=self._smoothness(fps), tol=TOLERANCE)
        return solved.weights, displacements - np.tensordot(solved.weights, self.frame.shapes, axes=1)

    def _link(self, both: Flags, fps: float, steps: int) -> tuple[Floats, Floats]:
        link, scaled = self._movement(both, fps, steps)
        return link + 2 * self._smoothness(fps) / steps * np.eye(len(link)), scaled

    def _movement(self, both: Flags, fps: float, steps: int) -> tuple[Floats, Floats]:
        """Return `2λ/M P Pᵀ` over markers seen in both frames, and `2λ/M P` for their movements."""
        weight = np.where(both, self.frame.confidence, 0.0)
        rate = self.velocity * (fps / RATE) ** 2 / steps
        scaled = self.frame.shapes * (2 * rate * weight / max(weight.sum(), 1e-12))[:, None]
        flat = scaled.reshape(len(scaled), -1)
        return flat @ self.frame.shapes.reshape(len(scaled), -1).T, flat

    def _smoothness(self, fps: float) -> float:
        return self.frame.settings.smooth * (fps / RATE) ** 2


def _numbered(keys: list[Sight]) -> tuple[list[Sight], Ints]:
    """Return the distinct keys, and which of them each is."""
    places: dict[Sight, int] = {}
    numbers = np.array([places.setdefault(key, len(places)) for key in keys], dtype=np.int64)
    return list(places), numbers


def _flags(key: bytes) -> Flags:
    return np.frombuffer(key, dtype=bool)


def _with_ties(blocks: Floats, which: Ints, links: Floats, joined: Ints) -> tuple[Floats, Ints]:
    """Return the distinct sums of a frame's own block and the links to both neighbours, and which each frame has."""
    none = np.array([-1])
    rows = np.column_stack([which, np.r_[none, joined], np.r_[joined, none]])
    kinds, place = np.unique(rows, axis=0, return_inverse=True)
    with_none = np.concatenate([links, np.zeros((1, *blocks.shape[1:]))])
    return blocks[kinds[:, 0]] + with_none[kinds[:, 1]] + with_none[kinds[:, 2]], place.ravel()


def _over_gaps(weights: Floats, kept: Ints, count: int) -> Floats:
    """Return weights of all frames: straight on across gaps, held at the ends."""
    if len(kept) in (0, count):
        return weights if len(kept) else np.zeros((count, weights.shape[1]))
    return np.stack([np.interp(np.arange(count), kept, curve) for curve in weights.T], axis=1)
