"""The layered objective and its derivatives, compiled.

The unknowns `z` are the weights `W` (region after region, one per layer) followed by the
coefficients `α` (layer after layer); every region's weights and every layer's coefficients
are shares.  Everything is made of `A_l α_j` and its products, which `correlate` sets first.

All arrays are filled in place.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.solve.simplex_kernels import Work, scratch

Shape = tuple[Ints, Ints, Ints, Floats]
"""Blocks of all unknowns, blocks of the coefficients, (region, layer) of the bias (-1: none), and its target coefficients."""

Pull = tuple[float, float, float]
"""How much the fit, the bias and the smoothness count in a frame: 1 − γ, γ and λ."""


class Parts(NamedTuple):
    """Scratch of a frame.

    Attributes:
        outputs: `(m, J, N)` `A_l α_j`.
        products: `(m, J, J)` `α_jᵀ A_l α_j'`.
        match: `(m, J)` `c_lᵀ α_j`.
        residual: `(m, N)` `A_l y_l − c_l`.
        shares: `(m, N)` the weight of each coefficient's layer in each region.
        g: `(n,)` the gradient.
        matrix: `(n, n)` the Hessian.
        block: `(N, N)` the matrix of the half-step of the coefficients.
        small: `(J, J)` the matrix of the half-step of one region's weights.
        q: `(n,)` the linear term of a half-step.
        slope: `(n,)` the gradient of a quadratic.
        goal, trial, second: `(n,)` unknowns that are tried.
        free: `(n,)` which unknowns are positive, or to become so.
        used: `(N,)` which coefficients are not 0, in order.
        pair: `(2,)` borders of a single block, from 0.
        work: scratch of the simplices.
    """

    outputs: Floats
    products: Floats
    match: Floats
    residual: Floats
    shares: Floats
    g: Floats
    matrix: Floats
    block: Floats
    small: Floats
    q: Floats
    slope: Floats
    goal: Floats
    trial: Floats
    second: Floats
    free: Flags
    used: Ints
    pair: Ints
    work: Work


@njit(cache=True, nogil=True)
def parts_for(regions: int, layers: int, size: int) -> Parts:
    """Return the scratch of a problem with this many regions, layers and coefficients."""
    n = regions * layers + size
    return Parts(
        np.empty((regions, layers, size)),
        np.empty((regions, layers, layers)),
        np.empty((regions, layers)),
        np.empty((regions, size)),
        np.empty((regions, size)),
        np.empty(n),
        np.empty((n, n)),
        np.empty((size, size)),
        np.empty((layers, layers)),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        np.empty(n, np.bool_),
        np.empty(size, np.int64),
        np.zeros(2, np.int64),
        scratch(n),
    )


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def correlate(gram: Floats, c: Floats, shape: Shape, z: Floats, parts: Parts) -> None:
    """Set `A_l α_j`, `α_jᵀ A_l α_j'` and `c_lᵀ α_j`: all the objective needs of the data."""
    outputs, products, match, used = parts.outputs, parts.products, parts.match, parts.used
    layer_starts = shape[1]
    regions, layers, size = outputs.shape
    alpha = z[regions * layers :]
    for j in range(layers):
        count = 0
        for k in range(layer_starts[j], layer_starts[j + 1]):
            if alpha[k] != 0:
                used[count] = k
                count += 1
        for r in range(regions):
            for i in range(size):
                outputs[r, j, i] = 0.0
            m = 0.0
            for n in range(0, count - 1, 2):
                k, p = used[n], used[n + 1]
                a, b = alpha[k], alpha[p]
                m += a * c[r, k] + b * c[r, p]
                for i in range(size):
                    outputs[r, j, i] += a * gram[r, k, i] + b * gram[r, p, i]
            if count % 2:
                k = used[count - 1]
                a = alpha[k]
                m += a * c[r, k]
                for i in range(size):
                    outputs[r, j, i] += a * gram[r, k, i]
            match[r, j] = m
            for i in range(j + 1):
                s = 0.0
                for k in range(layer_starts[i], layer_starts[i + 1]):
                    s += alpha[k] * outputs[r, j, k]
                products[r, i, j] = s
                products[r, j, i] = s


@njit(cache=True, nogil=True)
def objective(shape: Shape, pull: Pull, before: Floats, z: Floats, parts: Parts) -> float:
    """Return the objective without the constant `(1 − γ) ‖x̂‖²`, after `correlate`."""
    products, match = parts.products, parts.match
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
    outputs, products, match, residual, g = parts.outputs, parts.products, parts.match, parts.residual, parts.g
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
def spread_shares(shape: Shape, z: Floats, parts: Parts) -> None:
    """Set the weight of each coefficient's layer in each region."""
    layer_starts = shape[1]
    regions, layers, _ = parts.outputs.shape
    for r in range(regions):
        for j in range(layers):
            for k in range(layer_starts[j], layer_starts[j + 1]):
                parts.shares[r, k] = z[r * layers + j]


@njit(cache=True, nogil=True, fastmath={"contract"})
def coefficient_rows(gram: Floats, shape: Shape, pull: Pull, z: Floats, first: int, parts: Parts, out: Floats) -> None:
    """Set the second derivatives with respect to the coefficients, rows and columns of `out` from `first` on."""
    shares = parts.shares
    _, layer_starts, bias, target = shape
    fit, gamma, smooth = pull
    regions, size, _ = gram.shape
    spread_shares(shape, z, parts)
    for k in range(size):
        row = out[first + k, first:]  # indices from 0 on are what lets the loops below become vectors
        scale = 2 * fit * shares[0, k]
        for n in range(size):
            row[n] = scale * shares[0, n] * gram[0, k, n]
        for r in range(1, regions):
            scale = 2 * fit * shares[r, k]
            for n in range(size):
                row[n] += scale * shares[r, n] * gram[r, k, n]
        row[k] += 2 * smooth
        if bias[0] >= 0 and 0 <= k - layer_starts[bias[1]] < len(target):
            row[k] += 2 * gamma


@njit(cache=True, nogil=True, fastmath={"contract"})
def hessian(gram: Floats, shape: Shape, pull: Pull, z: Floats, parts: Parts) -> None:
    """Set the second derivatives of the objective with respect to all unknowns, after `gradient`."""
    outputs, products, residual, shares = parts.outputs, parts.products, parts.residual, parts.shares
    matrix = parts.matrix
    _, layer_starts, bias, _ = shape
    fit, gamma, smooth = pull
    regions, layers, size = outputs.shape
    first = regions * layers
    coefficient_rows(gram, shape, pull, z, first, parts, matrix)
    for r in range(regions):
        for i in range(layers):
            a = r * layers + i
            for b in range(first):
                matrix[a, b] = 0.0
            for j in range(layers):
                matrix[a, r * layers + j] = 2 * fit * products[r, i, j]
            matrix[a, a] += 2 * smooth + (2 * gamma if r == bias[0] else 0.0)
            row = matrix[a, first:]
            for k in range(size):
                row[k] = 2 * fit * shares[r, k] * outputs[r, i, k]
            for k in range(layer_starts[i], layer_starts[i + 1]):
                row[k] += 2 * fit * residual[r, k]
            for k in range(size):
                matrix[first + k, a] = row[k]
