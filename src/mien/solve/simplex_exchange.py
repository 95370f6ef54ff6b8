"""Convex quadratics on simplices by exchanging many variables at a time, compiled.

An active-set method lets one variable in or out per step.  Where a performance turns, ten of forty
shares change sides within a frame, and exchanging all that are on the wrong side at once finds the
same minimum in a few steps (block principal pivoting: Júdice and Pires 1994).  Nothing promises
that it ends, so it gives up where the number of wrong ones no longer falls.
"""

from __future__ import annotations

from numba import njit

from mien.core.arrays import Flags, Floats, Ints
from mien.solve.simplex_kernels import Work, close_blocks, face_step, largest

PATIENCE = 3
"""Steps in a row that may leave no fewer variables on the wrong side than before."""


@njit(cache=True, nogil=True)
def minimise_exchanging(
    matrix: Floats, g: Floats, starts: Ints, x: Floats, free: Flags, work: Work, tolerance: float
) -> bool:
    """Move `x` to the minimum of a quadratic over the simplices; return whether it was found.

    Args:
        matrix: the second derivatives.
        g: the gradient at `x`; destroyed.
        starts: where each simplex begins.
        x: shares, in place; near the optimum few steps are needed.  Not shares if nothing was found.
        free, work: scratch.
        tolerance: by how much the gradient of a share at 0 has to be below its simplex's for it to enter.
    """
    for i in range(len(x)):
        free[i] = x[i] > 0
    least, patience = len(x) + 1, PATIENCE
    while patience > 0 and face_step(matrix, g, starts, x, free, work, 0.0):
        follow(matrix, work[2], x, g)
        wrong = exchange(matrix, starts, x, g, free, tolerance)
        if wrong == 0:
            close_blocks(starts, x)
            return True
        if wrong < least:
            least, patience = wrong, PATIENCE
        else:
            patience -= 1
    return False


@njit(cache=True, nogil=True, fastmath={"contract"})
def follow(matrix: Floats, step: Floats, x: Floats, g: Floats) -> None:
    """Make a step and keep the gradient up."""
    for i in range(len(x)):
        if step[i] != 0:
            x[i] += step[i]
            for k in range(len(x)):
                g[k] += step[i] * matrix[i, k]


@njit(cache=True, nogil=True)
def exchange(matrix: Floats, starts: Ints, x: Floats, g: Floats, free: Flags, tolerance: float) -> int:
    """Put every variable on its side, and keep the gradient up; return how many were not.

    One at 0 whose gradient is below its block's becomes free; a negative one goes to 0, and the
    largest of its block at that moment takes the difference.
    """
    wrong = 0
    for b in range(len(starts) - 1):
        level = g[largest(starts, x, b)] - tolerance
        for i in range(starts[b], starts[b + 1]):
            if not free[i] and g[i] < level:
                free[i] = True
                wrong += 1
    for b in range(len(starts) - 1):
        for i in range(starts[b], starts[b + 1]):
            if x[i] < 0:
                p = largest(starts, x, b)
                for k in range(len(x)):
                    g[k] += x[i] * (matrix[p, k] - matrix[i, k])
                x[p] += x[i]
                x[i] = 0.0
                free[i] = False
                wrong += 1
    return wrong
