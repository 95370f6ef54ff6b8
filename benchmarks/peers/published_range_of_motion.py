"""Range of motion (Ribera et al. 2017) as reproduced by M. Stettler: the only public code for it (MIT).

Install:

    git clone https://github.com/michaelStettler/FacialRetargeting
    export MIEN_PEER_FACIAL_RETARGETING=$PWD/FacialRetargeting
    pip install seaborn

Its steps are called in the order of its own script `06_build_actor_blendshapes.py`, then those of
`07_retarget.py`, with the constants of its configuration (α = β = 1, µ = 0.3, ν = 0.6).  What
that script reads from Maya comes from the case; head motion is taken out by mien, since its
own needs markers on a helmet.  Systems of `KM × KM` are solved densely, so 41 markers are
much quicker than 99.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from benchmarks.peers.adapter import Absent, Peer, PeerRetargeter, checkout, with_solver
from mien.capture import Neutral
from mien.core import Clip, Correspondence, Examples, Markers, Rig
from mien.core.arrays import Floats
from mien.geometry.laplacian import cotangent_laplacian
from mien.retargeting import make_method
from mien.retargeting.prepare import prepare
from mien.retargeting.shape_retargeter import check_markers

VARIABLE = "MIEN_PEER_FACIAL_RETARGETING"
ALPHA, BETA, MU, NU = 1.0, 1.0, 0.3, 0.6
STILL = 1e-6
"""A shape that moves no point by this [cm] cannot be correlated with anything, and is left out."""


@dataclass(frozen=True)
class Reproduction:
    """The reproduction, called step by step."""

    name: ClassVar[str] = "published-range-of-motion"
    about: ClassVar[str] = "M. Stettler's reproduction of Ribera et al. 2017"
    needs: ClassVar[str] = "markers"

    def fit(
        self,
        character: Rig,
        training: Markers | Clip,
        pairs: Correspondence | None = None,
        *,
        neutral: Neutral | None = None,
        rigid: Sequence[str] = (),
        head_moves: bool = True,
        examples: Examples | None = None,
    ) -> PeerRetargeter:
        """Make the actor's shapes as it does."""
        del examples
        take, correspondence = check_markers(training, pairs, self.name)
        prepared = prepare(character, take, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves)
        base = make_method("direct").fit(
            character, take, correspondence, neutral=neutral, rigid=rigid, head_moves=head_moves
        )
        terms = prepared.terms
        kept = np.flatnonzero(np.linalg.norm(terms.deltas, axis=2).max(axis=1) > STILL)
        size, actor_size = (_size(points) for points in (terms.character_neutral, terms.actor_neutral))
        rest, actor = (points - points.min(axis=0) for points in (terms.character_neutral, terms.actor_neutral))
        moved = np.nan_to_num(prepared.take) / actor_size
        with contextlib.redirect_stdout(io.StringIO()):
            shapes, order = _shapes(moved, terms.deltas[kept] / size, rest / size, actor / actor_size)
        bent = _bent(character, kept[order], size * terms.character_centimetre)
        return with_solver(base, _Solve(shapes, kept[order], bent, actor_size, len(terms.deltas)))


@dataclass(frozen=True, eq=False)
class _Solve:
    """Its solve of a frame, on its own shapes and in its own units."""

    shapes: Floats
    kept: np.ndarray
    bent: Floats
    unit: float
    count: int

    def __call__(self, shapes: Floats, take: Floats, fps: float) -> Floats:
        del shapes, fps
        energy = importlib.import_module("src.ERetarget").ERetarget(self.shapes, self.bent, mu=MU, nu=NU)
        weights = np.zeros((len(take), self.count))
        for frame, row in enumerate(np.nan_to_num(take).reshape(len(take), -1) / self.unit):
            energy.set_af(row)
            weights[frame, self.kept] = np.linalg.solve(*energy.get_dERetarget())
        return weights


def _shapes(moved: Floats, deltas: Floats, rest: Floats, actor: Floats) -> tuple[Floats, np.ndarray]:
    """Return its personalised shapes `(K, 3M)`, largest first, and their order; everything in its units."""
    part: Any = importlib.import_module
    ordered, order = part("utils.re_order_delta").re_order_delta(deltas)
    flat, frames = ordered.reshape(len(ordered), -1), moved.reshape(len(moved), -1)
    frames = frames[np.linalg.norm(frames, axis=1) > 0]
    correlation = part("src.compute_corr_coef")
    similar = correlation.compute_corr_coef(frames, flat)
    trust = part("src.compute_trust_values").compute_trust_values(flat)
    similar = correlation.compute_tilda_corr_coef(similar, trust)
    keys = part("utils.get_key_expressions").get_key_expressions(similar, ksize=3, theta=2)
    mask = part("src.get_soft_mask").get_soft_mask(ordered)
    guess = part("src.RBF_warp").get_initial_actor_blendshapes(rest, actor, ordered)
    align = part("src.EAlign").EAlign(similar[:, keys], mask, frames[keys], guess, rest, flat, alpha=ALPHA, beta=BETA)
    return np.asarray(align.compute_actor_specific_blendshapes(vectorized=False)), np.asarray(order)


def _size(points: Floats) -> float:
    """Return the longest side of the box around a face, which it divides by."""
    return float(np.ptp(points, axis=0).max())


def _bent(character: Rig, kept: np.ndarray, unit: float) -> Floats:
    """Return `(K, 3N)` the Laplacians of the shapes, which its script gets from PyMesh."""
    laplacian = cotangent_laplacian(character.neutral.vertices, character.neutral.triangles)
    return np.stack([(laplacian @ (character.blendshapes.deltas[k] / unit)).ravel() for k in kept])


def reproduction() -> Reproduction:
    checkout(VARIABLE, ".", "src/EAlign.py")
    if importlib.util.find_spec("seaborn") is None:
        raise Absent("seaborn, which it imports, is not installed")
    if not hasattr(np, "in1d"):
        np.in1d = np.isin  # it was written for NumPy 1
    return Reproduction()


REPRODUCED = (Peer(Reproduction.name, Reproduction.about, f"a checkout named by {VARIABLE}", reproduction),)
