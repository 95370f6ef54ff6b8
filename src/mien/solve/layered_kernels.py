"""The compiled inside of the layered problem: alternation that finds the face, Newton steps that finish on it.

The unknowns `z` are the weights `W` (region after region, one per layer) followed by the
coefficients `α` (layer after layer); every region's weights and every layer's coefficients
are shares.  Given `α` the weights of each region are a tiny quadratic problem, solved by
its faces; given `W` the coefficients are one convex quadratic problem, solved by active
sets.  Alternating is monotone but crawls where weights and coefficients trade off, so a
Newton step on all positive unknowns together follows each round, taken only if it lowers
the objective.

All arrays are filled in place.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.solve.simplex_kernels import (
    Work,
    face_step,
    kkt,
    minimise_faces,
    minimise_simplices,
    move,
    room,
    scratch,
    unevenness,
)

FACES = 4
"""Up to so many layers the weights of a region are found by trying all faces."""
NEWTON = 4
"""Newton steps at most after each round of alternation."""
SHIFTS = (1e-6, 1e-4, 1e-2, 1.0)
"""Tried in turn where the joint problem is not convex, relative to the largest curvature."""
CHUNK = 1024
"""Coordinates projected at a time: all extremes at so many stay in the cache while frames pass."""
BLOCK = 16
"""Frames that pass together."""
FINER = 1e-6
"""Newton steps go on to this share of the tolerance: they cost little, and rounding then hardly shows in the shares."""
HALVINGS = 8
"""Times that a Newton step is halved before it is given up."""
ROUNDING = 1e-14
"""Rises of the objective below this share of its parts are rounding."""
ASLEEP = 1e-9
"""A layer with less weight than this everywhere is asleep: its coefficients cannot be told from the data."""

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


@njit(cache=True, nogil=True)
def improve_weights(shape: Shape, pull: Pull, before: Floats, z: Floats, parts: Parts) -> None:
    """Set each region's weights to their best values for these coefficients, after `correlate`."""
    _, products, match, _, g, _, free, work = parts
    fit, gamma, smooth = pull
    bias = shape[2]
    regions, layers = match.shape
    matrix, q, one = np.empty((layers, layers)), np.empty(layers), np.array([0, layers])
    for r in range(regions):
        w = z[r * layers : (r + 1) * layers]
        pulled = gamma if r == bias[0] else 0.0
        for i in range(layers):
            for j in range(layers):
                matrix[i, j] = 2 * fit * products[r, i, j]
            matrix[i, i] += 2 * (smooth + pulled)
            q[i] = 2 * fit * match[r, i] + (2 * pulled if i == bias[1] else 0.0)
            if smooth > 0:
                q[i] += 2 * smooth * before[r * layers + i]
        if layers <= FACES:
            minimise_faces(matrix, q, w, work)
        else:
            minimise_simplices(matrix, q, one, w, g[:layers], free[:layers], work, 1e-12, 50 * layers)


@njit(cache=True, nogil=True)
def improve_coefficients(
    gram: Floats, c: Floats, shape: Shape, pull: Pull, before: Floats, z: Floats, parts: Parts, tolerance: float
) -> None:
    """Set the coefficients to their best values for these weights."""
    _, _, match, _, g, matrix, free, work = parts
    _, layer_starts, bias, target = shape
    fit, gamma, smooth = pull
    regions, layers = match.shape
    size = gram.shape[1]
    first = regions * layers
    block = matrix[first:, first:]
    coefficient_matrix(gram, shape, pull, z, layers, block)
    q = np.zeros(size)
    for j in range(layers):
        for k in range(layer_starts[j], layer_starts[j + 1]):
            for r in range(regions):
                q[k] += 2 * fit * z[r * layers + j] * c[r, k]
            if smooth > 0:
                q[k] += 2 * smooth * before[first + k]
    if bias[0] >= 0:
        begin = layer_starts[bias[1]]
        for k in range(len(target)):
            q[begin + k] += 2 * gamma * target[k]
    minimise_simplices(block, q, layer_starts, z[first:], g[first:], free[first:], work, 0.1 * tolerance, 20 * size)


@njit(cache=True, nogil=True)
def bent_step(matrix: Floats, g: Floats, starts: Ints, z: Floats, free: Flags, work: Work) -> bool:
    """Take Newton's step where the curvature is positive, else that of the least shift tried that makes it so."""
    if face_step(matrix, g, starts, z, free, work, 0.0):
        return True
    for shift in SHIFTS:  # noqa: SIM110 (compiled: a loop, not a generator)
        if face_step(matrix, g, starts, z, free, work, shift):
            return True
    return False


