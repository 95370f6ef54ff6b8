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
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mien.core.arrays import Flags, Floats
from mien.retargeting.layers.model import LayeredFace
from mien.solve.layered import Bias, LayeredProblem, LayeredSolution, solve_layered
from mien.solve.layered_projection import Layout, lay_out, project_frames

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

    def gap(self, moved: Floats, rest: Floats) -> Floats:
        """Return the distance of the lips `(F,)`, NaN where one is not seen, of displacements `(F, P, 3)` from rest."""
        between = (moved[:, self.upper] + rest[self.upper]) - (moved[:, self.lower] + rest[self.lower])
        return np.asarray(np.sqrt((between**2).sum(axis=1)))

    def gamma(self, gap: Floats, fps: float, opened: float = 0.0) -> tuple[Floats, float]:
        """Return γ of frames, and what the next frame needs to know.

        Args:
            gap: `(F,)` how far the lips are apart [cm]; γ is 0 where it is NaN.
            fps: frames per second.
            opened: how far the lips were apart lately, of the frame before [inter-ocular distances].

        Returns:
            `(F,)`, and `opened` of the last frame.
        """
        fading = math.exp(-1 / (self.closing * fps)) if self.closing else 0.0
        gamma = np.zeros(len(gap))
        for f, apart in enumerate(gap.tolist()):
            lately = fading * opened
            d = 0.0 if math.isnan(apart) else max(apart - self.closed, 0.0) / INTEROCULAR_CM
            opened = max(d, lately)
            if not math.isnan(apart):
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
        gamma, (before, opened) = np.zeros(len(moved)), memory
        if self.lips is not None:
            gamma, opened = self.lips.gamma(self.lips.gap(moved, self.face.rest), fps, opened)
        smooth = self.smooth * (fps / RATE) ** 2
        data, energy, whole = self._projected(moved)
        parts = []
        for begin, end, seen in _runs(moved, whole):
            if before is None and not seen.any():
                seen = np.ones_like(seen)
            span = slice(begin, end)
            part = solve_layered(self.problem(seen, smooth), data[span], energy[span], gamma[span], before)
            before = part.last
            parts.append(part)
        return _joined(parts), Memory(before, opened)

    def project(self, moved: Floats) -> tuple[Floats, Floats]:
        """Return `c_l = Bᵀ M_l x̂` `(F, m, N)` and `‖x̂‖²` `(F,)`, means over the points; NaN points say nothing."""
        return self._projected(moved)[:2]

    def _projected(self, moved: Floats) -> tuple[Floats, Floats, Flags]:
        """Return what `project` does, and which frames see every point."""
        data = np.empty((len(moved), len(self.face.regions.names), sum(self.face.sizes)))
        energy, whole = np.empty(len(moved)), np.empty(len(moved), bool)
        project_frames(self._layout, np.ascontiguousarray(moved), data, energy, whole)
        return data, energy, whole

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
        if seen.all():
            return self._whole
        few = seen.mean() < 0.5
        part = self._products(seen if few else ~seen)
        return part if few else self._whole - part

    def _products(self, chosen: Flags) -> Floats:
        order, basis = self._layout.order, self._layout.basis[: sum(self.face.sizes)]
        picks = [chosen & (self.face.regions.of == r) for r in range(len(self.face.regions.names))]
        parts = [basis[:, np.repeat(pick[order], 3)] for pick in picks]
        return np.stack([part @ part.T for part in parts])

    @cached_property
    def _whole(self) -> Floats:
        return self._products(np.ones(len(self.face.rest), bool))

    @cached_property
    def _problems(self) -> dict[tuple[bytes, float], LayeredProblem]:
        return {}

    @cached_property
    def _layout(self) -> Layout:
        return lay_out(self.face.basis, self.face.regions.of, self.importance)


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


def _runs(moved: Floats, whole: Flags) -> Iterator[tuple[int, int, Flags]]:
    """Yield runs of frames that see the same points: where they begin and end, and which points.

    Most frames see all, and a look at every point of every frame would take as long as their layers.
    """
    if whole.all():
        yield 0, len(moved), np.ones(moved.shape[1], bool)
        return
    seen = np.ones(moved.shape[:2], bool)
    seen[~whole] = ~np.isnan(moved[~whole, :, 0])
    for begin, end in pairwise([0, *(np.flatnonzero((seen[1:] != seen[:-1]).any(axis=1)) + 1).tolist(), len(moved)]):
        yield begin, end, seen[begin]


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
