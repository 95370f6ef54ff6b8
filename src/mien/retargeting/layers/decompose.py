"""An actor's points taken apart into layers, frame by frame.

The fit term is the mean over the points of the squared distance in human centimetres
(`core.units`), so that λ and γ depend neither on units nor on the number of points; a point
that is not seen in a frame says nothing in it: its part is taken out of the Gram matrices and
the rest keeps its weight.

The bias (§4) is `γ = closure · exp(−d²/2σ²) · (1 − exp(−o²/2σ²))`, with `d` in inter-ocular
distances: how much farther apart the centres of the lips are than in the extreme with closed lips
(points on the skin around the mouth never touch).  `o` is how far they were apart lately: the
largest `d` before, fading within `closing` seconds.  Lips that close are a /p b m/; lips that stay closed
are a mouth at rest, which the last factor leaves to the data.  As published that factor is missing
and `closure` is 1: a face with closed lips is not fitted at all.  σ = 0.02 is as published.

The published λ = 0.2 is for a sum over 323 points in an unknown unit; here it is 0.0001 per mean
squared centimetre at 30 frames a second, and `(fps / 30)²` times that at other rates: on real takes
it costs 1–3 % of the reconstruction and takes a fifth of the jitter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mien.core.arrays import Flags, Floats, Ints
from mien.retargeting.layers.model import LayeredFace
from mien.solve.layered import Bias, LayeredProblem, LayeredSolution, solve_layered
from mien.solve.layered_projection import project_frames

RATE = 30.0
"""The frame rate for which the smoothness is stated."""
INTEROCULAR_CM = 6.3
"""Between the pupils of an adult: the unit of `d`, on a face scaled to human size."""
PROBLEMS = 256
"""Problems kept for sets of seen points that come back."""


@dataclass(frozen=True, eq=False)
class Lips:
    """When the lips are closed, and what then holds.

    Attributes:
        upper, lower: the points at the centres of the lips.
        closed: their distance when closed [cm of a human face].
        sigma: σ, in inter-ocular distances.
        closure: γ when closed, 0 to 1.
        closing: seconds within which an opening is forgotten; 0 if lips count as closed however long
            they have been.
        bias: the mouth, the speech layer, and the coefficients of closed lips.
    """

    upper: int
    lower: int
    closed: float
    sigma: float
    closure: float
    closing: float
    bias: Bias

    def gamma(self, points: Floats, fps: float, opened: float = 0.0) -> tuple[Floats, float]:
        """Return γ of frames, and what the next frame needs to know.

        Args:
            points: `(F, P, 3)` [cm]; γ is 0 where a lip is not seen.
            fps: frames per second.
            opened: how far the lips were apart lately, of the frame before [inter-ocular distances].

        Returns:
            `(F,)`, and `opened` of the last frame.
        """
        between = points[:, self.upper] - points[:, self.lower]
        fading = math.exp(-1 / (self.closing * fps)) if self.closing else 0.0
        gamma = np.zeros(len(between))
        for f, gap in enumerate(np.sqrt((between**2).sum(axis=1)).tolist()):
            lately = fading * opened
            d = 0.0 if math.isnan(gap) else max(gap - self.closed, 0.0) / INTEROCULAR_CM
            opened = max(d, lately)
            if not math.isnan(gap):
                gamma[f] = self.closure * self._near(d) * (1 - self._near(lately) if self.closing else 1.0)
        return gamma, opened

    def _near(self, d: float) -> float:
        return math.exp(-(d**2) / (2 * self.sigma**2))


class Memory(NamedTuple):
    """What a frame needs of the ones before.

    Attributes:
        unknowns: weights and coefficients of the last frame, `LayeredSolution.last`; None at the beginning.
        opened: how far the lips were apart lately, see `Lips.gamma`.
    """

    unknowns: Floats | None = None
    opened: float = 0.0


BEGINNING = Memory()


@dataclass(frozen=True, eq=False)
class Decomposer:
    """What is needed to take a face apart.

    Attributes:
        face: the actor in layers [cm of a human face].
        importance: `(P,)` how much each point counts; the mean is 1.
        smooth: λ.
        lips: the bias; None for none.
    """

    face: LayeredFace
    importance: Floats
    smooth: float
    lips: Lips | None = None

    def decompose(self, moved: Floats, fps: float = RATE) -> LayeredSolution:
        """Take a whole take apart, see `follow`."""
        return self.follow(moved, fps)[0]

    def follow(self, moved: Floats, fps: float = RATE, memory: Memory = BEGINNING) -> tuple[LayeredSolution, Memory]:
        """Take frames apart, in order.

        Args:
            moved: `(F, P, 3)` displacements from rest with the head held still [cm]; NaN where not seen.
            fps: frames per second, for the smoothness.
            memory: of the frames before.

        Returns:
            Weights and coefficients; the same, to the bit, for a take and its frames one by one. A
            frame that sees nothing holds the one before, or is at rest if there is none.  And the
            memory of the frames that follow.
        """
        seen = ~np.isnan(moved[..., 0])
        gamma, (before, opened) = np.zeros(len(moved)), memory
        if self.lips is not None:
            gamma, opened = self.lips.gamma(moved + self.face.rest, fps, opened)
        smooth = self.smooth * (fps / RATE) ** 2
        parts = []
        cuts = [0, *(np.flatnonzero((seen[1:] != seen[:-1]).any(axis=1)) + 1).tolist(), len(moved)]
        for begin, end in pairwise(cuts):
            shown, known = moved[begin:end], seen[begin:end]
            if before is None and not known[0].any():
                shown, known = np.zeros_like(shown), np.ones_like(known)
            data, energy = self.project(shown)
            part = solve_layered(self.problem(known[0], smooth), data, energy, gamma[begin:end], before)
            before = part.last
            parts.append(part)
        return _joined(parts), Memory(before, opened)

    def project(self, moved: Floats) -> tuple[Floats, Floats]:
        """Return `c_l = Bᵀ M_l x̂` `(F, m, N)` and `‖x̂‖²` `(F,)`, means over the points; NaN points say nothing."""
        order, borders, basis = self._sorted
        data = np.empty((len(moved), len(borders) - 1, len(basis)))
        energy = np.empty(len(moved))
        project_frames(basis, borders, order, self._root, np.ascontiguousarray(moved), data, energy)
        return data, energy

    def problem(self, seen: Flags, smooth: float) -> LayeredProblem:
        """Return the problem for frames that see these points `(P,)`."""
        key = (seen.tobytes(), smooth)
        if key not in self._problems:
            if len(self._problems) >= PROBLEMS:
                self._problems.clear()
            bias = None if self.lips is None else self.lips.bias
            self._problems[key] = LayeredProblem(self._gram(seen), self.face.sizes, smooth, bias)
        return self._problems[key]

    def _gram(self, seen: Flags) -> Floats:
        """Return `A_l = Bᵀ M_l B` of the seen points: of all, less those of the others where these are fewer."""
        order = self._sorted[0]
        if seen.all():
            return self._whole
        few = seen.mean() < 0.5
        part = self._products((seen if few else ~seen)[order])
        return part if few else self._whole - part

    def _products(self, chosen: Flags) -> Floats:
        _, borders, basis = self._sorted
        pick = np.repeat(chosen, 3)
        parts = [basis[:, a:b][:, pick[a:b]] for a, b in pairwise(borders)]
        return np.stack([part @ part.T for part in parts])

    @cached_property
    def _whole(self) -> Floats:
        return self._products(np.ones(len(self.face.rest), bool))

    @cached_property
    def _problems(self) -> dict[tuple[bytes, float], LayeredProblem]:
        return {}

    @cached_property
    def _root(self) -> Floats:
        """`(3 P,)` what coordinates are multiplied by so that sums over them are means over points."""
        order, _ = self._sorted_points
        return np.repeat(np.sqrt(self.importance / len(self.importance))[order], 3)

    @cached_property
    def _sorted_points(self) -> tuple[Ints, Ints]:
        of = self.face.regions.of
        order = np.argsort(of, kind="stable")
        borders = 3 * np.searchsorted(of[order], np.arange(len(self.face.regions.names) + 1))
        return order, borders.astype(np.int64)

    @cached_property
    def _sorted(self) -> tuple[Ints, Ints, Floats]:
        """Points in the order of their regions, where each region's coordinates begin, and the basis in that order."""
        order, borders = self._sorted_points
        basis = self.face.basis[:, order].reshape(len(self.face.basis), -1) * self._root
        return order, borders, np.ascontiguousarray(basis)


