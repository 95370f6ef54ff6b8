"""Reading a matrix as symmetric positive semi-definite, as every quadratic energy's is."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mien.core.arrays import Floats, floats
from mien.core.errors import InputError

ROUNDING = 1e-9
"""How far from symmetric, or below zero, relative to the largest entry, still counts as rounding."""


def semidefinite(value: ArrayLike, what: str) -> Floats:
    """Return `value` as a square symmetric positive semi-definite matrix; its symmetric part, exactly.

    Raises:
        InputError: it is not square, not finite, not symmetric, or has a negative eigenvalue.
    """
    matrix = floats(value, (None, None), what)
    if matrix.shape[0] != matrix.shape[1] or not matrix.size:
        raise InputError(f"{what} must be a square matrix, but has shape {matrix.shape}.")
    slack = ROUNDING * np.abs(matrix).max()
    skew = np.abs(matrix - matrix.T)
    if skew.max() > slack:
        i, j = np.unravel_index(int(skew.argmax()), skew.shape)
        raise InputError(
            f"{what} must be symmetric, but ({i}, {j}) is {matrix[i, j]:g} and ({j}, {i}) {matrix[j, i]:g}."
        )
    symmetric = (matrix + matrix.T) / 2
    if not _definite(symmetric, slack * len(matrix)):
        lowest = float(np.linalg.eigvalsh(symmetric)[0])
        if lowest < -slack * len(matrix):
            raise InputError(
                f"{what} must be positive semi-definite, but has the eigenvalue {lowest:g}: "
                "a quadratic energy with it has no minimum. Build it as AᵀA."
            )
    return symmetric


def _definite(matrix: Floats, slack: float) -> bool:
    """Tell whether a symmetric matrix has a Cholesky factor with `slack` on its diagonal: cheaper than eigenvalues."""
    lifted = matrix.copy()
    lifted.flat[:: len(lifted) + 1] += slack
    try:
        np.linalg.cholesky(lifted)
    except np.linalg.LinAlgError:
        return False
    return True
