"""Numerics that know nothing of faces: small dense problems solved exactly, each with its residual."""

from mien.solve.driven import solve_driven
from mien.solve.lasso import LassoProblem, LassoSolution, solve_lasso, symmetric_penalty
from mien.solve.sylvester import SylvesterSolution, solve_sylvester

__all__ = [
    "LassoProblem",
    "LassoSolution",
    "SylvesterSolution",
    "solve_driven",
    "solve_lasso",
    "solve_sylvester",
    "symmetric_penalty",
]