def residual_mm(face: LayeredFace, found: LayeredSolution, moved: Floats) -> Floats:
    """Return `(F,)` the root-mean-square distance of the seen points from the layered face [mm of a human face]."""
    seen = ~np.isnan(moved[..., 0])
    error = np.where(seen[..., None], moved + face.rest - face.compose(found.weights, found.coefficients), 0.0)
    count = seen.sum(axis=1)
    with np.errstate(invalid="ignore"):
        return np.asarray(10 * np.sqrt(np.where(count > 0, (error**2).sum(axis=(1, 2)) / count, np.nan)))


def outside(face: LayeredFace, found: LayeredSolution, moved: Floats) -> Floats:
    """Return `(F,)` the share of the movement that lies outside the simplices: what eq. 7 cannot follow.

    It is the distance from the composed face over the distance from rest; 0 for a face that
    the extremes can make, and at rest.
    """
    seen = ~np.isnan(moved[..., 0])[..., None]
    error = np.where(seen, moved + face.rest - face.compose(found.weights, found.coefficients), 0.0)
    size = np.sqrt((np.where(seen, moved, 0.0) ** 2).sum(axis=(1, 2)))
    off = np.sqrt((error**2).sum(axis=(1, 2)))
    return np.asarray(np.minimum(off / np.maximum(size, 1e-300), 1.0) * (size > 0))


def _joined(parts: list[LayeredSolution]) -> LayeredSolution:
    if len(parts) == 1:
        return parts[0]
    return LayeredSolution(
        np.concatenate([p.weights for p in parts]),
        np.concatenate([p.coefficients for p in parts]),
        np.concatenate([p.objective for p in parts]),
        np.concatenate([p.kkt for p in parts]),
        np.concatenate([p.rounds for p in parts]),
        all(p.converged for p in parts),
    )
