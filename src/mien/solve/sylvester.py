"""The linear system of a range of motion, solved through two small eigenproblems.

Ribera et al. 2017 (section 4.6) assemble a `MK × MK` sparse system and factor it.
Every term of their energy acts on the blendshape index alone or on the marker index
alone, so the same system is the Sylvester equation `S P + P T = H`: in the
eigenvectors of `S` and `T` it is a division, `P̂_ij = Ĥ_ij / (σ_i + τ_j)`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mien.core.arrays import Floats, floats
from mien.solve.symmetric import semidefinite


@dataclass(frozen=True, eq=False)
class SylvesterSolution:
    """The solution, and what it rests on.

    Attributes:
        P: `(K, M, C)` solution.
        residual: ‖S P + P T − H‖ over ‖H‖ + (‖S‖ + ‖T‖) ‖P‖: about 1e-16 for an equation that has a
            solution; larger where `H` asks for something along the null space.
        null_rank: how many of the `K M` directions the equation leaves open; 0 when the
            solution is unique.
    """

    P: Floats
    residual: float
    null_rank: int


def solve_sylvester(S: ArrayLike, T: ArrayLike, H: ArrayLike, null: ArrayLike | None = None) -> SylvesterSolution:
    """Solve `S P + P T = H` for each of the `C` coordinates.

    Args:
        S: `(K, K)` symmetric positive semi-definite, mixing the rows of `P`.
        T: `(M, M)` symmetric positive semi-definite, mixing its columns.
        H: `(K, M, C)` right-hand sides.
        null: `(K, M, C)` values whose part along the null space is kept, where eigenvalues of `S` and `T`
            sum to zero and the equation says nothing; zero if None (the smallest solution).

    Raises:
        InputError: shapes do not match, values are not finite, or a matrix is not positive semi-definite.
    """
    left, right = semidefinite(S, "S"), semidefinite(T, "T")
    shape = (len(left), len(right), None)
    sides = _coordinates_first(floats(H, shape, "H"))
    sigma, u = np.linalg.eigh(left)
    tau, v = np.linalg.eigh(right)
    norm = max(sigma[-1], 0.0) + max(tau[-1], 0.0)
    total = sigma[:, None] + tau
    # Eigenvalues are known to about eps × size × norm: a smaller sum cannot be told from zero.
    is_null = total <= 4 * max(total.shape) * np.finfo(np.float64).eps * norm
    hat = u.T @ sides @ v
    solution = np.where(is_null, 0.0, hat / np.where(is_null, 1.0, total))
    if null is not None:
        kept = floats(null, (*total.shape, sides.shape[0]), "the null-space values")
        solution = np.where(is_null, u.T @ _coordinates_first(kept) @ v, solution)
    P = u @ solution @ v.T
    error = np.linalg.norm(left @ P + P @ right - sides)
    size = np.linalg.norm(sides) + norm * np.linalg.norm(P)
    residual = float(error / size) if error > 0 else 0.0
    return SylvesterSolution(np.moveaxis(P, 0, -1), residual, int(is_null.sum()))


def _coordinates_first(values: Floats) -> Floats:
    return np.ascontiguousarray(np.moveaxis(values, -1, 0))
