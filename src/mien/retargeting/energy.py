"""The retargeting energy as small matrices, and its solution frame by frame.

Ribera et al. 2017, eq. 2, 15 and 16:

    min_w  1/M |Δa - Σ w_k Δp_k|²  +  µ/N |L ΔV w|²  +  ν/K Σ c_k |w_k|

plus, when asked, `s |w - w_before|²` and a penalty on the difference of symmetric
pairs.  `Δp` are the actor's own blendshapes at the markers, so everything a frame needs
is one `K × K` Gram matrix and one `K`-vector: a lasso in a fixed matrix.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from mien.core import InputError, Mesh, Rig
from mien.core.arrays import Floats, Ints
from mien.core.errors import unknown
from mien.geometry.laplacian import cotangent_laplacian
from mien.solve import LassoProblem, solve_lasso, symmetric_penalty


@dataclass(frozen=True)
class SolveSettings:
    """The knobs of the per-frame solve.

    The defaults are those that measure best (docs/accuracy.md); `PAPER` holds the published ones.

    Attributes:
        prior: µ, how strongly bending of the character's surface is avoided.
        sparsity: ν, how strongly small weights are pulled to exactly zero; weakens expressions.
        smooth: resistance to change from frame to frame; a held pose is held at any value.
        bounds: lowest and highest weight, or None for no bounds (the paper's choice).
        shape_sparsity: per-shape factors on ν, by name.
        exclusive: pairs of shapes that are never active together.
        symmetric: pairs of shapes drawn towards equal weights.
        symmetry: how strongly.
    """

    prior: float = 0.0
    sparsity: float = 0.002
    smooth: float = 0.005
    bounds: tuple[float, float] | None = (0.0, 1.0)
    shape_sparsity: Mapping[str, float] = field(default_factory=dict)
    exclusive: Sequence[tuple[str, str]] = ()
    symmetric: Sequence[tuple[str, str]] = ()
    symmetry: float = 0.1

    def __post_init__(self) -> None:
        for name in ("prior", "sparsity", "smooth", "symmetry"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"{name} must be a number of at least 0, but is {value}.")
        if self.bounds is not None and not self.bounds[0] <= 0 <= self.bounds[1]:
            raise InputError(
                f"the bounds must enclose 0 (the neutral), but are {self.bounds[0]:g} … {self.bounds[1]:g}."
            )

    def as_dict(self) -> dict[str, Any]:
        """Return the settings by name, ready for JSON."""
        return asdict(self)


PAPER: Mapping[str, Any] = {"prior": 0.3, "sparsity": 0.6, "smooth": 0.0, "bounds": None}
"""µ and ν as published (Ribera et al. 2017, §5): no bounds, no smoothing."""


@dataclass(frozen=True, eq=False)
class FrameSolver:
    """Everything a frame needs: solve for weights given displacements of the markers.

    Attributes:
        shapes: `(K, M, 3)` the actor's own blendshapes `Δp` [cm].
        confidence: `(M,)` how much each marker counts.
        regular: `(K, K)` prior and symmetry as a quadratic form, as added to the Gram matrix.
        l1: `(K,)` ν/K times each shape's factor.
        exclusive: `(P, 2)` pairs never active together.
        settings: as asked for.
    """

    shapes: Floats
    confidence: Floats
    regular: Floats
    l1: Floats
    exclusive: Ints
    settings: SolveSettings

    def problem(self, seen: np.ndarray) -> tuple[LassoProblem, Floats]:
        """Return the problem for frames that see these markers `(M,)`, and `2/M Δp` for its data vectors."""
        weight = np.where(seen, self.confidence, 0.0)
        scaled = self.shapes * (2 * weight / max(weight.sum(), 1e-12))[:, None]
        k = len(self.shapes)
        gram = scaled.reshape(k, -1) @ self.shapes.reshape(k, -1).T + self.regular
        low, high = self.settings.bounds or (-np.inf, np.inf)
        return LassoProblem(gram, self.l1, np.array(low), np.array(high), self.exclusive), scaled.reshape(k, -1)

    def batch(self, take: Floats) -> tuple[Floats, float]:
        """Solve a take frame after frame, each from the one before.

        Args:
            take: `(F, M, 3)` displacements [cm]; NaN where a marker is missing.

        Returns:
            `(F, K)` weights, and the largest KKT residual. A frame that sees nothing holds
            the one before.
        """
        seen = ~np.isnan(take[..., 0])
        data = np.where(seen[..., None], take, 0.0).reshape(len(take), -1)
        weights = np.zeros((len(take), len(self.shapes)))
        problems: dict[bytes, tuple[LassoProblem, Floats]] = {}
        before: Floats | None = None
        worst = 0.0
        for begin, end in _runs(seen):
            if not seen[begin].any():
                weights[begin:end] = 0.0 if before is None else before
                continue
            key = seen[begin].tobytes()
            if key not in problems:
                problems[key] = self.problem(seen[begin])
            problem, scaled = problems[key]
            solved = solve_lasso(problem, data[begin:end] @ scaled.T, before, smoothness=self.settings.smooth)
            weights[begin:end] = solved.weights
            before = solved.weights[-1]
            worst = max(worst, float(solved.kkt.max()))
        return weights, worst

    def step(self, displacements: Floats, before: Floats | None) -> Floats:
        """Solve one frame `(M, 3)` from the weights before it: what `batch` does, one frame at a time."""
        seen = ~np.isnan(displacements[:, 0])
        if not seen.any():
            return np.zeros(len(self.shapes)) if before is None else before
        problem, scaled = self._whole if seen.all() else self.problem(seen)
        q = np.where(seen[:, None], displacements, 0.0).ravel() @ scaled.T
        return solve_lasso(problem, q, before, smoothness=self.settings.smooth).weights

    @cached_property
    def _whole(self) -> tuple[LassoProblem, Floats]:
        return self.problem(np.ones(self.shapes.shape[1], dtype=bool))


def _runs(seen: np.ndarray) -> list[tuple[int, int]]:
    """Return `[begin, end)` of runs of frames that see the same markers."""
    cuts = np.flatnonzero((seen[1:] != seen[:-1]).any(axis=1)) + 1
    edges = [0, *cuts.tolist(), len(seen)]
    return list(pairwise(edges))


def frame_solver(
    shapes: Floats, names: Sequence[str], bent: Floats, confidence: Floats, settings: SolveSettings
) -> FrameSolver:
    """Assemble the per-frame problem (eq. 16).

    Args:
        shapes: `(K, M, 3)` the actor's own blendshapes [cm].
        names: their `K` names.
        bent: `(K, K)` Gram matrix of the prior, see `bending`.
        confidence: `(M,)` how much each marker counts.
        settings: the knobs.

    Raises:
        InputError: a setting names an unknown shape.
    """
    k = len(names)
    symmetric = pair_indices(names, settings.symmetric)
    regular = 2 * settings.prior * bent + symmetric_penalty(
        k, [(int(a), int(b)) for a, b in symmetric], settings.symmetry
    )
    l1 = np.full(k, settings.sparsity / k)
    for name, factor in settings.shape_sparsity.items():
        if name not in names:
            raise InputError(unknown("blendshape", name, names))
        l1[names.index(name)] *= factor
    return FrameSolver(shapes, confidence, regular, l1, pair_indices(names, settings.exclusive), settings)


def bending(rig: Rig, centimetre: float) -> Floats:
    """Return the `(K, K)` Gram matrix of `L ΔV` over the full mesh, divided by `N` (eq. 15).

    Args:
        rig: the character.
        centimetre: a human centimetre in the character's unit.
    """
    mesh: Mesh = rig.neutral
    laplacian = cotangent_laplacian(mesh.vertices / centimetre, mesh.triangles)
    k, n, _ = rig.blendshapes.deltas.shape
    columns = rig.blendshapes.deltas.transpose(1, 0, 2).reshape(n, k * 3) / centimetre
    bent = np.asarray(laplacian @ columns).reshape(n, k, 3).transpose(0, 2, 1).reshape(n * 3, k)
    return np.asarray(bent.T @ bent / n)


def pair_indices(names: Sequence[str], pairs: Sequence[tuple[str, str]]) -> Ints:
    """Return `(P, 2)` rows of named pairs of shapes.

    Raises:
        InputError: a name is unknown.
    """
    for name in (n for pair in pairs for n in pair):
        if name not in names:
            raise InputError(unknown("blendshape", name, names))
    return np.array([[names.index(a), names.index(b)] for a, b in pairs], dtype=np.int64).reshape(-1, 2)
