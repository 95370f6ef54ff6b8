"""A truth, ready for many results to be measured against it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.core import Rig
from mien.core.arrays import Floats
from mien.evaluate.gaps import Gaps, gap_figures, gaps
from mien.evaluate.metrics import (
    WeightFigures,
    jerk_ratio,
    moving_shapes,
    moving_surface,
    other_side,
    vertex_error,
    weight_figures,
)
from mien.vocabularies import shape_key

Figures = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Yardstick:
    """True weights of a character, and what they make of its surface.

    Attributes:
        names: `K` shapes.
        weights: `(F, K)` the truth.
        counted: `(K,)` shapes that count in the figures about weights.
        rig: the character, or None if only weights are compared.
        unit: length of a millimetre on it, were its head 23 cm tall.
        surface: its moving vertices, see `moving_surface`.
        gaps: of its lids and lips; None without landmarks.
        stride: the surface is measured every so many frames.
    """

    names: tuple[str, ...]
    weights: Floats
    counted: np.ndarray
    rig: Rig | None = None
    unit: float = 1.0
    surface: NDArray[np.float32] | None = None
    gaps: Gaps | None = None
    stride: int = 1

    def measure(self, result: Floats) -> Figures:
        """Return the figures of a result `(F, K)` by name: what `mien evaluate` prints.

        Raises:
            InputError: the result is not of the truth's size.
        """
        weights = weight_figures(result, self.weights, self.counted)
        moving = weights.moving
        figures: Figures = {
            "rmse": weights.rmse,
            "correlation": weights.correlation,
            "correlation_each": weights.correlation_each,
            "gain": weights.gain,
            "jerk": jerk_ratio(result[:, moving], self.weights[:, moving]) if moving.any() else float("nan"),
            "other_side": other_side(result, self.weights, sides(self.names)),
        }
        if self.rig is not None and self.surface is not None:
            surface = vertex_error(self.surface, result[:: self.stride], self.weights[:: self.stride])
            figures |= {"vertex_mm": surface.mean_mm, "vertex_p95_mm": surface.p95_mm}
        if self.rig is not None and self.gaps is not None:
            measured = gaps(self.rig, result, self.unit)
            assert measured is not None
            figures |= asdict(gap_figures(measured, self.gaps))
        return figures | {"per_shape": per_shape(self.names, weights)}

    @property
    def moving(self) -> np.ndarray:
        """`(K,)` the shapes that the figures about weights are over."""
        return np.asarray(moving_shapes(self.weights) & self.counted)


def yardstick(rig: Rig, weights: Floats, counted: np.ndarray, unit: float, stride: int = 1) -> Yardstick:
    """Prepare a truth on a character.

    Args:
        rig: the character.
        weights: `(F, K)` its true weights.
        counted: `(K,)` shapes that count in the figures about weights.
        unit: length of a millimetre on it, see `metrics.millimetre`.
        stride: measure the surface every so many frames.
    """
    surface = moving_surface(rig, weights[::stride], unit)
    return Yardstick(rig.blendshapes.names, weights, counted, rig, unit, surface, gaps(rig, weights, unit), stride)


def sides(names: Sequence[str]) -> list[tuple[int, int]]:
    """Return the columns of the left and right version of each shape that has both."""
    place = {shape_key(name): i for i, name in enumerate(names)}
    pairs = [(i, place.get(key._replace(side="R"))) for key, i in place.items() if key.side == "L"]
    return [(left, right) for left, right in pairs if right is not None]


def per_shape(names: Sequence[str], weights: WeightFigures) -> Figures:
    """Return RMSE, correlation and gain of each moving shape by name."""
    columns = (weights.per_shape_rmse, weights.per_shape_correlation, weights.per_shape_gain)
    return {
        name: {"rmse": float(r), "correlation": float(c), "gain": float(g)}
        for name, moving, r, c, g in zip(names, weights.moving, *columns, strict=True)
        if moving
    }
