"""The layered objective and its derivatives, compiled.

The unknowns `z` are the weights `W` (region after region, one per layer) followed by the
coefficients `α` (layer after layer); every region's weights and every layer's coefficients
are shares.  Everything is made of `A_l α_j` and its products, which `correlate` sets first.

All arrays are filled in place.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.solve.simplex_kernels import Work, scratch

Shape = tuple[Ints, Ints, Ints, Floats]
"""Blocks of all unknowns, blocks of the coefficients, (region, layer) of the bias (-1: none), and its target coefficients."""

Pull = tuple[float, float, float]
"""How much the fit, the bias and the smoothness count in a frame: 1 − γ, γ and λ."""

Parts = tuple[Floats, Floats, Floats, Floats, Floats, Floats, Flags, Work]
"""Scratch: `A_l α_j`, their products, `cᵀα`, residuals, gradient, Hessian, free unknowns, and that of the simplices."""


@njit(cache=True, nogil=True)
def parts_for(regions: int, layers: int, size: int) -> Parts:
    """Return the scratch of a problem with this many regions, layers and coefficients."""
    n = regions * layers + size
    return (
        np.empty((regions, layers, size)),
        np.empty((regions, layers, layers)),
        np.empty((regions, layers)),
        np.empty((regions, size)),
        np.empty(n),
        np.empty((n, n)),
        np.empty(n, np.bool_),
        scratch(n),
    )


@njit(cache=True, nogil=True)
def correlate(gram: Floats, c: Floats, shape: Shape, z: Floats, parts: Parts) -> None:
    """Set `A_l α_j`, `α_jᵀ A_l α_j'` and `c_lᵀ α_j`: all the objective needs of the data."""
    outputs, products, match = parts[0], parts[1], parts[2]
    layer_starts = shape[1]
    regions, layers, size = outputs.shape
    alpha = z[regions * layers :]
    for r in range(regions):
        for j in range(layers):
            out = outputs[r, j]
            out[:] = 0.0
            m = 0.0
            for k in range(layer_starts[j], layer_starts[j + 1]):
                a = alpha[k]
                if a != 0:
                    m += a * c[r, k]
                    row = gram[r, k]
                    for i in range(size):
                        out[i] += a * row[i]
            match[r, j] = m
        for i in range(layers):
            for j in range(layers):
                s = 0.0
                for k in range(layer_starts[i], layer_starts[i + 1]):
                    s += alpha[k] * outputs[r, j, k]
                products[r, i, j] = s


@njit(cache=True, nogil=True)
def objective(shape: Shape, pull: Pull, before: Floats, z: Floats, parts: Parts) -> float:
    """Return the objective without the constant `(1 − γ) ‖x̂‖²`, after `correlate`."""
    _, products, match, _, _, _, _, _ = parts
    _, layer_starts, bias, target = shape
    fit, gamma, smooth = pull
    regions, layers = match.shape
    total = 0.0
    for r in range(regions):
        w = z[r * layers : (r + 1) * layers]
        for i in range(layers):
            total -= 2 * fit * w[i] * match[r, i]
            for j in range(layers):
                total += fit * w[i] * w[j] * products[r, i, j]
    if bias[0] >= 0:
        for j in range(layers):
            total += gamma * (z[bias[0] * layers + j] - (1.0 if j == bias[1] else 0.0)) ** 2
        begin = layer_starts[bias[1]]
        for k in range(len(target)):
            total += gamma * (z[regions * layers + begin + k] - target[k]) ** 2
    if smooth > 0:
        for i in range(len(z)):
            total += smooth * (z[i] - before[i]) ** 2
    return total


@njit(cache=True, nogil=True)
def gradient(c: Floats, shape: Shape, pull: Pull, before: Floats, z: Floats, parts: Parts) -> None:
    """Set the gradient and the residuals `A_l y_l − c_l`, after `correlate`."""
    outputs, products, match, residual, g, _, _, _ = parts
    _, layer_starts, bias, target = shape
    fit, gamma, smooth = pull
    regions, layers, size = outputs.shape
    first = regions * layers
    for i in range(len(z)):
        g[i] = 2 * smooth * (z[i] - before[i]) if smooth > 0 else 0.0
    for r in range(regions):
        w = z[r * layers : (r + 1) * layers]
        left = residual[r]
        for k in range(size):
            left[k] = -c[r, k]
        for j in range(layers):
            s = -match[r, j]
            for i in range(layers):
                s += products[r, j, i] * w[i]
            g[r * layers + j] += 2 * fit * s
            if w[j] != 0:
                for k in range(size):
                    left[k] += w[j] * outputs[r, j, k]
        for j in range(layers):
            for k in range(layer_starts[j], layer_starts[j + 1]):
                g[first + k] += 2 * fit * w[j] * left[k]
    if bias[0] >= 0:
        for j in range(layers):
            g[bias[0] * layers + j] += 2 * gamma * (z[bias[0] * layers + j] - (1.0 if j == bias[1] else 0.0))
        begin = first + layer_starts[bias[1]]
        for k in range(len(target)):
            g[begin + k] += 2 * gamma * (z[begin + k] - target[k])


@njit(cache=True, nogil=True)
def coefficient_matrix(gram: Floats, shape: Shape, pull: Pull, z: Floats, layers: int, out: Floats) -> None:
    """Set the second derivatives of the objective with respect to the coefficients."""
    _, layer_starts, bias, target = shape
    fit, gamma, smooth = pull
    regions, size, _ = gram.shape
    out[:size, :size] = 0.0
    for r in range(regions):
        for i in range(layers):
            for j in range(layers):
                share = 2 * fit * z[r * layers + i] * z[r * layers + j]
                if share != 0:
                    for k in range(layer_starts[i], layer_starts[i + 1]):
                        for n in range(layer_starts[j], layer_starts[j + 1]):
                            out[k, n] += share * gram[r, k, n]
    for k in range(size):
        out[k, k] += 2 * smooth
    if bias[0] >= 0:
        for k in range(layer_starts[bias[1]], layer_starts[bias[1]] + len(target)):
            out[k, k] += 2 * gamma


@njit(cache=True, nogil=True)
def hessian(gram: Floats, shape: Shape, pull: Pull, z: Floats, parts: Parts) -> None:
    """Set the second derivatives of the objective with respect to all unknowns, after `gradient`."""
    outputs, products, _, residual, _, matrix, _, _ = parts
    _, layer_starts, bias, _ = shape
    fit, gamma, smooth = pull
    regions, layers, _ = outputs.shape
    first = regions * layers
    matrix[:first] = 0.0
    coefficient_matrix(gram, shape, pull, z, layers, matrix[first:, first:])
    for r in range(regions):
        for i in range(layers):
            a = r * layers + i
            for j in range(layers):
                matrix[a, r * layers + j] = 2 * fit * products[r, i, j]
            matrix[a, a] += 2 * smooth + (2 * gamma if r == bias[0] else 0.0)
            for j in range(layers):
                share = 2 * fit * z[r * layers + j]
                for k in range(layer_starts[j], layer_starts[j + 1]):
                    value = share * outputs[r, i, k]
                    if i == j:
                        value += 2 * fit * residual[r, k]
                    matrix[a, first + k] = value
                    matrix[first + k, a] = value