@njit(cache=True, nogil=True)
def newton(
    gram: Floats,
    c: Floats,
    shape: Shape,
    pull: Pull,
    before: Floats,
    z: Floats,
    value: float,
    slack: float,
    tolerance: float,
    parts: Parts,
) -> float:
    """Step towards the minimum over the positive unknowns together, downhill only; return the objective."""
    starts = shape[0]
    g, matrix, free, work = parts[4], parts[5], parts[6], parts[7]
    trial = np.empty_like(z)
    for _ in range(NEWTON):
        gradient(c, shape, pull, before, z, parts)
        for i in range(len(z)):
            free[i] = z[i] > 0
        if unevenness(starts, g, z, free) <= tolerance:
            return value
        hessian(gram, shape, pull, z, parts)
        if not bent_step(matrix, g, starts, z, free, work):
            return value
        t, stop = room(z, work[2])
        lower = False
        for _ in range(HALVINGS):
            trial[:] = z
            move(starts, trial, work[2], t, stop)
            correlate(gram, c, shape, trial, parts)
            reached = objective(shape, pull, before, trial, parts)
            if reached <= value + slack:
                lower = True
                break
            t, stop = 0.5 * t, -1
        if not lower:
            correlate(gram, c, shape, z, parts)
            return value
        z[:] = trial
        value = reached
    return value


@njit(cache=True, nogil=True)
def wake(
    gram: Floats,
    c: Floats,
    shape: Shape,
    pull: Pull,
    before: Floats,
    z: Floats,
    value: float,
    slack: float,
    parts: Parts,
) -> float:
    """Try whether a layer that is asleep would help with other coefficients; return the objective.

    A layer without weight feels no pull on its coefficients, and with wrong coefficients it
    earns no weight: a trap that only a trial leaves.  It is given the coefficients that fit
    one region best by themselves, for each region in turn, and kept if the objective falls.
    """
    layer_starts = shape[1]
    fit, _, smooth = pull
    g, free, work = parts[4], parts[6], parts[7]
    regions, layers = parts[2].shape
    first = regions * layers
    one = np.zeros(2, np.int64)
    for j in range(layers):
        most = 0.0
        for r in range(regions):
            most = max(most, z[r * layers + j])
        begin, end = first + layer_starts[j], first + layer_starts[j + 1]
        n = end - begin
        if most >= ASLEEP or n < 2:
            continue
        a, b = layer_starts[j], layer_starts[j + 1]
        one[1] = n
        for r in range(regions):
            trial = z.copy()
            matrix = 2 * fit * gram[r, a:b, a:b] + 2 * smooth * np.eye(n)
            q = 2 * fit * c[r, a:b] + (2 * smooth * before[begin:end] if smooth > 0 else np.zeros(n))
            minimise_simplices(matrix, q, one, trial[begin:end], g[:n], free[:n], work, 1e-12, 50 * n)
            correlate(gram, c, shape, trial, parts)
            improve_weights(shape, pull, before, trial, parts)
            reached = objective(shape, pull, before, trial, parts)
            if reached < value - 100 * slack:
                z[:] = trial
                value = reached
    correlate(gram, c, shape, z, parts)
    return value


@njit(cache=True, nogil=True)
def note(history: Floats, count: Ints, value: float) -> None:
    """Add a value to the history, while there is room."""
    if count[0] < len(history):
        history[count[0]] = value
        count[0] += 1


