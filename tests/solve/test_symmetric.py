"""Matrices are read as positive semi-definite by their eigenvalues, whichever way it is found out."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core import InputError
from mien.solve.symmetric import ROUNDING, semidefinite


@pytest.mark.parametrize("rank", [1, 4, 8])
def test_a_gram_matrix_of_any_rank_comes_back_as_its_symmetric_part(rng, rank):
    rows = rng.normal(size=(8, rank))
    gram = rows @ rows.T + 1e-12 * rng.normal(size=(8, 8))
    np.testing.assert_array_equal(semidefinite(gram, "it"), (gram + gram.T) / 2)


@pytest.mark.parametrize(("share", "passes"), [(0.0, True), (0.9, True), (1.1, False), (1e6, False)])
def test_the_lowest_eigenvalue_may_be_below_zero_by_rounding_alone(rng, share, passes):
    basis, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    values = np.array([0.0, 1, 2, 3, 4, 5])
    matrix = (basis * values) @ basis.T
    values[0] = -share * 6 * ROUNDING * np.abs(matrix).max()
    matrix = (basis * values) @ basis.T
    if passes:
        semidefinite(matrix, "it")
    else:
        with pytest.raises(InputError, match="positive semi-definite"):
            semidefinite(matrix, "it")


def test_zero_is_semidefinite():
    assert not semidefinite(np.zeros((3, 3)), "it").any()
