"""Each number of a loss against a case worked out by hand."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.closed_forms.inverse import generalized_inverse
from bench.judging.loss import (
    delivered,
    direction_error_deg,
    effort_over_optimum,
    gets_nothing,
    loss,
    relative_wrench_error,
)

CROSS = Vehicle(
    name="cross",
    dof=("surge", "sway"),
    T=np.eye(2),
    H=np.diag([1.0, 4.0]),
    f_min=np.array([-10.0, -10.0]),
    f_max=np.array([10.0, 10.0]),
    readiness=np.ones(2),
    slack_weights=np.ones(2),
)
"""A vehicle with one thruster along each axis, so that wrench and thrusts are the same numbers."""


def test_a_thrust_beyond_its_limit_delivers_no_more_than_the_limit():
    assert delivered(CROSS, np.array([[30.0, -5.0]])).tolist() == [[10.0, -5.0]]


def test_a_weakened_thruster_delivers_its_share_and_one_that_is_off_nothing():
    weak = CROSS.with_fault(0, 0.5).with_fault(1)
    assert delivered(weak, np.array([[8.0, 8.0]])).tolist() == [[4.0, 0.0]]


def test_wrench_error_is_relative_to_the_demand():
    error = relative_wrench_error(CROSS, np.array([[30.0, 40.0]]), np.array([[6.0, 8.0]]))
    assert error == pytest.approx([40 / 50])


def test_a_tiny_demand_counts_as_one_percent_of_the_wrench_scale():
    error = relative_wrench_error(CROSS, np.zeros((1, 2)), np.array([[0.05, 0.0]]))
    assert error == pytest.approx([0.05 / (0.01 * 10)])


def test_a_demand_gets_nothing_where_no_thrust_is_given_though_some_would_push_along_it():
    """The first thruster can't reverse: of a demand a little astern, cut to one share, nothing is left."""
    ahead = replace(CROSS, f_min=np.array([0.0, -10.0]))
    taus = np.array([[-1.0, 5.0], [-1.0, 5.0], [-1.0, 0.0], [1.0, 5.0], [0.0, 0.0], [-1.0, 5.0]])
    F = np.array([[0.0, 0.0], [0.0, 5.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [np.nan, np.nan]])
    assert gets_nothing(ahead, taus, F).tolist() == [True, False, False, True, False, False]
    none = (np.zeros((6, 2)), np.zeros((6, 2)))  # limits of the call in which nothing can push
    assert not gets_nothing(ahead, taus, F, none).any()


@pytest.mark.parametrize("angle", [0.0, 1e-6, 3.0, 90.0, 179.0])
def test_direction_error_is_the_angle_between_demanded_and_delivered(angle: float):
    turned = 5 * np.array([[np.cos(np.radians(angle)), np.sin(np.radians(angle))]])
    error = direction_error_deg(CROSS, np.array([[8.0, 0.0]]), turned)
    assert error == pytest.approx([angle], abs=1e-12)


def test_direction_error_is_nan_where_nothing_is_demanded_or_delivered():
    taus, F = np.array([[0.0, 0.0], [5.0, 0.0]]), np.array([[5.0, 0.0], [0.0, 0.0]])
    assert np.isnan(direction_error_deg(CROSS, taus, F)).all()


def test_effort_counts_only_where_the_wrench_is_met_inside_the_limits():
    ukwial = load_vehicle("ukwial")
    null = np.linalg.svd(ukwial.T)[2][-1]
    taus = np.array([[100.0, 20.0, 5.0]])
    least = taus @ generalized_inverse(ukwial).T
    more = least + 10.0 * null
    expected = 100.0 / float(np.sum(least**2))  # H = I and the null vector is orthogonal to f*
    assert effort_over_optimum(ukwial, taus, more, least) == pytest.approx([expected])
    for wrong in (0.5 * least, least + 1000 * null, least * np.nan):
        assert np.isnan(effort_over_optimum(ukwial, taus, wrong, least)).all()


def test_the_weight_of_each_thruster_counts_in_the_effort():
    wide = replace(CROSS, T=[[1.0, 1.0], [0.0, 0.0]], dof=("surge", "sway"))
    least, other = np.array([[4.0, 1.0]]), np.array([[1.0, 4.0]])  # weights 1 and 4
    effort = effort_over_optimum(wide, np.array([[5.0, 0.0]]), other, least)
    assert effort == pytest.approx([(1 + 4 * 16) / (16 + 4 * 1) - 1])


def test_loss_of_four_answers_is_as_worked_out_by_hand():
    taus = np.array([[5.0, 5.0], [20.0, 0.0], [1.0, 1.0], [9.0, 9.0]])
    F = np.array([[5.0, 5.0], [20.0, 0.0], [np.nan, np.nan], [10.0, 9.4]])
    numbers = loss(CROSS, taus, F, np.full_like(F, np.nan))
    assert numbers["answered_share"] == 3 / 4
    assert numbers["limits_violated_share"] == pytest.approx(1 / 3)
    assert numbers["thrusters_saturated_mean"] == pytest.approx(2 / 3)
    assert numbers["thrusters_saturated_max"] == 1
    assert numbers["within_1pct_share"] == 1 / 4
    assert numbers["lost_wrench_max"] == pytest.approx(0.5)
    assert numbers["wrench_error_surge_max_N"] == pytest.approx(10.0)
    assert numbers["wrench_error_sway_max_N"] == pytest.approx(0.4)
    assert numbers["effort_over_optimum_max"] is None


def test_the_wrench_error_of_a_moment_is_named_in_newton_metres():
    ukwial = load_vehicle("ukwial")
    numbers = loss(ukwial, np.zeros((1, 3)), np.zeros((1, 4)), np.zeros((1, 4)))
    assert {"wrench_error_surge_max_N", "wrench_error_yaw_max_Nm"} < set(numbers)


def test_a_method_that_never_answers_has_shares_and_no_other_numbers():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        numbers = loss(CROSS, np.ones((2, 2)), np.full((2, 2), np.nan), np.ones((2, 2)))
    assert numbers.pop("answered_share") == 0
    assert numbers.pop("within_1pct_share") == numbers.pop("within_5pct_share") == 0
    assert set(numbers.values()) == {None}