@njit(cache=True, nogil=True)
def descend(
    gram: Floats,
    c: Floats,
    energy: float,
    shape: Shape,
    pull: Pull,
    before: Floats,
    z: Floats,
    tolerance: float,
    max_rounds: int,
    parts: Parts,
    history: Floats,
    count: Ints,
) -> tuple[float, float, int]:
    """Improve `z` to a point of the joint problem that no first-order move improves.

    Returns:
        The objective (with its constant), the KKT residual, and the rounds made.
    """
    starts, g = shape[0], parts[4]
    slack = ROUNDING * max(pull[0] * energy, pull[1], 1e-300)
    correlate(gram, c, shape, z, parts)
    value = objective(shape, pull, before, z, parts)
    note(history, count, value)
    left, rounds, woken = np.inf, 0, False
    while True:
        gradient(c, shape, pull, before, z, parts)
        left = kkt(starts, z, g)
        if left <= tolerance:
            if woken:
                break
            woken = True
            reached = wake(gram, c, shape, pull, before, z, value, slack, parts)
            if reached == value:
                gradient(c, shape, pull, before, z, parts)
                break
            value = reached
            note(history, count, value)
        if rounds == max_rounds:
            break
        rounds += 1
        improve_weights(shape, pull, before, z, parts)
        note(history, count, objective(shape, pull, before, z, parts))
        improve_coefficients(gram, c, shape, pull, before, z, parts, tolerance)
        correlate(gram, c, shape, z, parts)
        value = objective(shape, pull, before, z, parts)
        note(history, count, value)
        value = newton(gram, c, shape, pull, before, z, value, slack, FINER * tolerance, parts)
        note(history, count, value)
    return value + pull[0] * energy, left, rounds


@njit(cache=True, nogil=True)
def descend_frames(
    gram: Floats,
    data: Floats,
    energy: Floats,
    gamma: Floats,
    smooth: float,
    shape: Shape,
    z: Floats,
    tolerances: Floats,
    max_rounds: int,
    found: Floats,
    objectives: Floats,
    left: Floats,
    rounds: Ints,
) -> None:
    """Solve frame after frame, each from the one before; `z` holds the frame before the first."""
    layers = len(shape[1]) - 1
    parts = parts_for(gram.shape[0], layers, gram.shape[1])
    history, count = np.empty(0), np.zeros(1, np.int64)
    for f in range(len(data)):
        before = z.copy()
        pull = (1.0 - gamma[f], gamma[f], smooth)
        objectives[f], left[f], rounds[f] = descend(
            gram, data[f], energy[f], shape, pull, before, z, tolerances[f], max_rounds, parts, history, count
        )
        found[f] = z


@njit(cache=True, nogil=True)
def project_frames(
    basis: Floats, borders: Ints, order: Ints, root: Floats, moved: Floats, data: Floats, energy: Floats
) -> None:
    """Set `c_l = Bᵀ M_l x̂` and `‖x̂‖²` of frames, each in the same order of sums however many there are.

    Args:
        basis: `(N, D)` the extremes, points in the order of their regions, times `root`.
        borders: `(m + 1,)` where each region's coordinates begin.
        order: `(P,)` the points in that order.
        root: `(D,)` what each coordinate is multiplied by.
        moved: `(F, P, 3)`; a NaN point is left out.
        data: `(F, m, N)` filled.
        energy: `(F,)` filled.
    """
    data[:] = 0.0
    energy[:] = 0.0
    block = np.empty((min(BLOCK, max(len(moved), 1)), len(root)))
    for first in range(0, len(moved), BLOCK):
        count = min(BLOCK, len(moved) - first)
        for f in range(count):
            for i in range(len(order)):
                point = moved[first + f, order[i]]
                if np.isnan(point[0]):
                    block[f, 3 * i : 3 * i + 3] = 0.0
                else:
                    for a in range(3):
                        block[f, 3 * i + a] = point[a] * root[3 * i + a]
        for r in range(len(borders) - 1):
            for begin in range(borders[r], borders[r + 1], CHUNK):
                end = min(begin + CHUNK, borders[r + 1])
                for f in range(count):
                    x = block[f, begin:end]
                    energy[first + f] += products(basis, begin, end, x, data[first + f, r])


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def products(basis: Floats, begin: int, end: int, x: Floats, out: Floats) -> float:
    """Add the products of all rows, from `begin` to `end`, with `x` to `out`; return that of `x` with itself."""
    size = len(x)
    for k in range(0, len(basis) - 3, 4):
        b0, b1 = basis[k, begin:end], basis[k + 1, begin:end]
        b2, b3 = basis[k + 2, begin:end], basis[k + 3, begin:end]
        s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
        for i in range(size):
            s0 += b0[i] * x[i]
            s1 += b1[i] * x[i]
            s2 += b2[i] * x[i]
            s3 += b3[i] * x[i]
        out[k] += s0
        out[k + 1] += s1
        out[k + 2] += s2
        out[k + 3] += s3
    for k in range(len(basis) - len(basis) % 4, len(basis)):
        row = basis[k, begin:end]
        s = 0.0
        for i in range(size):
            s += row[i] * x[i]
        out[k] += s
    power = 0.0
    for i in range(size):
        power += x[i] * x[i]
    return power
