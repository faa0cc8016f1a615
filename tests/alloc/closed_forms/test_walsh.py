"""The Walsh matrix, and the closed form that takes it (eq. 18-28, Appendix A)."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from alloc import NotApplicable, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.closed_forms import walsh
from tests.closed_form_cases import answer, assert_same, by_lagrange, vehicle_of


@pytest.mark.parametrize("n", [1, 2, 4, 8, 16, 64])
def test_a_walsh_matrix_is_symmetric_orthogonal_and_in_dyadic_order(n: int) -> None:
    W = walsh.walsh_matrix(n)
    np.testing.assert_array_equal(W, W.T)
    np.testing.assert_array_equal(W @ W, n * np.eye(n))
    # Dyadic order: row i changes sign with the Rademacher functions of the bits of i, lowest bit slowest.
    bits = n.bit_length() - 1
    for i in range(n):
        for x in range(n):
            crossings = sum((i >> b & 1) * (x >> (bits - 1 - b) & 1) for b in range(bits))
            assert W[i, x] == (-1) ** crossings
    natural = scipy.linalg.hadamard(n)
    assert {tuple(row) for row in W} == {tuple(row) for row in natural}


@pytest.mark.parametrize("n", [0, -4, 3, 6, 12])
def test_a_walsh_matrix_whose_size_is_no_power_of_two_is_refused(n: int) -> None:
    with pytest.raises(NotApplicable, match="power of two"):
        walsh.walsh_matrix(n)


@given(
    alpha=st.floats(5, 85),
    arm=st.floats(0.01, 100) | st.floats(-100, -0.01),
    tau=arrays(float, 3, elements=st.floats(-1e3, 1e3)),
    order=st.permutations(range(4)),
    flipped=st.lists(st.booleans(), min_size=4, max_size=4),
    off=st.none() | st.integers(0, 3),
)
def test_walsh_is_the_pseudoinverse_for_four_thrusters_in_any_order_and_sense(
    alpha: float, arm: float, tau: FloatArray, order: list[int], flipped: list[bool], off: int | None
) -> None:
    t = np.array([np.cos(np.radians(alpha)), np.sin(np.radians(alpha)), arm])
    T = t[:, None] * np.array([[1, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1.0]])
    vehicle = vehicle_of(T[:, order] * np.where(flipped, -1, 1))
    if off is not None:
        vehicle = vehicle.with_fault(off)
    f = answer("walsh", vehicle, tau)
    assert_same(f, scipy.linalg.pinv(vehicle.TP) @ tau)


def test_walsh_covers_eight_thrusters_that_are_rows_of_w8(rng: np.random.Generator) -> None:
    Q = np.diag([0.9, 0.4, 0.4, 2.0, 3.0, 0.5])
    vehicle = vehicle_of(Q @ walsh.walsh_matrix(8)[2:])
    for case in (vehicle, vehicle.with_fault(5)):
        tau = case.TP @ rng.uniform(-10, 10, 8)
        assert_same(answer("walsh", case, tau), by_lagrange(case, tau))


@pytest.mark.parametrize(
    ("spoil", "premise"),
    [
        (lambda v: replace(v, H=np.diag([1, 1, 1, 2.0])), "multiple of the identity"),
        (lambda v: v.with_fault(1, 0.5), "thruster 1 is weakened"),
        (lambda v: replace(v, T=v.T * [1, 1, 1, 1.01]), "not \\+-equal"),
        (lambda v: replace(v, T=np.vstack([v.T[:2], np.zeros(4)])), "no thruster moves yaw"),
        (lambda v: replace(v, T=v.T[[0, 1, 0]]), "surge and yaw of T are not orthogonal"),
        (lambda v: vehicle_of(np.array([[1.0, 1, 1], [1, -1, 0]])), "3 thrusters move surge"),
    ],
)
def test_walsh_refuses_and_names_the_premise_that_fails(spoil, premise: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(NotApplicable, match=premise):
        build("walsh", spoil(load_vehicle("ukwial")))


def test_walsh_covers_the_shipped_vehicles_whose_fours_look_like_the_paper_s_and_no_other() -> None:
    for name in ("ukwial", "bluerov2-heavy", "subjugator8"):
        build("walsh", load_vehicle(name))
    for name in ("bluerov2", "nautilus", "supply-vessel"):
        with pytest.raises(NotApplicable):
            build("walsh", load_vehicle(name))
