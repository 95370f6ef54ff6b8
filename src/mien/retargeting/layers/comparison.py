"""Layers against each layer alone (Kholgade, Matthews, Sheikh 2011, figure 8)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mien.core import Labels
from mien.core.arrays import Floats
from mien.retargeting.layers.decompose import RATE, Decomposer, residual_mm


@dataclass(frozen=True, eq=False)
class Comparison:
    """How well a take is reconstructed.

    Attributes:
        layered: `(F,)` root-mean-square error of the layered model [mm of a human face].
        alone: the same for each layer by itself over the whole face, by name.
    """

    layered: Floats
    alone: dict[str, Floats]

    def figures(self) -> dict[str, Any]:
        """Return means, the share of frames in which the layered model is at least as good, and mean ratios."""
        table: dict[str, Any] = {"layered_mm": round(float(np.nanmean(self.layered)), 4)}
        for name, error in self.alone.items():
            table[name] = {
                "mean_mm": round(float(np.nanmean(error)), 4),
                "frames_layered_below": round(float((self.layered <= error + 1e-9).mean()), 4),
                "mean_ratio": round(float(np.nanmean(self.layered) / np.nanmean(error)), 4),
            }
        below = np.all([self.layered <= error + 1e-9 for error in self.alone.values()], axis=0)
        table["frames_layered_below_all"] = round(float(below.mean()), 4)
        return table


def compare_layers(decomposer: Decomposer, moved: Floats, fps: float = RATE) -> Comparison:
    """Reconstruct a take by all layers, and by each layer alone.

    A layer alone is the best mixture of its extremes in every frame, without smoothness or bias:
    the hardest peer it can be.

    Args:
        decomposer: the actor in layers.
        moved: `(F, P, 3)` displacements [cm]; NaN where not seen.
        fps: frames per second.
    """
    face = decomposer.face
    layered = residual_mm(face, decomposer.decompose(moved, fps), moved)
    alone = {}
    for layer in face.layers:
        whole = Labels(("face",), np.zeros(len(face.rest), np.int64))
        single = replace(face, layers=(layer,), regions=whole)
        found = Decomposer(single, decomposer.importance, 0.0).decompose(moved, fps)
        alone[layer.name] = residual_mm(single, found, moved)
    return Comparison(layered, alone)
