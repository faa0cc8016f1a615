"""The paper's own numbers, to the digits that it prints, and its misprints (docs/theory.md)."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.closed_forms import svd, walsh

TAU = np.array([300.0, -50.0, 10.0])
PRINTED_F = (67.5, 104.0, -119.1, -52.4)
PRINTED_T = np.array(
    [[0.875, 0.875, -0.875, -0.875], [0.485, -0.485, 0.485, -0.485], [0.332, -0.332, -0.332, 0.332]]
)
PRINTED_U = np.diag([1.0, -1.0, 1.0])
PRINTED_V = 0.5 * np.array([[1, -1, 1, -1], [1, 1, -1, -1], [-1, -1, -1, -1], [-1, 1, 1, -1]])
PRINTED_S = np.diag([1.749, 0.967, 0.664])
PRINTED_W8 = np.array(
    [
        [1, 1, 1, 1, 1, 1, 1, 1],
        [1, 1, 1, 1, -1, -1, -1, -1],
        [1, 1, -1, -1, 1, 1, -1, -1],
        [1, 1, -1, -1, -1, -1, 1, 1],
        [1, -1, 1, -1, 1, -1, 1, -1],
        [1, -1, 1, -1, -1, 1, -1, 1],
        [1, -1, -1, 1, 1, -1, -1, 1],
        [1, -1, -1, 1, 1, -1, -1, 1],
    ]
)
CLOSED = pytest.mark.parametrize("method", ["pinv", "svd", "walsh"])


@pytest.fixture
def ukwial() -> Vehicle:
    return load_vehicle("ukwial")


@pytest.fixture
def ukwial_printed(ukwial: Vehicle) -> Vehicle:
    return replace(ukwial, T=PRINTED_T)


def f_of(method: str, vehicle: Vehicle) -> FloatArray:
    return build(method, vehicle)(TAU).f


@CLOSED
def test_the_example_follows_from_the_unrounded_matrix(method: str, ukwial: Vehicle) -> None:
    """Sections 4.1.3 and 4.2.3: alpha = 29 degrees gives every digit that is printed."""
    f = f_of(method, ukwial)
    assert tuple(f.round(1)) == PRINTED_F
    assert tuple(f.round(3)) == (67.498, 104.005, -119.065, -52.438)


@CLOSED
def test_the_printed_matrix_misses_the_third_component(method: str, ukwial_printed: Vehicle) -> None:
    f = f_of(method, ukwial_printed)
    assert tuple(f.round(3)) == (67.471, 103.957, -119.018, -52.411)
    assert tuple(f.round(1)) == (67.5, 104.0, -119.0, -52.4) != PRINTED_F


@CLOSED
def test_each_thruster_off_still_meets_the_example_s_wrench(method: str, ukwial: Vehicle) -> None:
    """Sections 4.1.2 and 4.2.2 by hand: without thruster k, d = 0 and T' is square."""
    for k in range(4):
        rest = [i for i in range(4) if i != k]
        f = f_of(method, ukwial.with_fault(k))
        assert f[k] == 0
        np.testing.assert_allclose(f[rest], np.linalg.solve(ukwial.T[:, rest], TAU), rtol=1e-12)


def test_the_printed_factors_give_the_printed_f() -> None:
    """U, S and V of section 4.1.3 multiply back to T, but for sigma_2."""
    product = PRINTED_U @ np.hstack([PRINTED_S, np.zeros((3, 1))]) @ PRINTED_V.T
    np.testing.assert_allclose(product, PRINTED_T, atol=2e-3)


def test_the_printed_sigma_2_does_not_belong_to_the_printed_matrix(ukwial: Vehicle) -> None:
    of_printed = np.linalg.svd(PRINTED_T, compute_uv=False)
    assert of_printed[1].round(3) == 0.970  # 2 x 0.485, where 0.967 is printed
    assert abs(of_printed[1] - PRINTED_S[1, 1]) > 2e-3
    # The unrounded matrix does not give it either; it does give the other two.
    assert tuple(np.linalg.svd(ukwial.T, compute_uv=False).round(3)) == (1.749, 0.970, 0.664)


