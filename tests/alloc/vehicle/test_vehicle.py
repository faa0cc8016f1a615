"""A vehicle made in code: its faults, what it refuses, and that its arrays can't change."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from alloc import Vehicle, load_vehicle
from alloc.errors import DemandError, VehicleError

FOUR = Vehicle(
    name="four",
    dof=("surge", "sway", "yaw"),
    T=np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0], [-0.5, 0.5, 1.0, -1.0]]),
    H=np.eye(4),
    f_min=np.array([-1.0, -2.0, -3.0, -4.0]),
    f_max=np.array([5.0, 6.0, 7.0, 8.0]),
    readiness=np.ones(4),
    slack_weights=np.ones(3),
)


def test_weakening_a_thruster_that_is_off_is_refused_since_its_limits_are_lost() -> None:
    off = FOUR.with_fault(2)
    with pytest.raises(VehicleError, match="four-f2: thruster 2 is off, and its limits with it; weaken"):
        off.with_fault(2, readiness=0.5)
    weak = FOUR.with_fault(2, readiness=0.5)
    assert (weak.f_min[2], weak.f_max[2]) == (-3.0, 7.0)


def test_switching_a_thruster_off_twice_changes_nothing() -> None:
    off = FOUR.with_fault(2)
    assert off.with_fault(2).name == "four-f2"
    np.testing.assert_array_equal(off.with_fault(2).readiness, [1.0, 1.0, 0.0, 1.0])


def test_readiness_is_set_not_multiplied() -> None:
    weak = FOUR.with_fault(1, 0.5).with_fault(1, 0.4)
    assert weak.readiness[1] == 0.4
    assert (weak.f_min[1], weak.f_max[1]) == (-2.0, 6.0)
    assert weak.with_fault(1).f_max[1] == 0.0


@pytest.mark.parametrize(("thruster", "readiness"), [(-1, 0.0), (4, 0.0), (0, -0.1), (0, 1.1), (0, np.nan)])
def test_a_fault_of_no_thruster_or_beyond_0_to_1_is_refused(thruster: int, readiness: float) -> None:
    with pytest.raises(VehicleError, match=r"no thruster|readiness"):
        FOUR.with_fault(thruster, readiness)


@pytest.mark.parametrize("thruster", [True, np.True_, 1.0, np.float64(1.0), None, [1], np.array([0, 1])])
def test_what_is_neither_index_nor_name_is_no_thruster(thruster: Any) -> None:
    """True beside other numbers was thruster 1."""
    with pytest.raises(VehicleError, match=r"there is no thruster .*; count from 0 to 3"):
        FOUR.with_fault(thruster)
    with pytest.raises(DemandError, match="there is no thruster"):
        FOUR.limits(blocked=[thruster])
    assert FOUR.with_fault(np.int64(1)).faults == ((1, 0.0),)


@pytest.mark.parametrize(
    "key",
    [
        "T", "H", "f_min", "f_max", "readiness", "slack_weights",
        "TP", "working", "row_lengths",
    ],
)  # fmt: skip
def test_the_arrays_of_a_vehicle_are_read_only(key: str) -> None:
    array = getattr(load_vehicle("ukwial"), key)
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 0


@pytest.mark.parametrize(
    "value", [[1.0, "a", 1.0, 1.0], [1.0, 2.0j, 0.0, 0.0], [[1.0], [1.0, 2.0]], ["1"] * 4]
)
def test_values_that_are_no_array_of_numbers_are_refused_with_their_key(value: Any) -> None:
    with pytest.raises(VehicleError, match="four: f_max is not an array of numbers") as refused:
        replace(FOUR, f_max=value)
    assert refused.value.key == "f_max"


def test_an_h_that_is_symmetric_but_for_rounding_is_kept_as_it_is() -> None:
    R = np.linalg.qr(np.random.default_rng(0).normal(size=(4, 4)))[0]
    H = R @ (3.0 * np.eye(4)) @ R.T
    assert (H != H.T).any()
    np.testing.assert_array_equal(replace(FOUR, H=H).H, H)


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_an_h_that_is_not_symmetric_is_refused_whatever_its_size(size: float) -> None:
    H = np.diag([size, size, size, 1.0])
    H[0, 1] = 1e-9 * size
    with pytest.raises(VehicleError, match="symmetric"):
        replace(FOUR, H=H)
