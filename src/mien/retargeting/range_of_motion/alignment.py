"""Actor-specific blendshapes by manifold alignment (Ribera et al. 2017, eq. 4 and 9-13).

In matrix form, with the unknown `P` of shape `(K, M)` for each coordinate, the matching
and cross-expression terms act on the left index only and the mesh term on the right one
only.  The normal equations are therefore a Sylvester equation `S P + P T = H`, solved by
two small eigendecompositions instead of a sparse system of `MK` unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from mien.core.arrays import Floats


@dataclass(frozen=True, eq=False)
class AlignmentProblem:
    """`E_Align` (eq. 4) as small matrices that a test can inspect.

    Attributes:
        left: `(K, K)` the matrix `S`.
        right: `(M, M)` the matrix `T`.
        load: `(K, M, 3)` the right-hand side `H`.
        guess: `(K, M, 3)` the initial guess `Δg`, kept where nothing else decides.
    """

    left: Floats
    right: Floats
    load: Floats
    guess: Floats


@dataclass(frozen=True)
class Balance:
    """The weights of the terms.

    Attributes:
        mesh: α of eq. 4, on keeping the shape of the initial guess.
        cross: β of eq. 4, on keeping the relations among the blendshapes.
    """

    mesh: float = 0.01
    cross: float = 0.1


def alignment_problem(
    similarity: Floats,
    keys: Floats,
    shapes: Floats,
    guess: Floats,
    between: Floats,
    laplacian: sparse.spmatrix,
    balance: Balance,
) -> AlignmentProblem:
    """Assemble the normal equations of `E_Align`.

    Args:
        similarity: `(K, E)` similarity of each shape to each key expression.
        keys: `(E, M, 3)` displacements of the key expressions.
        shapes: `(K, M, 3)` the character's blendshapes `Δs`.
        guess: `(K, M, 3)` the initial guess `Δg`.
        between: `(K, K)` correlations among the shapes.
        laplacian: `(M, M)` Laplacian of the triangulated markers.
        balance: the weights of the terms.
    """
    markers = shapes.shape[1]
    reach = local_support(shapes)
    matched = reach[:, :, None] * np.einsum("ke,emc->kmc", similarity, keys) / len(keys)
    graph = cross_expression_laplacian(between)
    relation = balance.cross / markers * graph.T @ graph
    bend = np.asarray((balance.mesh / markers * laplacian.T @ laplacian).todense())
    left = np.diag(similarity.sum(axis=1) / len(keys)) + relation
    load = matched + np.einsum("kl,lmc->kmc", relation, shapes) + np.einsum("mn,knc->kmc", bend, guess)
    return AlignmentProblem(left, bend, load, guess)


def local_support(shapes: Floats) -> Floats:
    """Return `u`, `(K, M)` between 0 and 1: where each shape acts (below eq. 9)."""
    size = np.linalg.norm(shapes, axis=2)
    largest = size.max(axis=1, keepdims=True)
    return np.asarray(np.divide(size, largest, out=np.zeros_like(size), where=largest > 0))


def cross_expression_laplacian(between: Floats) -> Floats:
    """Return the signed graph Laplacian `G` of eq. 12, `(K, K)`: row k maps shapes to `𝓛(Δ_k)`."""
    edges = between - np.diag(np.diag(between))
    total = np.abs(edges).sum(axis=1, keepdims=True)
    edges = np.divide(edges, total, out=np.zeros_like(edges), where=total > 0)
    return np.asarray(edges - np.diag(edges.sum(axis=1)))
