"""Meshes whose shape is known."""

from __future__ import annotations

import numpy as np


def ball(n: int = 100, radius: float = 0.8) -> tuple[np.ndarray, np.ndarray]:
    """A ball of n × n vertices, open by a pinhole at the poles and doubled along one seam."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n), np.linspace(0.01, np.pi - 0.01, n), indexing="ij")
    points = radius * np.stack([np.sin(v) * np.sin(u), np.cos(v), np.sin(v) * np.cos(u)], axis=-1).reshape(-1, 3)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    return points, np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)])
