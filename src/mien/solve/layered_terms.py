"""The layered objective and its derivatives, compiled.

The `n` unknowns `z` are the weights `W` (region after region, one per layer) followed by the
coefficients `α` (layer after layer); every region's weights and every layer's coefficients
are shares.  Everything is made of `A_l α_j` and its products, which `correlate` sets first.

All arrays are filled in place.
"""

from __future__ import annotations

from numba import njit

from mien.core.arrays import Floats, Ints
from mien.solve.layered_frame import Frame, Parts


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def correlate(frame: Frame, z: Floats, parts: Parts) -> None:
    """Set `A_l α_j`, `α_jᵀ A_l α_j'` and `c_lᵀ α_j`: all the objective needs of the data."""
    gram, starts, c = frame.problem.gram, frame.problem.starts, frame.c
    outputs, products, match, used = parts.outputs, parts.products, parts.match, parts.used
    regions, layers, size = outputs.shape
    alpha = z[regions * layers :]
    for j in range(layers):
        count = 0
        for k in range(starts[j], starts[j + 1]):
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
                for k in range(starts[i], starts[i + 1]):
                    s += alpha[k] * outputs[r, j, k]
                products[r, i, j] = s
                products[r, j, i] = s


@njit(cache=True, nogil=True)
def objective(frame: Frame, z: Floats, parts: Parts) -> float:
    """Return the objective without the constant `(1 − γ) ‖x̂‖²`, after `correlate`."""
    problem, gamma, smooth, before = frame.problem, frame.gamma, frame.smooth, frame.before
    products, match, target = parts.products, parts.match, problem.target
    fit = 1.0 - gamma
    regions, layers = match.shape
    total = 0.0
    for r in range(regions):
        w = z[r * layers : (r + 1) * layers]
        for i in range(layers):
            total -= 2 * fit * w[i] * match[r, i]
            for j in range(layers):
                total += fit * w[i] * w[j] * products[r, i, j]
    if problem.region >= 0:
        for j in range(layers):
            total += gamma * (z[problem.region * layers + j] - (1.0 if j == problem.layer else 0.0)) ** 2
        begin = regions * layers + problem.starts[problem.layer]
        for k in range(len(target)):
            total += gamma * (z[begin + k] - target[k]) ** 2
    if smooth > 0:
        for i in range(len(z)):
            total += smooth * (z[i] - before[i]) ** 2
    return total


@njit(cache=True, nogil=True)
def gradient(frame: Frame, z: Floats, parts: Parts) -> None:
    """Set the gradient and the residuals `A_l y_l − c_l`, after `correlate`."""
    problem, c, gamma, smooth, before = frame.problem, frame.c, frame.gamma, frame.smooth, frame.before
    outputs, products, match, residual, g = parts.outputs, parts.products, parts.match, parts.residual, parts.g
    starts, target, fit = problem.starts, problem.target, 1.0 - gamma
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
            for k in range(starts[j], starts[j + 1]):
                g[first + k] += 2 * fit * w[j] * left[k]
    if problem.region >= 0:
        for j in range(layers):
            i = problem.region * layers + j
            g[i] += 2 * gamma * (z[i] - (1.0 if j == problem.layer else 0.0))
        begin = first + starts[problem.layer]
        for k in range(len(target)):
            g[begin + k] += 2 * gamma * (z[begin + k] - target[k])


@njit(cache=True, nogil=True)
def spread_shares(starts: Ints, z: Floats, parts: Parts) -> None:
    """Set the weight of each coefficient's layer in each region."""
    regions, layers, _ = parts.outputs.shape
    for r in range(regions):
        for j in range(layers):
            for k in range(starts[j], starts[j + 1]):
                parts.shares[r, k] = z[r * layers + j]


@njit(cache=True, nogil=True, fastmath={"contract"})
def coefficient_rows(frame: Frame, z: Floats, parts: Parts, out: Floats) -> None:
    """Set the second derivatives with respect to the coefficients: the last rows and columns of `out`."""
    problem, shares, fit = frame.problem, parts.shares, 1.0 - frame.gamma
    gram = problem.gram
    regions, size, _ = gram.shape
    first = len(out) - size
    spread_shares(problem.starts, z, parts)
    for k in range(size):
        row = out[first + k, first:]  # indices from 0 on are what lets the loops below become vectors
        scale = 2 * fit * shares[0, k]
        for n in range(size):
            row[n] = scale * shares[0, n] * gram[0, k, n]
        for r in range(1, regions):
            scale = 2 * fit * shares[r, k]
            for n in range(size):
                row[n] += scale * shares[r, n] * gram[r, k, n]
        row[k] += 2 * frame.smooth
        if problem.region >= 0 and 0 <= k - problem.starts[problem.layer] < len(problem.target):
            row[k] += 2 * frame.gamma


@njit(cache=True, nogil=True, fastmath={"contract"})
def hessian(frame: Frame, z: Floats, parts: Parts) -> None:
    """Set the second derivatives of the objective with respect to all unknowns, after `gradient`."""
    outputs, products, residual, shares = parts.outputs, parts.products, parts.residual, parts.shares
    matrix, starts, fit = parts.matrix, frame.problem.starts, 1.0 - frame.gamma
    regions, layers, size = outputs.shape
    first = regions * layers
    coefficient_rows(frame, z, parts, matrix)
    for r in range(regions):
        for i in range(layers):
            a = r * layers + i
            for b in range(first):
                matrix[a, b] = 0.0
            for j in range(layers):
                matrix[a, r * layers + j] = 2 * fit * products[r, i, j]
            matrix[a, a] += 2 * frame.smooth + (2 * frame.gamma if r == frame.problem.region else 0.0)
            row = matrix[a, first:]
            for k in range(size):
                row[k] = 2 * fit * shares[r, k] * outputs[r, i, k]
            for k in range(starts[i], starts[i + 1]):
                row[k] += 2 * fit * residual[r, k]
            for k in range(size):
                matrix[first + k, a] = row[k]
