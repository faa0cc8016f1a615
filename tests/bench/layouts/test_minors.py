"""Determinants of rows, and what follows from them, against elimination."""

from itertools import combinations

import numpy as np
import pytest

from bench.layouts.spaces import dependencies, inverse, minors, subsets


@pytest.mark.parametrize(("n", "d"), [(1, 1), (4, 1), (8, 2), (9, 3), (7, 5)])
def test_minors_are_the_determinants_of_all_d_rows(n: int, d: int, rng: np.random.Generator) -> None:
    A = rng.normal(size=(n, d, 3))
    by_elimination = [np.linalg.det(A[list(rows)].transpose(2, 0, 1)) for rows in combinations(range(n), d)]
    np.testing.assert_allclose(minors(A), by_elimination, rtol=1e-10, atol=1e-12)


def test_minors_of_a_matrix_and_of_its_null_space_are_in_one_ratio(rng: np.random.Generator) -> None:
    T = rng.normal(size=(6, 8))
    N = np.linalg.svd(T)[2][6:].T
    of_T = [abs(np.linalg.det(np.delete(T, rows, axis=1))) for rows in subsets(8, 2)]
    np.testing.assert_allclose(
        np.sqrt(np.linalg.det(T @ T.T)) * np.abs(minors(N[..., None])[:, 0]), of_T, rtol=1e-10
    )


@pytest.mark.parametrize(("n", "d"), [(5, 0), (4, 1), (8, 2), (6, 3)])
def test_dependencies_combine_rows_to_zero(n: int, d: int, rng: np.random.Generator) -> None:
    A = rng.normal(size=(n, d, 2))
    y = dependencies(minors(A), n, d)
    for rows, coefficients in zip(subsets(n, d + 1), y, strict=True):
        assert np.abs(coefficients).max() > 0
        np.testing.assert_allclose(np.einsum("pb,pdb->db", coefficients, A[rows]), 0.0, atol=1e-12)


@pytest.mark.parametrize("d", [1, 2, 3, 4])
def test_an_inverse_by_cofactors_is_the_inverse_and_a_singular_matrix_has_none(
    d: int, rng: np.random.Generator
) -> None:
    A = rng.normal(size=(d, d, 5))
    A[..., 4] = 0.0
    found = inverse(A, 1e-9)
    for i in range(4):
        np.testing.assert_allclose(found[..., i] @ A[..., i], np.eye(d), atol=1e-9)
    assert (found[..., 4] == 0).all()