def test_the_decomposition_is_not_unique_but_f_is(ukwial: Vehicle) -> None:
    U, S, V, _, rows = svd.decompose(ukwial)
    flipped_U, flipped_V = -U, -V
    S_star = np.linalg.pinv(S)
    np.testing.assert_allclose(
        flipped_V @ S_star @ flipped_U.T * rows, V @ S_star @ U.T * rows, rtol=0, atol=1e-15
    )


def test_equation_15_as_printed_inverts_a_singular_matrix() -> None:
    """More thrusters than degrees of freedom remain: (S V_f*)'(S V_f*) is (n - 1, n - 1) of rank k."""
    vehicle = load_vehicle("supply-vessel")
    U, S, V, L, rows = svd.decompose(vehicle)
    A = S @ np.delete(V.T @ L.T, 2, axis=1)  # the third thruster is off
    assert A.shape == (3, 5)
    assert np.linalg.matrix_rank(A.T @ A) == 3
    right_inverse = A.T @ np.linalg.inv(A @ A.T)
    tau = np.array([1e5, 2e4, 3e5])
    expected = np.insert(right_inverse @ U.T @ (rows * tau), 2, 0.0)  # eq. 16
    np.testing.assert_allclose(build("svd", vehicle.with_fault(2))(tau).f, expected, rtol=1e-12)


def test_for_one_thruster_more_than_dof_the_left_and_right_inverse_are_the_inverse(ukwial: Vehicle) -> None:
    """Eq. 17: with n = 4 the matrix S V_f* is square."""
    U, S, V, L, rows = svd.decompose(ukwial)
    A = S @ np.delete(V.T @ L.T, 1, axis=1)
    left = np.linalg.inv(A.T @ A) @ A.T
    right = A.T @ np.linalg.inv(A @ A.T)
    np.testing.assert_allclose(left, np.linalg.inv(A), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(right, np.linalg.inv(A), rtol=1e-10, atol=1e-12)
    f = build("svd", ukwial.with_fault(1))(TAU).f
    np.testing.assert_allclose(np.delete(f, 1), np.linalg.inv(A) @ U.T @ (rows * TAU), rtol=1e-10)


def test_equation_19_has_the_first_column_of_t_on_the_diagonal_of_q(ukwial: Vehicle) -> None:
    """Eq. 22 prints t_22 and t_33; with those, sway and yaw would come out with the wrong sign."""
    q, W_f = walsh.factor(ukwial)
    np.testing.assert_array_equal(q, ukwial.T[:, 0])
    np.testing.assert_array_equal(W_f, walsh.walsh_matrix(4)[1:])
    as_printed = np.array([ukwial.T[0, 0], ukwial.T[1, 1], ukwial.T[2, 2]])
    f = walsh.walsh_matrix(4) @ np.concatenate([[0], TAU / as_printed]) / 4
    np.testing.assert_allclose(ukwial.T @ f, TAU * [1, -1, -1], rtol=1e-12)


def test_equation_25_as_printed_is_what_walsh_returns(ukwial: Vehicle) -> None:
    """f = 1/4 W [0; Q^-1 tau], by hand."""
    f = walsh.walsh_matrix(4) @ np.concatenate([[0], TAU / ukwial.T[:, 0]]) / 4
    np.testing.assert_allclose(f_of("walsh", ukwial), f, rtol=1e-14)


def test_the_printed_w8_repeats_its_seventh_row_in_place_of_the_eighth() -> None:
    W = walsh.walsh_matrix(8)
    np.testing.assert_array_equal(PRINTED_W8[:7], W[:7])
    np.testing.assert_array_equal(PRINTED_W8[6], PRINTED_W8[7])
    assert not np.array_equal(PRINTED_W8 @ PRINTED_W8.T, 8 * np.eye(8))
    np.testing.assert_array_equal(W[7], [1, -1, -1, 1, -1, 1, 1, -1])


def test_w2_and_w4_are_as_printed() -> None:
    np.testing.assert_array_equal(walsh.walsh_matrix(2), [[1, 1], [1, -1]])
    np.testing.assert_array_equal(
        walsh.walsh_matrix(4), [[1, 1, 1, 1], [1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]
    )
